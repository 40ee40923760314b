"""Scores against episodes made by hand, where the answer is known."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, Task
from drillrig_env.evaluation.runner import Episodes, run
from drillrig_env.evaluation.scores import SCORES, folds, score
from drillrig_env.evaluation.suites import suite
from drillrig_env.seeds import EVALUATION_SEEDS
from drillrig_env.stability import end_of_stick_slip
from drillrig_env.verdict import CALM_INDEX, stick_slip_index


def episode(lowest, highest, average, target=2.0, **changes):
    steps = len(lowest)
    values = {
        "task": Task(),
        "speed_target": np.array([target]),
        "friction": Friction(np.array([20.0]), np.array([0.5]), np.array([0.306]), np.array([1.0])),
        "start": np.array(["stick_slip"]),
        "lowest": np.array([lowest], dtype=float),
        "highest": np.array([highest], dtype=float),
        "average": np.array([average], dtype=float),
        "stuck": np.zeros((1, steps)),
        "torque_into_string": np.ones((1, steps)),
        "highest_torque": np.ones((1, steps)),
        "speed_reference": np.full((1, steps), 2.0),
        "top_speed": np.full((1, steps), 2.0),
        "reward": np.full((1, steps), -0.25),
        "rigs": (Rig(),),
        "place": np.zeros(1, dtype=np.intp),
        "calm_index": CALM_INDEX,
    }
    return Episodes(**{**values, **changes})


def scored(*args, **kwargs):
    return {name: values[0] for name, values in score(episode(*args, **kwargs)).items()}


CALM = ([2.0] * 600, [2.01] * 600, [2.005] * 600)


def test_full_stick_slip_has_index_one():
    assert stick_slip_index(0.0, 4.0, 2.0) == 1.0
    assert stick_slip_index(0.0, 0.0, 0.0) == np.inf
    result = scored([0.0] * 600, [4.0] * 600, [2.0] * 600)
    assert (result["ssi"], result["calm"], result["mitigated"]) == (1.0, False, False)
    assert result["time_to_calm"] == 60.0
    assert result["peak_speed"] == 2.0


def test_calm_at_the_target_is_mitigated_from_the_first_window_on():
    result = scored(*CALM)
    assert result["calm"]
    assert result["mitigated"]
    assert result["time_to_calm"] == pytest.approx(5.0)
    assert result["cost"] == 0.25


def test_standing_still_is_not_calm():
    assert not scored([0.0] * 600, [1e-4] * 600, [5e-5] * 600)["calm"]


@pytest.mark.parametrize(("mean", "mitigated"), [(2.099, True), (2.101, False), (1.901, True), (1.899, False)])
def test_mitigated_asks_for_a_mean_within_five_percent(mean, mitigated):
    result = scored([mean] * 600, [mean] * 600, [mean] * 600)
    assert result["calm"]
    assert result["mitigated"] == mitigated


def test_an_index_of_a_tenth_is_not_below_a_tenth():
    result = scored([4.5] * 600, [5.5] * 600, [5.0] * 600)
    assert (result["ssi"], result["calm"], result["time_to_calm"]) == (0.1, False, 60.0)
    assert scored([4.5] * 600, [5.49] * 600, [5.0] * 600)["time_to_calm"] == 5.0


def test_time_to_calm_counts_from_the_last_shake():
    lowest, highest = np.full(600, 2.0), np.full(600, 2.01)
    highest[199] = 3.0  # the trailing 5 s are calm again once they begin after step 200
    result = scored(lowest, highest, np.full(600, 2.0))
    assert result["time_to_calm"] == pytest.approx(20.0 + 5.0)


@pytest.mark.parametrize(("signal", "blow"), [(0, 0.0), (1, 6.0)], ids=["lowest", "highest"])
def test_only_the_last_ten_seconds_count_for_the_verdict(signal, blow):
    signals = np.full((3, 600), 2.0)
    signals[signal, 150:500] = blow
    assert scored(*signals)["mitigated"]
    signals[signal, 500] = blow
    assert not scored(*signals)["mitigated"]


def test_mean_and_index_are_those_of_the_last_ten_seconds_too():
    """Half the target for 50 s and then the target is mitigated; the other way round is not."""
    creeping, right = np.full(600, 1.0), np.full(600, 2.0)
    late = np.where(np.arange(600) < 500, creeping, right)
    result = scored(late, late, late)
    assert (result["calm"], result["mitigated"]) == (True, True)
    early = np.where(np.arange(600) < 500, right, creeping)
    assert not scored(early, early, early)["mitigated"]
    average = np.where(np.arange(600) < 500, 0.5, 2.0)
    assert scored(average - 0.1, average + 0.1, average)["ssi"] == pytest.approx(0.2 / 4.0)


def test_shares_and_costs_are_those_of_the_whole_episode():
    early = np.where(np.arange(600) < 60, 1.0, 0.0)[None]
    result = scored(*CALM, stuck=early, reward=-early, highest_torque=1.0 + early)
    assert (result["stuck"], result["cost"]) == (pytest.approx(0.1), pytest.approx(0.1))
    assert result["peak_torque"] == pytest.approx(2.0 / Friction(20.0).torque(Rig(), 2.0))


def test_steady_torque_of_the_peak_carries_the_collars_too():
    result = scored(*CALM, rigs=(Rig(T_r2=0.1),))
    assert result["peak_torque"] == pytest.approx(1.0 / (Friction(20.0).torque(Rig(), 2.0) + 0.1))


def test_travel_stuck_torque_and_region():
    reference = np.concatenate([np.linspace(1.0, 3.0, 300), np.linspace(3.0, 2.0, 300)])[None]
    result = scored(*CALM, speed_reference=reference, stuck=np.full((1, 600), 0.2))
    assert result["travel"] == pytest.approx(3.0)
    assert result["stuck"] == pytest.approx(0.2)
    steady = Friction(20.0).torque(Rig(), 2.0)
    assert result["peak_torque"] == pytest.approx(1.0 / steady)
    assert result["critical_speed"] == pytest.approx(2.688, abs=1e-3)
    assert result["hardness"] == pytest.approx(20 * 0.0485 * 0.194 * np.exp(-2.0) / 0.0127986, rel=1e-4)


def friction(force, mu_s=0.5, mu_k=0.306):
    return Friction(np.array([force]), np.array([mu_s]), np.array([mu_k]), np.array([1.0]))


@pytest.mark.parametrize(("target", "region"), [(1.99, "below"), (2.0, "bistable"), (2.9, "bistable"), (2.91, "above")])
def test_regions_meet_at_critical_speed_and_fold(target, region):
    result = scored(*CALM, target=target, friction=friction(10.0))
    assert (result["critical_speed"], result["fold"]) == pytest.approx((1.99492, 2.90097), abs=1e-4)
    assert result["region"] == region


def test_a_rig_on_a_border_belongs_to_the_side_above_it():
    borders = scored(*CALM, friction=friction(10.0))
    for border, region in (("critical_speed", "bistable"), ("fold", "above")):
        assert scored(*CALM, target=borders[border], friction=friction(10.0))["region"] == region


def test_without_stick_slip_every_speed_is_above_the_fold():
    result = scored(*CALM, target=0.5, friction=friction(0.5))
    assert result["critical_speed"] == 0.0
    assert np.isnan(result["fold"])
    assert result["region"] == "above"


def test_a_branch_that_cannot_be_followed_leaves_the_others_theirs(monkeypatch):
    """Loads of a million N are refused, after many tries."""

    def refused(rig, friction):
        if np.max(friction.normal_force) > 1e5:
            raise ValueError("a load whose stick-slip cannot be followed")
        return end_of_stick_slip(rig, friction)

    monkeypatch.setattr("drillrig_env.evaluation.scores.end_of_stick_slip", refused)
    forces = np.array([10.0, 1e6])
    ends = folds(Rig(), Friction(forces, np.full(2, 0.5), np.full(2, 0.306), np.ones(2)))
    assert ends[0] == pytest.approx(2.90097, abs=1e-4)
    assert ends[1] == np.inf
    assert scored(*CALM, target=20.0, friction=friction(1e6))["region"] == "bistable"


def test_a_rig_of_which_no_orbit_is_found_has_no_end_of_stick_slip_within_reach():
    assert folds(Rig(J_1=1e-5), Friction()).tolist() == [np.inf]


def test_every_documented_score_is_there():
    assert set(SCORES) <= set(score(episode(*CALM)))


class Hold:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 1), np.float32), None


def test_a_run_twice_is_the_same_run_and_agrees_with_the_environments_verdict():
    import gymnasium as gym

    first, second = (score(run(Hold(), suite("default", 30))) for _ in range(2))
    for name in first:
        np.testing.assert_array_equal(first[name], second[name])
    env = gym.make_vec("DrillRig-v0", num_envs=30)
    env.reset(seed=EVALUATION_SEEDS.start, options={"start": "stick_slip", "load_steps": []})
    for _ in range(600):
        *_, info = env.step(np.zeros((30, 1), np.float32))
    np.testing.assert_array_equal(info["is_success"], first["mitigated"])
