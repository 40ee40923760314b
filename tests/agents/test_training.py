import json
import tempfile
import zipfile
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
import torch

import train as command
from agents.policy.environment import batch_of, environment_arguments, make_environment
from agents.policy.run_folder import is_run, load_policy, read_config
from agents.training.settings import Training
from agents.training.train import train
from agents.training.validation_rigs import validate
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.evaluation.runner import play
from drillrig_env.evaluation.suites import STICKING
from drillrig_env.files import LOCK
from drillrig_env.policy import make_policy
from drillrig_env.rig import Rig
from drillrig_env.seeds import TRAINING_SEEDS, VALIDATION_SEEDS
from tests.agents.tiny import PPO, SAC

SHORT = {"duration": 3.0}
ROOT = Path(__file__).parents[2]


def small(folder, **changes):
    values = {
        "n_timesteps": 512,
        "hyperparams": PPO,
        "env_kwargs": SHORT,
        "eval_episodes": 4,
        "log_folder": folder,
        "tensorboard": False,
        "progress": False,
    }
    return Training(**{**values, **changes})


def test_run_folder_holds_the_model_and_what_made_it(tmp_path):
    folder = train(small(tmp_path, seed=3))
    config = read_config(folder)
    assert (config["algorithm"], config["seed"]) == ("ppo", 3)
    assert config["hyperparameters"]["n_steps"] == 16
    assert config["provenance"]["versions"]["stable-baselines3"]
    assert is_run(folder)
    actions, _ = load_policy(folder).predict(np.zeros((4, 12), np.float32), deterministic=True)
    assert actions.shape == (4, 1)
    assert train(small(tmp_path)).name == "ppo_2"


def test_same_seed_same_agent_and_another_seed_another(tmp_path):
    observations = np.random.default_rng(0).normal(size=(20, 12)).astype(np.float32)
    actions = [
        load_policy(train(small(tmp_path, seed=s))).predict(observations, deterministic=True)[0] for s in (1, 1, 2)
    ]
    np.testing.assert_array_equal(actions[0], actions[1])
    assert not np.array_equal(actions[0], actions[2])


def test_nothing_is_left_among_the_temporary_files(tmp_path, monkeypatch):
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    train(small(tmp_path))
    assert not list((tmp_path / "temporary").iterdir())


def test_sac_trains(tmp_path):
    folder = train(small(tmp_path, algorithm="sac", hyperparams=SAC))
    assert load_policy(folder).model.num_timesteps >= 512


