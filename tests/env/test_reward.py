"""The reward's formula and its running statistics, with numbers worked out by hand."""

import gymnasium as gym
import numpy as np
import pytest

from drillrig_env import Reward
from drillrig_env.env.reward_kernel import reward_terms, update_statistics

plain, update = (getattr(kernel, "py_func", kernel) for kernel in (reward_terms, update_statistics))


def terms(*given):
    """The terms as a sum: not in phases."""
    return plain(*given, False, 0.07)


def in_phases(mean, variance, target=2.0, action=0.0, weights=(1.0, 1.0, 1.0), tracking_swing=0.07):
    return plain(mean, variance, target, action, *weights, False, False, True, tracking_swing)


def test_terms_by_hand():
    """A mean of 1.5 at a target of 2 is an error of a quarter; a variance of 0.16 a swing of 0.04."""
    assert terms(1.5, 0.16, 2.0, -0.5, 3.0, 5.0, 7.0, False, False) == pytest.approx((-0.12, -0.3125, -1.75))
    assert terms(1.5, 0.16, 2.0, -0.5, 3.0, 5.0, 7.0, True, True) == pytest.approx((-0.6, -1.25, -1.75))
    assert terms(2.5, 0.0, 2.0, 0.0, 1.0, 1.0, 1.0, False, True) == pytest.approx((0.0, -0.25, 0.0))


@pytest.mark.parametrize("shapes", [(False, False), (True, False), (False, True), (True, True)])
def test_no_reward_is_positive_and_calm_rotation_at_the_target_scores_zero(shapes):
    assert terms(2.0, 0.0, 2.0, 0.0, 1.0, 1.0, 1.0, *shapes) == (0.0, 0.0, 0.0)
    for mean, variance, action in ((0.0, 1.0, 1.0), (4.0, 0.1, -1.0)):
        assert all(term < 0.0 for term in terms(mean, variance, 2.0, action, 1.0, 1.0, 1.0, *shapes))


def test_phases_by_hand():
    """A swing of 0.07 and an error of 0.05 are worth half of what there is; both are over the target and the mean."""
    target, mean = 2.0, 2.1
    shaking, off, effort = in_phases(mean, (0.07 * mean) ** 2, target, 0.5, (2.0, 3.0, 4.0))
    assert shaking == pytest.approx(-2.0 * (1.0 - 0.5 + 0.07 / 2.0))
    assert off == pytest.approx(-3.0 * (1.0 - 0.5 * 0.5 + 0.05 / 10.0))
    assert effort == pytest.approx(-4.0 * 0.25)
    slow = 0.15 * target  # half of the motion from which on a bit counts as turning
    swing, error = 0.5 * 0.2 + 0.5 * 1.5, 0.5 * 0.85 + 0.5 * 2.0
    calm, on = 1.0 / (1.0 + (swing / 0.07) ** 2), 1.0 / (1.0 + (error / 0.05) ** 2)
    found = in_phases(slow, (0.2 * 0.3 * target) ** 2, target)
    assert found == pytest.approx((-(1.0 - calm + swing / 2.0), -(1.0 - calm * on + error / 10.0), 0.0))


def test_in_phases_being_on_target_may_count_while_the_bit_still_shakes():
    """At a swing of 0.2 half of it counts where the tracking swing is that; what calm is worth stays."""
    target, mean = 2.0, 2.1
    shaking, off, _ = in_phases(mean, (0.2 * mean) ** 2, target, tracking_swing=0.2)
    assert off == pytest.approx(-(1.0 - 0.5 * 0.5 + 0.05 / 10.0))
    assert shaking == in_phases(mean, (0.2 * mean) ** 2, target)[0]
    env = gym.make("DrillRig-v0", reward=Reward(0.1, 0.2, 0.003, form="phases", tracking_swing=10.0))
    env.reset(seed=0, options={"start": "stick_slip", "normal_force": 20.0, "speed_target": 1.5})
    _, _, _, _, info = env.step(np.zeros(1, np.float32))
    strict = gym.make("DrillRig-v0", reward="phases")
    strict.reset(seed=0, options={"start": "stick_slip", "normal_force": 20.0, "speed_target": 1.5})
    _, _, _, _, other = strict.step(np.zeros(1, np.float32))
    assert info["reward_tracking"] > other["reward_tracking"]
    assert info["reward_variance"] == other["reward_variance"]
    with pytest.raises(ValueError, match=r"tracking_swing = 0\.2 is not allowed; allowed: 0\.07, but for form"):
        Reward(tracking_swing=0.2)


