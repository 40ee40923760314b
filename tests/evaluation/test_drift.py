"""The suite of a rig that drifts: what varies, for everyone alike, and when it counts as calm."""

import json
from dataclasses import asdict
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env
from baselines import LQG, Constant
from drillrig_env import Rig
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.task import Task
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.store import read
from drillrig_env.evaluation.suites import suite
from drillrig_env.scales import Scales
from drillrig_env.seeds import EVALUATION_SEEDS, TRAINING_SEEDS
from tests.rigs import FIELD

DRIFT = suite("drift", 400)
STORED = Path(__file__).parents[2] / "docs" / "results"


@pytest.fixture(scope="module")
def begun():
    core = EpisodeBatch(DRIFT.rigs, scenario=DRIFT.scenario, sensors="surface", threads=1, **DRIFT.env)
    core.reset(np.arange(DRIFT.rigs), first_uniforms(DRIFT.first_seed, DRIFT.rigs), DRIFT.groups[0][1])
    return core


def test_episodes_are_those_of_the_environment_of_that_id_with_other_seeds():
    task = Task(**drillrig_env.ENVIRONMENTS["DrillRigDrift-v0"])
    assert asdict(task.scenario) == asdict(DRIFT.scenario)
    assert (task.sensors.name, task.delays) == ("surface", DRIFT.env["delay"])
    assert DRIFT.first_seed in EVALUATION_SEEDS
    assert DRIFT.first_seed not in TRAINING_SEEDS
    env = gym.make("DrillRigDrift-v0")
    observation, info = env.reset(seed=0)
    assert observation.shape == (len(task.sensors.names),)
    before = info["mu_k"]
    for _ in range(30):
        *_, info = env.step(np.zeros(1, np.float32))
    assert info["mu_k"] != before


def test_another_rig_drifts_by_its_own_scales():
    task, scales = gym.make("DrillRigDrift-v0", rig=FIELD).unwrapped.task, Scales.of(FIELD)
    assert task.scenario.wandering.time == pytest.approx(20.0 * scales.time)
    assert asdict(task.scenario) == asdict(suite("drift", 5, scales).scenario)
    assert scales.time > 1.5


def test_friction_wanders_about_the_nominal_one_by_a_fifth(begun):
    logarithms, rig = begun.episodes["logarithms"], begun.friction
    np.testing.assert_allclose(begun.episodes["coefficients"], np.broadcast_to([0.5, 0.306, 1.0], (400, 3)))
    assert logarithms.std(axis=0) == pytest.approx([0.2] * 3, rel=0.15)
    np.testing.assert_allclose(np.asarray(rig.mu_k), 0.306 * np.exp(logarithms[:, 0]), rtol=1e-12)
    np.testing.assert_allclose(np.asarray(rig.v_b), np.exp(logarithms[:, 2]), rtol=1e-12)


def test_every_episode_has_a_tilted_disc_and_one_step_of_the_target(begun):
    turns, counts = np.unique(begun.episodes["turns"], return_counts=True)
    assert turns.tolist() == [1, 2]
    assert counts.min() > 150
    times, targets = begun.episodes["target_time"], begun.episodes["next_target"]
    assert 12.0 <= times.min() < 14.0 < 34.0 < times.max() <= 36.0
    assert targets.min() >= 1.0
    assert targets.max() <= 5.0
    assert np.isinf(begun.episodes["load_times"]).all()


def test_what_varies_is_everyones():
    few = suite("drift", 6)
    one, other = (run(kind("surface"), few, sensors="surface") for kind in (Constant, LQG))
    np.testing.assert_array_equal(one.friction.as_array(), other.friction.as_array())
    np.testing.assert_array_equal(one.speed_target, other.speed_target)
    assert (one.average != other.average).any()


def test_it_counts_as_calm_where_the_bit_is_certain_not_to_stop():
    episodes = run(LQG("surface"), suite("drift", 60), sensors="surface")
    scores = score(episodes)
    moves = episodes.lowest[:, -100:].min(axis=1) > 0.0
    assert scores["calm"].sum() > 1.5 * (scores["ssi"] < 0.1).sum()
    assert moves[scores["calm"]].all()
    np.testing.assert_array_equal(scores["calm"], scores["ssi"] < 0.5)
    assert DRIFT.definition()["calm_index"] == 0.5
    assert "calm_index" not in suite("default", 5).definition()


def test_on_another_rig_it_drifts_as_slowly_for_that_rig():
    scales = Scales.of(FIELD)
    grown = suite("drift", 5, scales).scenario
    assert grown.wandering.time == pytest.approx(20.0 * scales.time)
    assert grown.wandering.deviation == 0.2
    assert asdict(suite("drift", 5, Scales.of(Rig())).scenario) == asdict(DRIFT.scenario)


@pytest.mark.parametrize("env", [folder.name for folder in sorted(STORED.iterdir()) if folder.is_dir()])
def test_stored_results_are_of_the_suites_as_they_are(env):
    for name, stored in read(STORED / env).config["suites"].items():
        rigs = stored["rigs"] if "rigs" not in stored["scenario"] else 256
        now = json.loads(json.dumps(suite(name, rigs).definition()))
        for one in (now, stored):
            one["scenario"]["friction"].pop("law", None)  # which is the only one, and older results do not name
        assert now == stored