def test_interrupt_keeps_what_was_learnt(tmp_path, monkeypatch):
    from stable_baselines3 import PPO

    def interrupted(self, *args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr(PPO, "learn", interrupted)
    with pytest.raises(KeyboardInterrupt) as stop:
        train(small(tmp_path))
    assert (tmp_path / "ppo_1" / "model.zip").is_file()
    assert "keeps the model of 0 of 512 steps" in stop.value.__notes__[0]


def test_bad_settings_are_refused_before_anything_is_written(tmp_path):
    for changes, message in (
        ({"hyperparams": {"gama": 1}}, "did you mean gamma"),
        ({"seed": -1}, "seed = -1"),
        ({"seed": 10**9}, "seed"),
        ({"seed": TRAINING_SEEDS.stop}, "seed"),
        ({"env_kwargs": {"sensors": "none"}}, "sensors"),
        ({"env_kwargs": {"slew_limt": 1.0}}, "did you mean slew_limit"),
        ({"env_kwargs": {"reward": {"traking": 1.0}}}, "did you mean tracking"),
        ({"hyperparams": {**PPO, "policy_kwargs": "dict(net_arch=open)"}}, "policy_kwargs"),
        ({"env_id": "DrillRig-v1"}, "did you mean DrillRig-v0"),
        ({"eval_freq": 0}, "eval_freq = 0"),
        ({"save_freq": 0}, "save_freq = 0"),
        ({"hyperparams": {**PPO, "n_steps": -5}}, "n_steps = -5 is not allowed; allowed: whole, >= 1"),
        ({"hyperparams": {**PPO, "batch_size": 0}}, "batch_size = 0"),
        ({"hyperparams": {**PPO, "gamma": 1.5}}, "gamma = 1.5 is not allowed; allowed: >= 0 and <= 1"),
        ({"hyperparams": {**PPO, "n_envs": 1, "n_steps": 1}}, "ppo: these hyperparameters are not allowed"),
        ({"env_kwargs": {"scenario": {"friction": {"mu_s": 0.2, "mu": 1}}}}, "DrillRig|friction"),
        ({"env_kwargs": {"duration": float("inf")}}, "duration|DrillRig"),
        ({"env_kwargs": {"rig": 5}}, "rig = 5"),
        ({"env_kwargs": {"drive": [0.1, 0.2, 0.3, 0.4]}}, "drive = "),
        ({"env_kwargs": {"reward": lambda _: 0.0}}, "reward"),
    ):
        with pytest.raises(ValueError, match=message):
            train(small(tmp_path / "runs", **changes))
    assert not (tmp_path / "runs").exists()


def test_a_folder_that_cannot_be_written_is_found_out_before_any_work(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setattr("agents.training.train._learn", lambda *_: pytest.fail("trained"))
    with pytest.raises(OSError, match="file cannot be written"):
        train(small(tmp_path / "file"))


def test_a_rig_of_ones_own_goes_into_the_config_whole(tmp_path):
    rig = Rig(k_2=0.5)
    rig.to_toml(tmp_path / "rig.toml")
    for given in (rig, {"k_2": 0.5}, tmp_path / "rig.toml"):
        folder = train(small(tmp_path, env_kwargs={**SHORT, "rig": given}, n_timesteps=128, eval_freq=-1))
        kept = read_config(folder)["env_kwargs"]["rig"]
        assert Rig.of(kept) == rig
        assert len(kept) == len(fields(Rig))
    assert load_policy(folder).environment["rig"] == kept


def test_evaluations_keep_the_best_and_the_last_model(tmp_path):
    folder = train(small(tmp_path, eval_freq=128))
    with np.load(folder / "evaluations.npz") as saved:
        assert saved["timesteps"].tolist() == [0, 128, 256, 384, 512]
        assert saved["results"].shape == saved["mitigated"].shape == saved["ep_lengths"].shape == (5, 4)
        assert np.all(saved["results"] < 0)
        ranks = list(zip(saved["mitigated"].mean(axis=1), saved["results"].mean(axis=1), strict=True))
    best = load_policy(folder, best=True).model.num_timesteps
    assert best == 128 * ranks.index(max(ranks))
    assert load_policy(folder).model.num_timesteps == 512
    assert not (train(small(tmp_path, eval_freq=-1)) / "evaluations.npz").exists()


def test_curves_hold_the_mitigated_share(tmp_path):
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    folder = train(small(tmp_path, tensorboard=True))
    with zipfile.ZipFile(folder / "model.zip") as archive:
        assert str(tmp_path) not in archive.read("data").decode()  # it says nothing of this machine
    events = EventAccumulator(str(folder / "tensorboard_1"))
    events.Reload()
    assert {"drillrig/mitigated", "drillrig/cost", "eval/mitigated"} <= set(events.Tags()["scalars"])


def test_frame_stack_sees_what_it_was_trained_on(tmp_path):
    """The loaded agent stacks frames as the training's `VecFrameStack` did, over resets and all."""
    folder = train(small(tmp_path, hyperparams={**PPO, "frame_stack": 3}))
    agent = load_policy(folder)
    env = make_environment("DrillRig-v0", 3, 5, {"duration": 1.0}, frame_stack=3)
    stacked, state, begins = env.reset(), None, np.ones(3, dtype=bool)
    for _ in range(25):
        expected, _ = agent.model.predict(stacked, deterministic=True)
        actions, state = agent.predict(batch_of(env).core.observations, state, begins)
        np.testing.assert_array_equal(state[0], stacked)
        np.testing.assert_array_equal(actions, expected)
        stacked, _, begins, _ = env.step(actions)


@pytest.mark.slow
def test_command_line_trains_seeds_side_by_side(tmp_path, monkeypatch, capsys):
    for library in ("OMP", "MKL", "OPENBLAS"):
        monkeypatch.setenv(f"{library}_NUM_THREADS", "1")  # it sets them for its processes
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(ROOT)
    settings = [f"{name}:{json.dumps(value)}" for name, value in PPO.items()]
    flags = ["-n", "512", "--eval-episodes", "4", "--no-tensorboard", "--seeds", "2", "--jobs", "2", "--seed", "3"]
    assert command.main([*flags, "--env-kwargs", "duration:3.0", "-params", *settings]) == 0
    folder = tmp_path / "runs/ppo_1"
    assert {path.name for path in folder.glob("*")} == {LOCK, "seed_3", "seed_4"}
    told = capsys.readouterr().out
    assert "seed_3: done\n" in told
    assert "seed_4: done\n" in told
    assert [read_config(folder / f"seed_{seed}")["seed"] for seed in (3, 4)] == [3, 4]
    alone = load_policy(train(small(tmp_path, seed=4))).model.policy.state_dict()
    beside = load_policy(folder / "seed_4").model.policy.state_dict()
    assert all(torch.equal(alone[name], beside[name]) for name in alone)


def test_an_agent_wants_the_same_rates_at_another_slew_limit(tmp_path):
    agent = load_policy(train(small(tmp_path)))
    observations = np.random.default_rng(0).normal(size=(50, 12)).astype(np.float32)
    actions = agent.predict(observations)[0]
    slower = agent.at_slew_limit(1.0).predict(observations)[0]
    np.testing.assert_allclose(slower, np.clip(2.0 * actions, -1.0, 1.0))


def test_a_tilted_disc_is_validated_by_whether_the_bit_never_stops():
    agent = make_policy("lqg", sensors="state")
    tilted = {"scenario": {"tilt": {"share": 0.1, "turns": [1]}, "spread": 0.0}}
    strict = EpisodeBatch(60, **tilted)
    strict.reset(np.arange(60), first_uniforms(VALIDATION_SEEDS.start, 60), STICKING)
    for _ in play(agent, strict):
        pass
    found = validate(agent, tilted, 60).mitigated
    assert np.array_equal(found, strict.mitigated_below(0.5))
    assert found.sum() > strict.mitigated.sum()


def test_validation_draws_evenly_what_training_shows_more_often():
    agent = Constant()
    shown = {"target_skew": 3.0, "candidates": 5}
    even, skewed = (validate(agent, {"scenario": one, "duration": 1.0}, 20) for one in ({}, shown))
    np.testing.assert_array_equal(even.returns, skewed.returns)


class Constant:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 1), np.float32), None


def test_a_critics_part_is_refused():
    with pytest.raises(ValueError, match="privileged = True is not allowed; allowed: False"):
        environment_arguments("DrillRig-v0", {"privileged": True})
