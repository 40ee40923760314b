"""The benchmark of training: its timers change nothing, count what they say, and stop where they should."""

import os
from types import SimpleNamespace

import pytest
import torch
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.policies import ActorCriticPolicy

from agents.policy.agent import Agent
from agents.policy.run_folder import load_policy
from agents.training.settings import Training
from agents.training.train import train
from agents.training.validation_rigs import validate
from benchmarks import shares
from benchmarks.one_training import Run, in_fresh_process, timed_training
from benchmarks.shares import Stopwatch, Watch, watched
from benchmarks.training import plan, summary
from drillrig_env.env.sb3 import DrillRigVecEnv
from tests.agents import tiny

SMALL = {
    "ppo": {**tiny.PPO, "n_timesteps": 512},
    "sac": {**tiny.SAC, "n_envs": 8, "n_timesteps": 512},
}
ALGORITHMS = {"ppo": PPO, "sac": SAC}
METHODS = [(PPO, "learn"), (PPO, "train"), (SAC, "learn"), (SAC, "train"), (SAC, "predict")]
METHODS += [(ActorCriticPolicy, "forward"), (DrillRigVecEnv, "step"), (DrillRigVecEnv, "reset")]


def small(folder, algorithm="ppo"):
    settings = {"env_kwargs": {"duration": 3.0}, "eval_freq": -1, "tensorboard": False, "progress": False}
    return train(Training(algorithm, hyperparams=SMALL[algorithm], run_folder=folder, **settings))


@pytest.mark.slow
@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_what_is_watched_learns_the_same(tmp_path, algorithm):
    def validated(model):
        config = {"algorithm": algorithm, "env_id": "DrillRig-v0", "env_kwargs": {}, "hyperparameters": {}}
        agent = Agent(model, config)
        return float(validate(agent, {"duration": 3.0, "sensors": "state"}, 3).mitigated.mean())

    methods = [getattr(owner, name) for owner, name in METHODS]
    alone = load_policy(small(tmp_path / "alone", algorithm)).model.policy.state_dict()
    watch = Watch(64, 10**6, validated, 128)
    with watched(ALGORITHMS[algorithm], watch):
        beside = load_policy(small(tmp_path / "watched", algorithm)).model.policy.state_dict()
    assert watch.validations["steps"] == [128, 256, 384, 512]
    assert all(torch.equal(alone[name], beside[name]) for name in alone)
    assert methods == [getattr(owner, name) for owner, name in METHODS]


def test_timers_are_taken_away_after_a_failure(tmp_path, monkeypatch):
    methods = [getattr(owner, name) for owner, name in METHODS]
    with pytest.raises(ZeroDivisionError), watched(PPO, Watch(64, 1, lambda model: 1 / 0)):
        small(tmp_path / "run")
    assert methods == [getattr(owner, name) for owner, name in METHODS]


@pytest.fixture
def clock(monkeypatch):
    """A clock in place of the system's, so that no load matters: it moves a little with each look, and when told."""
    made = SimpleNamespace(now=0.0)

    def look():
        made.now += 1e-9
        return made.now

    monkeypatch.setattr(shares, "time", SimpleNamespace(perf_counter=look))
    return made


def test_of_a_phase_within_a_phase_the_outer_one_counts(clock):
    stopwatch = Stopwatch()

    def takes(seconds):
        clock.now += seconds

    policy = stopwatch.timed("policy", takes)
    stopwatch.timed("validation", lambda: policy(2.0))()
    policy(0.5)
    with pytest.raises(TypeError):
        policy("no number")
    policy(0.25)
    assert stopwatch.seconds == pytest.approx({"env": 0.0, "policy": 0.75, "update": 0.0, "validation": 2.0}, abs=1e-6)


@pytest.mark.parametrize(
    ("part", "owner", "name"),
    [("env", DrillRigVecEnv, "step_wait"), ("policy", ActorCriticPolicy, "forward"), ("update", PPO, "train")],
)
def test_the_part_that_is_slow_has_the_time(tmp_path, monkeypatch, clock, part, owner, name):
    quick = getattr(owner, name)

    def slow(self, *arguments, **named):
        clock.now += 0.2 if name == "train" else 0.02
        return quick(self, *arguments, **named)

    monkeypatch.setattr(owner, name, slow)
    watch = Watch(128, 10**6)
    with watched(PPO, watch):
        small(tmp_path / "run")
    assert watch.chunks["steps"] == [128, 128, 128]  # the first rollout, with its update, is left out
    for seconds, *parts in zip(*(watch.chunks[key] for key in ("seconds", *shares.PARTS)), strict=True):
        assert sum(parts) < seconds
        assert parts[shares.PARTS.index(part)] > 0.99 * seconds


