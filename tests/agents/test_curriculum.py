"""A curriculum: harder scenarios as more is mitigated, between two rollouts, and as far after a stop."""

import json
from typing import ClassVar

import numpy as np
import pytest

from agents.policy.environment import batch_of
from agents.training import train as training_module
from agents.training.curriculum import Curriculum, Stages
from agents.training.hyperparameters import hyperparameters
from agents.training.settings import Training, checked_config
from agents.training.train import resume, train
from drillrig_env import Scenario, make_sb3
from tests.agents import tiny
from tests.agents.test_resume import assert_same_agent

EASY, HARDER = {"normal_force": [1.0, 2.0], "stick_slip": 0.0, "steady": 1.0}, {"normal_force": [1.0, 3.0]}
CALM = {**EASY, "speed_target": [4.0, 5.0], "load_step": 0.0}
STAGES = {"scenarios": [CALM, {**CALM, "normal_force": [2.0, 3.0]}], "share": 0.0, "episodes": 8}


def training(folder, curriculum=None, **changes):
    values = {
        "n_timesteps": 1152,
        "hyperparams": {**tiny.PPO, "staggered": False, "curriculum": STAGES if curriculum is None else curriculum},
        "env_kwargs": {"duration": 3.0, "scenario": "default"},
        "eval_freq": -1,
        "save_freq": 256,
        "tensorboard": False,
        "progress": False,
    }
    return Training(run_folder=folder, **{**values, **changes})


@pytest.fixture
def told(monkeypatch):
    """The normal forces that the scenario allows at each rollout's start, with the stage and the mitigated episodes."""
    found = []
    before = Curriculum._on_rollout_start

    def tell(self):
        before(self)
        forces = batch_of(self.training_env).scenario.normal_force
        found.append((self.stage, forces, len(self.model.curriculum["mitigated"])))

    monkeypatch.setattr(Curriculum, "_on_rollout_start", tell)
    return found


def test_scenarios_grow_harder_with_the_share_and_end_at_the_environments_own(tmp_path, told):
    train(training(tmp_path / "run"))
    assert [(stage, forces) for stage, forces, _ in told] == [
        *[(0, (1.0, 2.0))] * 2,  # after 16 steps no episode of 30 steps is over
        *[(1, (2.0, 3.0))] * 4,  # that from step 30 to 60 began before the scenario, that from 60 to 90 within it
        *[(2, (5.0, 30.0))] * 3,
    ]
    assert not any(episodes for *_, episodes in told[:6])


def test_it_stays_where_too_little_is_mitigated(tmp_path, told):
    bit_stands = {"normal_force": [500.0, 500.0], "load_step": 0.0}
    train(training(tmp_path / "run", {**STAGES, "scenarios": [bit_stands], "share": 0.01}))
    assert {stage for stage, *_ in told} == {0}


def test_the_share_is_that_of_the_last_episodes():
    class Model:
        logger = None
        curriculum: ClassVar = {"stage": 0, "mitigated": [False] * 3, "began_before": [False, False, False, True]}

    env = make_sb3(4, seed=0)
    callback = Curriculum(Stages.of({"scenarios": [EASY, HARDER], "share": 0.5, "episodes": 4}), {"scenario": "wide"})
    callback.model = Model()
    callback.model.get_env = lambda: env
    callback.model.logger = type("Logger", (), {"record": staticmethod(lambda *_: None)})
    callback.locals = {"dones": np.array([True, False, True, True]), "infos": [{"is_success": i > 0} for i in range(4)]}
    callback._on_step()
    assert callback.model.curriculum["mitigated"] == [False, False, False, False, True][1:]
    callback._on_rollout_start()
    assert callback.stage == 0
    callback._on_step()
    assert callback.model.curriculum["mitigated"] == [True, False, True, True]
    callback._on_rollout_start()
    assert callback.model.curriculum == {"stage": 1, "mitigated": [], "began_before": [True] * 4}
    assert env.scenario.normal_force == (1.0, 3.0)
    callback._on_step()
    assert callback.model.curriculum["mitigated"] == []  # nothing is known of the new scenario yet
    for _ in range(2):
        callback.model.curriculum["mitigated"] = [True] * 4
        callback._on_rollout_start()
    assert (callback.stage, env.scenario) == (2, Scenario.named("wide"))


