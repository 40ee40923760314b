import numpy as np
import pytest

from baselines import Constant, ZTorque
from baselines.tune import tuning_suite
from drillrig_env import Rig
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from tests.baselines.episode import BISTABLE, LOAD_STEP, UNSTABLE, play


@pytest.mark.parametrize("sensors", ["state", "encoders", "surface"])
def test_frees_a_bistable_rig(sensors):
    assert play(ZTorque(sensors), BISTABLE)[0]["is_success"]


@pytest.mark.parametrize("sensors", ["state", "encoders", "surface"])
def test_holds_rotation_below_the_critical_speed(sensors):
    assert play(ZTorque(sensors), UNSTABLE)[0]["is_success"]


def test_keeps_out_under_a_load_step():
    assert play(ZTorque(), LOAD_STEP)[0]["is_success"]


def test_holds_steady_rotation_that_the_stiff_drive_loses():
    disturbed = {"normal_force": 20.0, "speed_target": 2.2, "start": "steady", "load_steps": [(1.0, 22.0)]}
    assert not play(Constant(), disturbed)[0]["is_success"]
    assert play(ZTorque(), disturbed)[0]["is_success"]


def test_the_reference_gives_way_by_the_torque_over_the_impedance():
    """With `follow` 1 and neither lead nor lift, the law is omega* - (T_s - LP(T_s)) / Z to the letter."""
    policy = ZTorque(("string_torque", "speed_reference", "speed_target"), gain=5.0, follow=1.0, lead=0.0, lift=0.0)
    memory = np.zeros((1, policy.memory))
    torques = [0.30, 0.36, 0.24]
    for step, torque in enumerate(torques):
        seen = {"string_torque": np.array([torque]), "speed_reference": np.ones(1), "speed_target": np.array([3.0])}
        desired = policy.desired_reference(seen, {}, memory)
        mean = np.mean(torques[: step + 1])
        assert desired[0] == pytest.approx(3.0 - 5.0 * (torque - mean))


def test_the_lift_comes_with_shaking_and_goes_with_calm():
    policy = ZTorque(gain=0.0, lift=5.0)
    memory = np.zeros((1, policy.memory))
    frequency = Rig().string_frequencies[0]

    def desired(swing, seconds):
        for t in 0.1 * np.arange(10.0 * seconds):
            seen = {name: np.zeros(1) for name in policy.sensors.names}
            seen["twist_23"] = -np.ones(1) + swing * np.cos(2.0 * np.pi * frequency * t)
            seen["speed_target"] = np.array([2.0])
            reference = policy.desired_reference(seen, {}, memory)
        return float(reference[0])

    assert desired(0.02, 20.0) == 2.0  # a swing that calm rotation may show
    assert desired(0.7, 20.0) > 2.5
    assert desired(0.02, 60.0) == 2.0


def test_reaches_its_mark_on_random_rigs():
    """0.90 of rigs in stick-slip, 0.75 below the critical speed, told nothing; on rigs that no suite has."""
    scores = score(run(ZTorque(), tuning_suite("default", 200, 590_000_000)))
    assert scores["mitigated"].mean() > 0.90
    assert scores["mitigated"][scores["region"] == "below"].mean() > 0.75


def test_refuses_sensors_without_torque():
    with pytest.raises(
        ValueError, match=r"ZTorque reads one of \(twist_23.*\(string_torque\).*would do: state, encoders, surface"
    ):
        ZTorque(("top_speed", "current", "speed_reference", "speed_target"))


def test_gains_follow_the_sensors_where_none_are_given():
    assert ZTorque("encoders").gain == ZTorque("state").gain
    custom = ("string_torque", "speed_reference", "speed_target")
    assert ZTorque(custom).gain == ZTorque("surface").gain != ZTorque("state").gain
    assert ZTorque("surface", gain=1.5).gain == 1.5
    with pytest.raises(ValueError, match=r"ZTorque: time_constant = 0.0 s is not allowed"):
        ZTorque(time_constant=0.0)
