"""Suites of fleets: held-out rigs, scores by each episode's own rig, intervals over rigs."""

import numpy as np
import pytest

import drillrig_env
from baselines import Constant, SoftTorque
from drillrig_env import Friction, Rig
from drillrig_env.env.task import Task
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import describe, describe_fleet, score
from drillrig_env.evaluation.statistics import mean, median, over_rigs, rate
from drillrig_env.evaluation.suites import DRAWS, SUITES, suite
from drillrig_env.evaluation.tables import differences, estimates
from drillrig_env.seeds import EVALUATION_FLEETS, TRAINING_FLEETS, TUNING_FLEETS

FLEETS = [name for name in SUITES if suite(name).scenario.rigs is not None]


def test_no_fleet_that_is_judged_is_one_to_learn_or_tune_on():
    seeds = (TRAINING_FLEETS, TUNING_FLEETS, EVALUATION_FLEETS)
    assert all(max(a.start, b.start) >= min(a.stop, b.stop) for a in seeds for b in seeds if a is not b)
    training = Task(**drillrig_env.ENVIRONMENTS["DrillRigUnknown-v0"]).scenario.rigs
    assert training.seed in TRAINING_FLEETS
    for name in FLEETS:
        judged = suite(name).scenario.rigs
        assert judged.seed in EVALUATION_FLEETS
        assert not set(judged.members().rigs) & set(training.members().rigs)
    assert suite("unknown").scenario.rigs.spread == training.spread


@pytest.mark.parametrize("name", FLEETS)
def test_every_rig_has_the_same_number_of_draws(name):
    faced = suite(name, 3)
    episodes = run(Constant("surface"), faced, sensors="surface", duration=2.0)
    assert episodes.place.tolist() == np.repeat(np.arange(3), DRAWS).tolist()
    assert len(set(episodes.speed_target)) == faced.rigs
    assert suite(name, 1000).rigs == 256 * DRAWS
    assert faced.env_id == "DrillRigUnknown-v0"


def test_an_episode_is_scored_by_its_own_rig():
    faced = suite("unknown", 3)
    episodes = run(Constant("surface"), faced, sensors="surface", duration=20.0)
    scores = score(episodes)
    for k, rig in enumerate(faced.scenario.rigs.members().rigs):
        one = slice(k * DRAWS, (k + 1) * DRAWS)
        friction = Friction(*episodes.friction.as_array()[one].T)
        own = describe(rig, friction, episodes.speed_target[one])
        np.testing.assert_allclose(scores["critical_speed"][one], own["critical_speed"], rtol=1e-12)
        np.testing.assert_allclose(scores["hardness"][one], own["hardness"], rtol=1e-12)
        assert ((scores["region"][one] == "below") == (own["region"] == "below")).all()
        torque = friction.torque(rig, episodes.speed_target[one]) + rig.T_r2
        np.testing.assert_allclose(scores["peak_torque"][one], episodes.highest_torque[one].max(1) / torque, rtol=1e-9)
    shuffled = np.random.default_rng(0).permutation(faced.rigs)
    mixed = describe_fleet(
        episodes.rigs,
        episodes.place[shuffled],
        Friction(*episodes.friction.as_array()[shuffled].T),
        episodes.speed_target[shuffled],
    )
    np.testing.assert_array_equal(mixed["hardness"], scores["hardness"][shuffled])


def test_intervals_over_rigs_are_wider_than_over_episodes_where_rigs_differ():
    random = np.random.default_rng(3)
    rigs = np.repeat(np.arange(64), 16)
    chance = np.repeat(random.random(64), 16)
    outcomes = random.random(1024) < chance
    found, plain = over_rigs(outcomes, rigs), rate(outcomes)
    assert found.value == plain.value
    # The variance of a mean of 64 independent rigs, from the rigs' own means.
    expected = 1.96 * outcomes.reshape(64, 16).mean(1).std(ddof=1) / 8
    assert (found.high - found.low) / 2 == pytest.approx(expected, rel=0.15)
    assert found.high - found.low > 1.8 * (plain.high - plain.low)
    same = over_rigs(outcomes, np.arange(1024))
    assert same.high - same.low == pytest.approx(plain.high - plain.low, rel=0.1)
    middle = over_rigs(chance, rigs, median)
    assert middle.low <= np.median(chance) <= middle.high
    assert over_rigs(outcomes[:16], rigs[:16], mean) == mean(outcomes[:16])


def test_tables_of_a_fleet_go_by_its_rigs():
    scores = {
        "mitigated": np.repeat([True, False, True, True], 16),
        "calm": np.repeat([True, False, True, True], 16),
        "time_to_calm": np.repeat([8.0, 60.0, 9.0, 10.0], 16),
        "cost": np.repeat([0.1, 0.7, 0.2, 0.3], 16),
        "region": np.full(64, "below"),
        "seed": np.full(64, ""),
        "rig": np.repeat(np.arange(4), 16),
    }
    row = estimates(scores)
    assert row["mitigated"].low <= 0.25
    worse = {**scores, "cost": scores["cost"] + np.repeat([0.0, 0.1, 0.2, 0.3], 16)}
    found = differences(worse, scores)["cost"]
    assert (found.value, found.low) == (pytest.approx(0.15), pytest.approx(0.05, abs=0.026))


def test_rows_from_before_fleets_are_read():
    rows = "suite,policy,seed,episode,mitigated\ndefault,lqg,,0,1\ndefault,lqg,,1,0\n"
    read = Results.of_rows(rows, {}, {}, {})
    assert read.scores["default"]["lqg"]["rig"].tolist() == [0, 0]
    assert read.rows.splitlines()[1] == "default,lqg,,0,1,0"


def test_a_nameplate_that_is_wrong_costs_a_soft_drive_more_than_one_that_is_right():
    faced = suite("unknown", 24)
    knowing = SoftTorque("surface", back_emf="motor")
    mitigated = [
        score(run(policy, faced, sensors="surface"))["mitigated"].mean() for policy in (SoftTorque("surface"), knowing)
    ]
    assert mitigated[1] > mitigated[0] + 0.05
    assert Rig() not in faced.scenario.rigs.members().rigs
