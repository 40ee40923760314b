import numpy as np
import pytest

from baselines.string_torque import MEMORY, OSCILLATION_MEMORY, check_filters, oscillation, torque_deviation
from drillrig_env import Rig
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.model import torque_into_string

RIG = Rig()


def watch(sensors, time_constant, steps=300):
    """Deviations from some sensors, and the true torque, step by step, of one rig in stick-slip."""
    core = EpisodeBatch(1, scenario="nominal", sensors=sensors, noise=0.0, delay=0)
    core.reset(
        np.arange(1),
        first_uniforms(0, 1),
        {"normal_force": 20.0, "speed_target": 2.5, "start": "stick_slip"},
    )
    memory, deviations, torques = np.zeros((1, MEMORY)), [], []
    for _ in range(steps):
        seen = core.sensors.values(core.observations)
        deviations.append(torque_deviation(RIG, seen, memory, time_constant)[0])
        torques.append(float(torque_into_string(RIG, core.episodes["state"][0, :7])))
        core.step(np.zeros((1, 1), np.float32))
    return np.array(deviations), np.array(torques)


def test_deviation_is_the_torque_less_its_running_mean_and_then_its_low_pass():
    deviations, torques = watch("state", 5.0)
    for n in (0, 10, 40):
        assert deviations[n] == pytest.approx(torques[n] - torques[: n + 1].mean(), abs=1e-5)
    mean = torques[:50].mean()
    for n in range(50, 300):
        mean += 0.1 / 5.0 * (torques[n] - mean)
        assert deviations[n] == pytest.approx(torques[n] - mean, abs=1e-5)


@pytest.mark.parametrize(("sensors", "tolerance"), [("encoders", 0.06), ("surface", 0.15)])
def test_other_sensors_give_nearly_the_deviation_that_the_state_gives(sensors, tolerance):
    """Encoders integrate with a trapezoid; the drive's estimate is a mean over the step, half a step late."""
    exact, torques = watch("state", 5.0)
    deviations, _ = watch(sensors, 5.0)
    assert np.std((deviations - exact)[50:]) < tolerance * np.std(torques)


def test_oscillation_finds_amplitude_and_phase_through_noise():
    frequency = RIG.string_frequencies[0]
    time = 0.1 * np.arange(200)
    noise = np.random.default_rng(0).normal(0.0, 0.1, time.size)
    memory = np.zeros((1, OSCILLATION_MEMORY))
    found = [
        oscillation(RIG, np.array([0.3 * np.cos(2 * np.pi * frequency * t) + e]), memory, 0.1)[0]
        for t, e in zip(time, noise, strict=True)
    ]
    turned_back = np.array(found[60:]) * np.exp(-2j * np.pi * frequency * time[60:])
    assert np.abs(turned_back.mean() - 0.3) < 0.04
    assert np.abs(turned_back - 0.3).std() < 0.05  # half of the noise or less


def test_follow_of_one_takes_the_deviation_as_it_is():
    memory = np.zeros((3, OSCILLATION_MEMORY))
    for _ in range(5):
        deviation = np.random.default_rng(1).normal(size=3)
        np.testing.assert_allclose(oscillation(RIG, deviation, memory, 1.0).real, deviation, rtol=1e-12)


def test_impossible_filters_are_refused():
    with pytest.raises(ValueError, match=r"ZTorque: time_constant = 0.0 s is not allowed; allowed: > 0 s"):
        check_filters("ZTorque", 0.0, 0.5)
    with pytest.raises(ValueError, match=r"follow = 1.5 is not allowed; allowed: > 0 and <= 1"):
        check_filters("SpeedPulse", 5.0, 1.5)
