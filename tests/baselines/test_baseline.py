"""What all baselines share, on the smallest law."""

import numpy as np
import pytest

from baselines.baseline import Baseline
from drillrig_env.env.sensors import Sensors


class Counter(Baseline):
    """Wants the target plus the number of calls so far, and a tenth of a normal force that it is told."""

    channels = ("speed_reference", "speed_target", "bit_speed")
    privileged = ("normal_force",)
    memory = 2
    tuned_values = {"state": {"gain": 1.0, "time": 2.0}, "surface": {"gain": 3.0, "time": 4.0}}  # noqa: RUF012

    def desired_reference(self, seen, privileged, memory):
        memory[:, 0] += 1.0
        return seen["speed_target"] + memory[:, 0] + 0.1 * privileged["normal_force"]


SENSORS = ("bit_speed", "speed_reference", "speed_target")


def observation(reference, target=3.0):
    values = {"bit_speed": target, "speed_reference": reference, "speed_target": target}
    channels = Sensors.named(SENSORS).channels
    offsets = [target if channel.offset == "target" else channel.offset for channel in channels]
    return np.array(
        [(values[c.name] - offset) / c.scale for c, offset in zip(channels, offsets, strict=True)], np.float32
    )


def test_action_is_the_rate_towards_the_wanted_reference_at_most_the_slew_limit():
    policy = Counter(SENSORS, slew_limit=4.0)
    policy.tell({"normal_force": 0.0})
    for reference, action in ((3.9, 0.25), (4.0, 0.0), (4.2, -0.5), (2.0, 1.0), (9.0, -1.0)):
        actions, _ = policy.predict(observation(reference)[None])
        assert actions[0, 0] == pytest.approx(action, abs=1e-5)
        assert actions.dtype == np.float32


def test_one_observation_gives_one_action_and_a_batch_a_batch():
    policy = Counter(SENSORS)
    policy.tell({"normal_force": np.array([0.0, 1.0])})
    assert policy.predict(np.stack([observation(3.0)] * 2))[0].shape == (2, 1)
    policy.tell({"normal_force": 0.0})
    assert policy.predict(observation(3.0))[0].shape == (1,)


def test_memory_is_handed_on_begun_anew_where_an_episode_starts_and_never_changed_behind_ones_back():
    policy = Counter(SENSORS)
    policy.tell({"normal_force": np.zeros(2)})
    batch = np.stack([observation(3.0)] * 2)
    _, first = policy.predict(batch)
    _, second = policy.predict(batch, first, np.array([False, True]))
    assert first[0][:, 0].tolist() == [1.0, 1.0]
    assert second[0][:, 0].tolist() == [2.0, 1.0]
    _, third = policy.predict(batch, second)
    assert third[0][:, 0].tolist() == [3.0, 2.0]
    assert second[0].shape == (2, 2)


def test_who_is_told_takes_the_last_word():
    policy = Counter(SENSORS, slew_limit=100.0)
    with pytest.raises(RuntimeError, match="Counter is told normal_force: call tell"):
        policy.predict(observation(3.0))
    for force in (10.0, 20.0):
        policy.tell({"normal_force": force, "mu_s": 0.5})
        action, _ = policy.predict(observation(3.0))
        assert 3.0 + 10.0 * action[0] == pytest.approx(3.0 + 1.0 + 0.1 * force, abs=1e-4)


@pytest.mark.parametrize(
    ("sensors", "gain"),
    [
        ("state", 1.0),
        (SENSORS, 1.0),
        (("string_torque", *SENSORS), 3.0),  # the drive's estimate, as at the surface
        (("string_torque", "collar_speed", "top_speed", *SENSORS), 1.0),  # both ends of the upper shaft are seen
        (("string_torque", "top_speed", *SENSORS), 3.0),
    ],
)
def test_values_are_those_of_the_sensors_or_of_the_most_alike(sensors, gain):
    assert Counter(sensors)._given_or_tuned(gain=None, time=7.0) == {"gain": gain, "time": 7.0}


def test_sensors_that_show_too_little_are_refused_with_those_that_would_do():
    with pytest.raises(ValueError, match=r"Counter reads bit_speed, which .* sensors that would do: state, encoders$"):
        Counter("surface")


def test_one_of_several_groups_of_channels_is_enough():
    class Either(Counter):
        any_of = (("twist_12", "twist_23"), ("current",))

    for more in (("twist_12", "twist_23"), ("current",)):
        assert Either((*SENSORS, *more)).sensors.names[3:] == more
    with pytest.raises(ValueError, match=r"reads one of \(twist_12, twist_23\) or \(current\)"):
        Either((*SENSORS, "twist_12"))
    with pytest.raises(ValueError, match=r"reads bit_speed and one of"):
        Either(("speed_reference", "speed_target"))


def test_a_baseline_asks_for_no_drive_of_its_own_and_has_the_chapters_rig():
    policy = Counter(SENSORS)
    assert policy.drive is None
    assert policy.rig.J_1 == 0.0288
    assert Counter(SENSORS, rig={"J_1": 0.03}).rig.J_1 == 0.03