def test_a_training_ends_where_the_goal_is_reached_and_enough_was_timed(tmp_path):
    def steps(chunks, answers):
        watch = Watch(128, chunks, lambda model: next(answers), 128)
        with watched(PPO, watch):
            folder = small(tmp_path / f"run_{chunks}")
        assert load_policy(folder).model.num_timesteps == watch.num_timesteps
        return watch

    early = steps(1, iter([0.2, 0.95, 0.1]))
    assert early.reached["steps"] == 256
    assert early.validations["mitigated"] == [0.2, 0.95]
    assert early.num_timesteps == 256 + SMALL["ppo"]["n_envs"]  # the stop is heard with the next step
    late = steps(2, iter([0.95, 0.2, 0.2]))
    assert (late.reached["steps"], late.num_timesteps) == (128, 384 + SMALL["ppo"]["n_envs"])
    assert late.reached["seconds"] < late.seconds
    never = steps(10, iter([0.2, 0.2, 0.2, 0.2]))
    assert (never.reached, never.num_timesteps) == (None, 512)


def test_validation_is_no_training_time(tmp_path, clock):
    def takes_half_a_second(_model):
        clock.now += 0.5
        return 1.0

    watch = Watch(128, 1, takes_half_a_second, 128)
    with watched(PPO, watch):
        begin = clock.now
        small(tmp_path / "run")
        passed = clock.now - begin
    assert watch.stopwatch.seconds["validation"] >= 0.5 * len(watch.validations["steps"])
    assert watch.seconds < passed - watch.stopwatch.seconds["validation"]
    assert sum(watch.chunks["seconds"]) < watch.seconds


@pytest.mark.slow
def test_a_run_has_its_cores_and_leaves_the_caller_his():
    before = available(), dict(os.environ)
    found = in_fresh_process(Run("ppo", cores=1, chunk_steps=128, chunks=2, hyperparams=SMALL["ppo"]))
    assert (available(), dict(os.environ)) == before
    assert found["torch_threads_set"] == 1
    assert found["cores_allowed"] == 1 or not hasattr(os, "sched_getaffinity")
    with pytest.raises(ValueError, match="cores = 0"):
        in_fresh_process(Run("ppo", cores=0))
    with pytest.raises(RuntimeError, match="did you mean gamma"):
        in_fresh_process(Run("ppo", hyperparams={"gama": 1.0}))


def available():
    return os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None


def test_the_peer_trains_by_the_same_settings(tmp_path):
    run = Run("sac", "Pendulum-v1", chunk_steps=64, chunks=3, hyperparams=SMALL["sac"])
    found = timed_training(run, tmp_path)
    assert found["n_envs"] == 8
    assert found["chunks"]["steps"] == [64, 64, 64]
    assert found["steps"] == 104 + 3 * 64 + 8  # after the first update, at 104 steps


def made_up(seed, seconds, reached):
    chunks = {"steps": [100, 100], "seconds": seconds, "env": [0.1, 0.1], "policy": [0.2, 0.2], "update": [0.4, 0.4]}
    setting = {"algorithm": "ppo", "environment": "DrillRig-v0", "cores": 1, "torch_threads": 1, "n_envs": 8}
    return {**setting, "seed": seed, "validate_every": 10, "chunks": chunks, "reached": reached}


def test_rows_are_medians_over_chunks_and_seeds():
    reached = {"steps": 300, "seconds": 4.0}
    runs = [
        made_up(0, [1.0, 2.0], reached),
        made_up(1, [1.0, 1.0], {"steps": 500, "seconds": 6.0}),
    ]
    (row,) = summary([*runs, made_up(2, [2.0, 3.0], None)])
    assert row["steps_per_second"] == pytest.approx(75.0)  # of 100, 50, 100, 100, 50 and 33 steps a second
    assert [row[f"{name}_percent"] for name in ("env", "policy", "update", "other")] == pytest.approx([6, 12, 24, 58])
    assert row["env_steps_per_second"] == pytest.approx(1000.0)
    assert (row["steps_to_goal"], row["seconds_to_goal"], row["runs_that_reached_it"]) == (500, 6.0, 2)
    (row,) = summary([made_up(0, [1.0, 1.0], None)])
    assert (row["steps_to_goal"], row["seconds_to_goal"], row["runs_to_goal"]) == (None, None, 1)


def test_a_plan_has_every_setting_and_refuses_no_seeds():
    runs = plan(["ppo", "sac"], [1, 2], None)
    assert sum(run.validate_every is not None for run in runs) == 2 * (5 + 3)
    assert {run.torch_threads for run in runs if run.validate_every} == {1}
    assert not any(run.validate_every for run in plan(["sac"], [1], 2, quick=True))
    with pytest.raises(ValueError, match="seeds = 0"):
        plan(["ppo"], [1], 0)