def test_in_phases_nothing_scores_less_than_standing_still():
    standing = sum(in_phases(0.0, 0.0))
    assert sum(in_phases(0.0, 4.0)) == pytest.approx(standing)
    for mean in (-3.0, -0.1, 0.1, 1.0, 2.0, 3.0, 9.0):
        for deviation in (0.0, 0.1, 1.0, 20.0):
            assert sum(in_phases(mean, deviation**2)) >= standing - 1e-12, (mean, deviation)
    assert sum(in_phases(2.0, 0.0)) == 0.0


def test_in_phases_a_detour_costs_nothing_while_the_bit_shakes_and_the_way_back_pays_once_it_is_calm():
    shaking = [sum(in_phases(mean, (0.8 * mean) ** 2)) for mean in (2.0, 3.0)]
    calm = [sum(in_phases(mean, 0.0)) for mean in (2.0, 2.1, 3.0)]
    assert shaking[0] - shaking[1] < 0.1 * (calm[0] - calm[2])
    assert calm[0] > calm[1] > calm[2] > shaking[0]


def test_reward_in_phases_by_name_and_by_its_fields():
    phases = Reward.of("phases")
    assert phases == Reward(variance=0.1, tracking=0.2, action=0.003, form="phases")
    with pytest.raises(ValueError, match="variance_shape = absolute"):
        Reward(form="phases", variance_shape="absolute")
    with pytest.raises(ValueError, match="form = 'phase'"):
        Reward(form="phase")


def test_running_statistics_are_the_weighted_mean_and_variance_of_the_past():
    """Weights g (1 - g)^k of the samples k steps ago, on a past that was all at the first mean."""
    gain, samples = 0.2, np.array([1.0, 3.0, 2.0, 5.0, 4.0])
    mean, variance = 2.0, 0.0
    for sample in samples:
        mean, variance = update(mean, variance, sample, gain)
    weights = np.array([0.8**5, *(0.2 * 0.8 ** np.arange(4, -1, -1))])
    values = np.array([2.0, *samples])
    assert weights.sum() == pytest.approx(1.0)
    assert mean == pytest.approx(weights @ values)
    assert variance == pytest.approx(weights @ (values - mean) ** 2)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"variance": -1.0}, "variance = -1.0"),
        ({"tracking": -1e-9}, "tracking"),
        ({"action": float("nan")}, "action = nan"),
        ({"time_constant": 0.0}, r"time_constant = 0\.0 s"),
        ({"time_constant": 0.9e-12}, r"time_constant = 9e-13 s .* >= 1e-12"),
        ({"time_constant": 1.1e12}, r"time_constant = 1100000000000\.0 s"),
        ({"variance_shape": "cubic"}, "variance_shape = 'cubic'"),
        ({"tracking_shape": "cubic"}, "tracking_shape = 'cubic'"),
    ],
)
def test_impossible_rewards_are_refused(fields, words):
    with pytest.raises(ValueError, match=words):
        Reward(**fields)


@pytest.mark.parametrize("name", ["variance", "tracking", "action"])
def test_weights_end_at_a_million(name):
    assert getattr(Reward(**{name: 1e6}), name) == 1e6
    with pytest.raises(ValueError, match=name):
        Reward(**{name: 1.5e6})


def test_weights_may_be_zero():
    assert Reward(variance=0.0, tracking=0.0, action=0.0).action == 0.0
