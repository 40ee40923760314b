import json

import gymnasium as gym
import numpy as np
import pytest

import benchmarks.environments
from benchmarks.environment_peers import OURS, Peer, Pool, peers
from benchmarks.environments import fixed_rate, main, measure, random_rate, seconds_per_draw, summary


def peer(name):
    return next(one for one in peers() if one.name == name)


class Clocked:
    """An environment that ends every third step and takes a second of a made-up clock for each."""

    def __init__(self, space, count):
        self.action_space, self.count, self.steps, self.resets, self.now = space, count, 0, 0, 0.0

    def reset(self, seed=None):
        self.resets += 1

    def step(self, action):
        assert np.shape(action) == self.action_space.shape
        self.steps += 1
        self.now += 1.0
        ended = self.steps % 3 == 0
        if self.count == 1:
            return None, 0.0, ended, False, {}
        return None, 0.0, np.full(self.count, ended), np.zeros(self.count, dtype=bool), {}


def clocked(monkeypatch, count):
    made = peer(OURS).make(count)
    env = Clocked(made.action_space, count)
    made.close()
    monkeypatch.setattr(benchmarks.environments.time, "perf_counter", lambda: env.now)
    return env


def test_one_copy_is_reset_when_it_ends_and_every_step_counts(monkeypatch):
    env = clocked(monkeypatch, 1)
    assert fixed_rate(env, peer(OURS), 1, seconds=700.0) == 1.0
    assert env.steps == 1200  # whole episodes
    assert env.resets == 1 + env.steps // 3


def test_a_step_that_begins_the_next_episode_does_not_count(monkeypatch):
    env = clocked(monkeypatch, 4)
    rate = fixed_rate(env, peer(OURS), 4, seconds=1.0)
    assert env.steps == 601
    assert rate == 4 * (601 - 200) / 601
    assert env.resets == 1


def test_one_copy_has_met_every_start_before_its_time_is_taken(monkeypatch):
    """A start in stick-slip has kernels of its own, which the first reset need not compile."""
    started = []

    def rate(env, *_):
        raise StopIteration

    make, ours = gym.make, peer(OURS)
    monkeypatch.setattr(benchmarks.environments, "fixed_rate", rate)
    monkeypatch.setattr(gym, "make", lambda *given, **named: Watched(make(*given, **named), started))
    with pytest.raises(RuntimeError):
        next(measure([ours], 1, 1, 0.1))
    assert set(started) == {0, 1, 2}  # from rest, in steady rotation, in stick-slip


class Watched(gym.Wrapper):
    """Notes the kind of each start."""

    def __init__(self, env, started):
        super().__init__(env)
        self.started = started

    def reset(self, **given):
        observation, info = self.env.reset(**given)
        self.started.append(int(info["start"]))
        return observation, info


def test_gymnasium_without_a_vector_benchmark_has_no_rate(monkeypatch):
    monkeypatch.delattr(benchmarks.environments.performance, "benchmark_vector_step", raising=False)
    assert random_rate(None, 64, 0.01) is None


def test_missing_peer_says_what_to_install():
    absent = Peer("x", lambda count: None, 0, None, "", package=("no_such_module", "no-such-project"))
    assert absent.missing() == "x is left out; install it with: pip install no-such-project"
    assert peer(OURS).missing() is None


def test_summary_has_medians_and_leaves_out_what_was_not_measured():
    found = summary({"fixed": [1.0, 9.0, 2.0], "random": [], "draw": [0.5]})
    assert found["steps_per_second_fixed"] == 2.0
    assert found["seconds_per_draw"] == 0.5
    assert found["runs_fixed"] == [1.0, 9.0, 2.0]
    assert "steps_per_second_random" not in found


@pytest.mark.parametrize("name", ["DrillRig-v0, one core", "CartPole-v1", "Pendulum-v1"])
def test_peers_step_with_their_fixed_action(name):
    one = peer(name)
    env = one.make(64)
    assert fixed_rate(env, one, 64, seconds=0.0) > 0.0
    assert seconds_per_draw(env, 1e-4) > 0.0
    env.close()


@pytest.mark.filterwarnings("ignore:.*precision lowered")
def test_pool_takes_a_batch_of_actions():
    pytest.importorskip("envpool")
    pool = Pool("Pendulum-v1", 3)
    pool.reset(seed=0)
    observations, *_ = pool.step(pool.action_space.sample())
    assert observations.shape == (3, 3)
    pool.close()


def test_command_writes_what_the_page_needs(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(benchmarks.environments, "peers", lambda: [peer(OURS), peer("CartPole-v1")])
    monkeypatch.setattr(benchmarks.environments, "memory", lambda *_: {"bytes_per_rig": 512.0, "resident_bytes": {}})
    path = tmp_path / "environments.json"
    main(["--sizes", "1", "64", "--repeats", "1", "--seconds", "0.01", "--json", str(path)])
    results = json.loads(path.read_text())["results"]
    assert set(results["rates"]) == {"1", "64"}
    assert set(results["rates"]["64"]) == {OURS, "CartPole-v1"} == set(results["environments"])
    assert results["rates"]["1"][OURS]["steps_per_second_random"] > 0.0
    printed = capsys.readouterr().out
    assert "| 64 | CartPole-v1 |" in printed
    assert "| 1 | DrillRig-v0 |" in printed
