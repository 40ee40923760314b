from pathlib import Path

import numpy as np
import pytest

from drillrig_env import Friction, Rig, observation_table, simulate
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.sensors import LIMIT, SENSORS, Sensors
from drillrig_env.env.single import DrillRigEnv
from drillrig_env.model import STATE_NAMES


def test_observations_turn_back_into_physical_values_by_name():
    core = EpisodeBatch(50)
    core.reset(np.arange(50), first_uniforms(0, 50))
    for _ in range(20):
        core.step(np.full((50, 1), 0.5, np.float32))
    values = core.sensors.values(core.observations)
    for column, name in enumerate(STATE_NAMES):
        np.testing.assert_allclose(values[name], core.episodes["state"][:, column], atol=1e-5)
    np.testing.assert_allclose(values["bit_speed_mean"], core.episodes["mean"], atol=1e-5)
    np.testing.assert_allclose(values["bit_speed_deviation"], np.sqrt(core.episodes["variance"]), atol=1e-5)
    assert set(values) == set(core.sensors.names)


def test_observations_are_about_one_on_the_default_draws():
    core = EpisodeBatch(300)
    core.reset(np.arange(300), first_uniforms(0, 300))
    seen = []
    for _ in range(300):
        core.step(np.zeros((300, 1), np.float32))
        seen.append(core.observations)
    deviation = np.concatenate(seen).std(axis=0)
    assert np.all((deviation > 0.2) & (deviation < 2.0))
    assert np.abs(np.concatenate(seen)).max() < LIMIT


def test_unknown_names_are_refused():
    with pytest.raises(ValueError, match="did you mean bit_speed"):
        Sensors.named("state").value(np.zeros(11), "bitspeed")
    with pytest.raises(ValueError, match="allowed: state"):
        Sensors.named("radar")


def batch(sensors="state", rigs=40, options=None, **arguments):
    core = EpisodeBatch(rigs, sensors=sensors, threads=1, **arguments)
    core.reset(np.arange(rigs), first_uniforms(0, rigs), options)
    return core


def steps(core, count, action=0.0):
    seen = [core.observations]
    for k in range(count):
        core.step(np.full((len(core), 1), action * np.sin(0.3 * k), np.float32))
        seen.append(core.observations)
    return np.array(seen)


def test_noise_has_the_stated_deviation_and_is_white_and_the_controllers_own_numbers_have_none():
    clean, noisy = (steps(batch("surface", noise=noise, delay=0), 400, 0.5) for noise in (0.0, 2.0))
    sensors = Sensors.named("surface")
    for i, channel in enumerate(sensors.channels):
        error = (noisy[..., i] - clean[..., i]) * channel.scale
        expected = 2.0 * channel.noise if channel.measured else 0.0
        assert error.std() == pytest.approx(expected, rel=0.05, abs=1e-7)
        if expected:
            assert abs(np.corrcoef(error[1:].ravel(), error[:-1].ravel())[0, 1]) < 0.03
            assert abs(np.corrcoef(error[:, 0], error[:, 1])[0, 1]) < 0.2  # rig by rig its own
            assert abs((error**3).mean()) < 0.2 * expected**3
            assert (error**4).mean() == pytest.approx(3.0 * expected**4, rel=0.15)


def test_noise_by_channel_leaves_the_others_clean():
    clean, noisy = (steps(batch(noise=noise), 50) for noise in (0.0, {"bit_speed": 0.3}))
    different = np.any(clean != noisy, axis=(0, 1))
    assert np.flatnonzero(different).tolist() == [Sensors.named("state").names.index("bit_speed")]


@pytest.mark.parametrize("delay", [1, 4])
def test_measurements_come_late_and_the_controllers_own_numbers_do_not(delay):
    prompt, late = (steps(batch("surface", noise=0.0, delay=d), 60, 1.0) for d in (0, delay))
    for i, channel in enumerate(Sensors.named("surface").channels):
        if channel.measured:
            np.testing.assert_array_equal(late[delay:, :, i], prompt[:-delay, :, i])
            np.testing.assert_array_equal(
                late[:delay, :, i], np.broadcast_to(prompt[0, :, i], late[:delay, :, i].shape)
            )
        else:
            np.testing.assert_array_equal(late[..., i], prompt[..., i])


def test_a_range_of_delays_is_drawn_rig_by_rig():
    core = batch(rigs=600, delay=(1, 5))
    counts = np.bincount(core.episodes["delay"], minlength=6)
    assert counts[0] == 0
    assert counts[1:].min() > 80


