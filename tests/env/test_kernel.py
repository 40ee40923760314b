"""One control step and one start, against the same physics worked out elsewhere."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.model import wound_up
from drillrig_env.stability import stick_slip_orbit

STICKING = {"start": "stick_slip", "normal_force": 20.0, "speed_target": 2.0, "load_steps": []}


def begin(options, rigs=1, phases=None, **arguments):
    core = EpisodeBatch(rigs, scenario="nominal", threads=1, **arguments)
    uniforms = first_uniforms(1, rigs)
    if phases is not None:
        uniforms[:, 6] = phases
    core.reset(np.arange(rigs), uniforms, options)
    return core


def run(core, steps, action=0.0):
    rows = []
    for k in range(steps):
        core.step(np.full((len(core), 1), action * np.sin(0.7 * k), dtype=np.float32))
        rows.append(core.episodes[0].copy())
    return np.array(rows)


def test_verdict_window_is_the_last_ten_seconds_and_no_step_more_or_less():
    core = begin(STICKING, duration=14.0)
    rows = run(core, 140)
    tail, end = rows[-100:], core.episodes[0]
    assert end["window_sum"] == pytest.approx(tail["average"].sum(), rel=1e-12)
    assert end["window_lowest"] == tail["lowest"].min()
    assert end["window_highest"] == tail["highest"].max()


@pytest.mark.parametrize(("step", "counts"), [(39, False), (40, True), (139, True)])
def test_a_peak_counts_from_the_first_step_of_the_window_to_its_last(step, counts):
    core = begin({"start": "steady", "normal_force": 5.0, "speed_target": 4.0, "load_steps": []}, duration=14.0)
    run(core, step)
    core.episodes["state"][0, 2] += 2.0  # a blow on the bit
    blow = run(core, 1)["highest"][0]
    run(core, 139 - step)
    assert core.ended[0]
    assert (core.episodes["window_highest"][0] == blow) == counts


@pytest.mark.parametrize("gains", [None, (0.6, 0.06), (0.6, 0.06, 1.0), (0.6, 0.06, 0.4)])
def test_voltage_is_what_the_armature_needs(gains):
    """In steady rotation V = R x_6 + eta K_E x_5, whatever drive makes it."""
    core = begin({"start": "steady", "normal_force": 10.0, "speed_target": 4.0, "load_steps": []}, drive=gains)
    rig, needed = Rig(), lambda x: Rig().R * x[5] + Rig().eta * Rig().K_E * x[4]
    assert core.episodes["voltage"][0] == pytest.approx(needed(core.episodes["state"][0]), rel=1e-9)
    end = run(core, 50)[-1]
    assert end["state"][4] == pytest.approx(4.0, abs=1e-6)
    assert end["voltage"] == pytest.approx(needed(end["state"]), rel=1e-6)
    assert rig.eta * rig.K_E * 4.0 > 0.5 * end["voltage"]  # most of it is the back-EMF


def test_phase_counts_control_steps_from_the_first_settled_moment():
    """A rig at the phase p is where the rig at phase 0 is after p periods, rounded down to control steps."""
    phases = np.array([0.0, 0.25, 0.5, 0.999])
    states = begin(STICKING, 4, phases).episodes["state"][:, :7]
    friction = Friction(20.0)
    long = simulate(None, friction, wound_up(Rig(), friction, 2.0), 2.0, duration=18.0, sample_period=0.1).state
    found = [int(np.argmin(np.abs(long - x).max(axis=1))) for x in states]
    np.testing.assert_allclose(long[found], states, atol=1e-7)
    assert found[0] == 121  # 12 s and the step after
    period = stick_slip_orbit(Rig(), friction, 2.0).period / 0.1
    allowed = [{int(phase * np.floor(period)), int(phase * np.ceil(period))} for phase in phases]
    assert all(place - found[0] in steps for place, steps in zip(found, allowed, strict=True))


def test_a_rig_whose_oscillation_dies_starts_in_steady_rotation():
    core = begin({**STICKING, "normal_force": np.array([20.0, 2.0, 0.0])}, 3)
    assert core.starts(np.arange(3)) == ["stick_slip", "steady", "steady"]
    np.testing.assert_allclose(core.episodes["state"][1:, 2:5], 2.0)


def test_running_statistics_of_the_torque_have_their_documented_times():
    """A mean of 10 s and a deviation from it of 2.5 s, both over control steps."""
    core = begin(STICKING, duration=20.0)
    mean, variance = (float(core.episodes[name][0]) for name in ("torque_mean", "torque_variance"))
    for row in run(core, 200, action=0.5):
        deviation = row["string_torque"] - mean
        mean += (1.0 - np.exp(-0.1 / 10.0)) * deviation
        variance += (1.0 - np.exp(-0.1 / 2.5)) * (deviation**2 - variance)
        assert row["torque_mean"] == pytest.approx(mean, rel=1e-9)
        assert row["torque_variance"] == pytest.approx(variance, rel=1e-9)
    assert variance > 1e-3


def test_samples_of_a_step_make_its_statistics():
    """Against the simulation at 16 samples a control step."""
    core = begin(STICKING)
    start = core.episodes[0].copy()
    rows = run(core, 30)
    fine = simulate(None, Friction(20.0), start["state"][:7], 2.0, duration=3.0, sample_period=0.1 / 16)
    speed, torque = (x[1:].reshape(30, 16) for x in (fine.bit_speed, fine.torque_into_string))
    for name, expected in (
        ("lowest", speed.min(axis=1)),
        ("highest", speed.max(axis=1)),
        ("average", speed.mean(axis=1)),
        ("highest_torque", torque.max(axis=1)),
        ("torque_into_string", torque[:, -1]),
        ("string_torque", torque.mean(axis=1)),
    ):
        np.testing.assert_allclose(rows[name], expected, atol=1e-6, err_msg=name)
    np.testing.assert_array_equal(rows["stuck"], (speed < 0.01).mean(axis=1))
    assert 0.0 < rows["stuck"].mean() < 1.0


def test_an_episode_that_is_over_stands_still():
    core = begin(STICKING, duration=1.0)
    run(core, 10)
    end = core.episodes.copy()
    run(core, 3, action=1.0)
    np.testing.assert_array_equal(core.episodes["state"], end["state"])
    assert core.episodes["step"][0] == 10


def test_noise_is_that_of_a_known_generator():
    """SplitMix64 from the seed 1234567: the first numbers of its reference implementation, turned by Box and Muller."""
    words = [6457827717110365317, 3203168211198807973]
    u = [(word >> 11) * 2.0**-53 for word in words]
    expected = np.sqrt(-2.0 * np.log(1.0 - u[0])) * np.cos(2.0 * np.pi * u[1])
    core = EpisodeBatch(1, scenario="nominal", sensors=("bit_speed", "speed_target"), noise={"bit_speed": 0.3})
    core.reset(np.arange(1), first_uniforms(1, 1), {"start": "steady", "speed_target": 4.0, "load_steps": []})
    core.episodes["noise"] = 1234567
    core.step(np.zeros((1, 1), np.float32))
    error = core.sensors.value(core.observations, "bit_speed")[0] - core.episodes["state"][0, 2]
    assert error == pytest.approx(0.3 * expected, abs=1e-6)


def test_a_step_counts_the_rigs_whose_state_is_lost():
    core = begin(STICKING, rigs=3)
    step = core.bound_step(np.zeros((3, 1), dtype=np.float32), np.zeros_like(core.observations))
    for lost in (0, 1, 2):
        core.episodes["state"][:lost, 2] = np.nan
        assert step() == lost
