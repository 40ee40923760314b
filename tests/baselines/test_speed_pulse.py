import numpy as np
import pytest

from baselines import SpeedPulse
from tests.baselines.episode import BISTABLE, play


@pytest.mark.parametrize("sensors", ["state", "encoders", "surface"])
def test_frees_a_bistable_rig_and_leaves_it_alone_then(sensors):
    info, references = play(SpeedPulse(sensors), {**BISTABLE, "speed_target": 3.6})
    assert info["is_success"]
    assert references[:300].max() > 3.6
    np.testing.assert_allclose(references[-100:], 3.6, atol=1e-4)


def test_pulses_are_apart_and_last_as_long_as_they_are_planned():
    policy = SpeedPulse(strength=3.0, length=0.5, pause=1.0)
    frequency = policy.rig.string_frequencies[0]
    _, references = play(policy, {**BISTABLE, "speed_target": 1.5})
    rises = np.flatnonzero((references[1:] > references[:-1] + 0.01) & (references[:-1] < 1.5 + 1e-3))
    assert len(rises) > 3  # below the critical speed it has to go on
    assert np.diff(rises).min() * 0.1 >= 1.5 / frequency - 0.2


def test_does_nothing_to_a_calm_rig_or_within_the_first_cycle():
    _, references = play(SpeedPulse(), {"normal_force": 10.0, "speed_target": 4.0, "start": "steady"})
    np.testing.assert_allclose(references, 4.0, atol=1e-4)
    policy = SpeedPulse()
    _, references = play(policy, BISTABLE)
    np.testing.assert_allclose(references[: int(10.0 / policy.rig.string_frequencies[0])], 3.2, atol=1e-4)


def test_refuses_sensors_without_torque():
    with pytest.raises(ValueError, match=r"SpeedPulse reads one of .*string_torque.* would do: state, encoders"):
        SpeedPulse(("bit_speed", "speed_reference", "speed_target"))
    with pytest.raises(ValueError, match=r"SpeedPulse: follow = 0 is not allowed"):
        SpeedPulse(follow=0)