def test_noise_and_delay_grow_with_the_scenarios(tmp_path, monkeypatch):
    seen = []
    before = Curriculum._on_rollout_start

    def tell(self):
        before(self)
        batch = batch_of(self.training_env)
        seen.append((batch.scenario.normal_force, batch.noise, batch.delay, set(batch.core.episodes["delay"].tolist())))

    monkeypatch.setattr(Curriculum, "_on_rollout_start", tell)
    own = {"duration": 3.0, "scenario": "default", "sensors": "surface", "noise": 2.0, "delay": (2, 3)}
    train(training(tmp_path / "run", {**STAGES, "noise": [0.0, 1.0], "delay": [0, [1, 1]]}, env_kwargs=own))
    assert list(dict.fromkeys(one[:3] for one in seen)) == [
        ((1.0, 2.0), 0.0, (0, 0)),
        ((2.0, 3.0), 1.0, (1, 1)),
        ((5.0, 30.0), 2.0, (2, 3)),
    ]
    assert seen[0][3] == {0}  # of the episodes themselves
    assert {1} in [one[3] for one in seen]
    assert seen[-1][3] <= {2, 3}


def test_a_training_that_is_resumed_is_as_far(tmp_path, told, monkeypatch):
    fleet = {"rigs": {"spread": {"string": 1.5}, "count": 4}}
    curriculum = {**STAGES, "scenarios": [{**CALM, **fleet}, CALM]}
    train(training(tmp_path / "whole", curriculum))
    whole, stops = list(told), []
    told.clear()
    learn = training_module._learn

    def stopping(model, folder, config, threads, progress, begun=False, asked=None):
        def ask():
            stops.append(model.num_timesteps)
            return model.num_timesteps == 384 and stops.count(384) == 1

        learn(model, folder, config, threads, progress, begun, ask)

    monkeypatch.setattr(training_module, "_learn", stopping)
    with pytest.raises(KeyboardInterrupt):
        train(training(tmp_path / "cut", curriculum))
    resume(tmp_path / "cut", progress=False)
    assert told == whole
    assert_same_agent(tmp_path / "whole", tmp_path / "cut")


def test_config_has_it_as_plain_values_in_the_rigs_scales(tmp_path):
    config = checked_config(training(tmp_path / "run", {"scenarios": ["nominal", EASY], "share": 0.7}))
    found = config["hyperparameters"]["curriculum"]
    assert json.loads(json.dumps(found)) == {
        "scenarios": ["nominal", EASY],
        "noise": [],
        "delay": [],
        "share": 0.7,
        "episodes": 200,
    }
    field = checked_config(training(tmp_path / "run", {"scenarios": [EASY]}, env_kwargs={"rig": "field_2500m"}))
    force = field["hyperparameters"]["curriculum"]["scenarios"][0]["normal_force"]
    assert force[1] == 2.0 * force[0] > 40.0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "scenarios"),
        ({"scenarios": []}, r"scenarios: \[\] is not allowed; allowed: a list of scenarios"),
        ({"scenarios": "wide"}, "scenarios: 'wide' is not allowed"),
        ({"scenarios": ["widest"]}, r"'widest' is not known; did you mean wide\?"),
        ({"scenarios": [{"normal_forces": [1, 2]}]}, "did you mean normal_force?"),
        ({"scenarios": ["wide"], "share": 1.5}, "share = 1.5"),
        ({"scenarios": ["wide"], "episodes": 0}, "episodes = 0"),
        ({"scenarios": ["wide"], "stage": 0}, "unknown key stage"),
        ({"scenarios": ["wide"], "noise": [0.0, 1.0]}, "length of noise = 2 is not allowed; allowed: 1, one for each"),
        ({"scenarios": ["wide"], "delay": 1}, "delay: 1 is not allowed; allowed: a list of delays"),
        (["wide"], "curriculum = .* is not allowed"),
    ],
)
def test_impossible_stages_are_refused(given, words):
    with pytest.raises(ValueError, match=words):
        hyperparameters("ppo", "DrillRig-v0", {"curriculum": given})


@pytest.mark.parametrize(
    ("stages", "words"),
    [
        ({"scenarios": [{"speed_target": [20.0, 30.0]}]}, "speed_target"),
        ({"scenarios": ["wide"], "noise": [-1.0]}, "noise = -1.0 is not allowed"),
        ({"scenarios": ["wide"], "delay": [1]}, "delay = 1 control steps is not allowed; allowed: 0 to 0, that of the"),
    ],
)
def test_a_stage_that_the_environment_cannot_have_is_refused_before_anything_is_written(tmp_path, stages, words):
    with pytest.raises(ValueError, match=words):
        train(training(tmp_path / "run", stages))
    assert not (tmp_path / "run").exists()