def test_drive_knows_the_torque_into_the_string_from_current_and_top_speed():
    """(4-5c) averaged over a control step, from samples of every millisecond: the channel, within 0.005 N m."""
    rig, friction = Rig(), Friction(20.0)
    options = {"normal_force": 20.0, "speed_target": 2.0, "start": "rest"}
    core = batch(rigs=1, scenario="nominal", options=options)
    reference, channel = [], []
    for k in range(200):
        core.step(np.full((1, 1), np.sin(0.5 * k) + (k < 15), np.float32))
        reference.append((0.1 * k, float(core.episodes["speed_reference"][0])))
        channel.append(float(core.episodes["string_torque"][0]))
    run = simulate(rig, friction, speed_reference=reference, duration=20.0, sample_period=1e-3)
    current, top = (x[:-1].reshape(200, 100) for x in (run.current, run.top_speed))
    change = np.diff(run.top_speed[::100]) / 0.1
    drive = rig.eta * (rig.K_T * current.mean(1) - rig.T_f) - rig.eta**2 * rig.C_m * top.mean(1) - rig.J_3 * change
    assert np.ptp(channel) > 0.5
    assert np.abs(drive - channel).max() < 0.005


def test_soft_drive_starts_where_the_stiff_one_does_without_a_jump_of_the_voltage():
    stiff, soft = batch(("voltage", "bit_speed")), batch(("voltage", "bit_speed"), drive=(0.04, 0.06, 1.0))
    np.testing.assert_allclose(stiff.observations, soft.observations, atol=1e-6)
    mechanical = [0, 1, 2, 3, 4, 5]
    np.testing.assert_array_equal(stiff.episodes["state"][:, mechanical], soft.episodes["state"][:, mechanical])
    top = [np.ptp(steps(core, 100)[..., 0]) for core in (stiff, soft)]
    assert soft.rig == stiff.rig
    assert not np.allclose(stiff.episodes["state"], soft.episodes["state"])
    assert top[0] != top[1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"noise": -1.0}, "noise = -1.0"),
        ({"noise": {"bitspeed": 0.1}}, "did you mean bit_speed"),
        ({"noise": {"speed_target": 0.1}}, "not a measured channel"),
        ({"noise": {"bit_speed": -0.1}}, "bit_speed = -0.1 rad/s"),
        ({"delay": 0.5}, "delay = 0.5 control steps"),
        ({"delay": 11}, "delay = 11"),
        ({"delay": (3, 1)}, r"delay = \(3, 1\)"),
        ({"sensors": ("bit_sped",)}, "did you mean bit_speed"),
        ({"sensors": ()}, "one or more different names"),
        ({"sensors": ("bit_speed", "bit_speed")}, "one or more different names"),
    ],
)
def test_what_is_not_allowed_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        EpisodeBatch(1, **arguments)


def test_sensors_of_ones_own():
    core = batch(("bit_speed", "speed_target"))
    np.testing.assert_allclose(
        core.sensors.value(core.observations, "bit_speed"), core.episodes["state"][:, 2], atol=1e-6
    )


def test_docstring_of_the_environment_holds_the_tables_of_both_ids():
    text = "\n".join(line.strip() for line in DrillRigEnv.__doc__.splitlines())
    for sensors in ("state", "surface"):
        assert observation_table(sensors) in text


def test_page_of_the_environments_holds_the_tables():
    page = (Path(__file__).parents[2] / "docs" / "environment.md").read_text(encoding="utf-8")
    for sensors in SENSORS:
        assert observation_table(sensors) in page


def test_values_without_a_target_are_those_that_need_none():
    core = batch(("bit_speed", "top_speed", "current"))
    assert list(core.sensors.values(core.observations)) == ["current"]
    target = core.episodes["speed_target"]
    values = core.sensors.values(core.observations, speed_target=target)
    assert list(values) == ["bit_speed", "top_speed", "current"]
    np.testing.assert_allclose(values["bit_speed"], core.episodes["state"][:, 2], atol=1e-6)
    assert core.sensors.value(core.observations[0], "bit_speed", 3.0).shape == ()
    with pytest.raises(ValueError, match=r"bit_speed is seen from the speed target.*give speed_target in rad/s"):
        core.sensors.value(core.observations, "bit_speed")


def test_a_target_that_is_given_goes_before_the_one_that_is_seen():
    core = batch(("bit_speed", "speed_target"))
    seen, given = (core.sensors.value(core.observations, "bit_speed", target) for target in (None, 0.0))
    np.testing.assert_allclose(seen - given, core.episodes["speed_target"], atol=1e-6)
