"""Copies of an environment, by copy.deepcopy and pickle: they go on bit for bit, and apart from the original."""

import copy
import pickle
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms

RIGS = 3
VARYING = {
    "wandering": {"time": 2.0},
    "tilt": {"turns": (1, 3)},
    "target_step": 0.7,
    "course": {"time": [0.0, 0.5, 1.7], "normal_force": [12.0, 30.0, 20.0]},
}
NOISY = {"sensors": "surface", "noise": 1.0, "delay": (0, 4), "drive": (0.3, 0.2, 0.5), "duration": 3.0}
NOISY["scenario"] = VARYING
COPIES = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
    "of a copy": lambda env: copy.deepcopy(pickle.loads(pickle.dumps(env))),
}
FORMS = {
    "single": lambda: gym.make("DrillRig-v0", **NOISY),
    "bare": lambda: gym.make("DrillRig-v0", **NOISY).unwrapped,
    "vector": lambda: gym.make_vec("DrillRig-v0", num_envs=RIGS, **NOISY),
    "same step": lambda: gym.make_vec("DrillRig-v0", num_envs=RIGS, autoreset_mode="SameStep", **NOISY),
    "sb3": lambda: drillrig_env.make_sb3(RIGS, seed=5, **NOISY),
}
ACTIONS = np.random.default_rng(1).uniform(-1.2, 1.2, (80, RIGS, 1)).astype(np.float32)


class Player:
    """Plays an environment of any form under ACTIONS, beginning episodes anew where it must."""

    def __init__(self, form):
        self.form, self.env, self.step, self.over = form, FORMS[form](), 0, True

    def reset(self, seed=None):
        self.over = False
        self.env.reset() if self.form == "sb3" else self.env.reset(seed=seed)

    def run(self, steps):
        """What the next steps show, as bytes."""
        seen = []
        for _ in range(steps):
            actions, self.step = ACTIONS[self.step], self.step + 1
            if self.form in ("single", "bare"):
                if self.over:
                    self.reset()
                observation, reward, _, self.over, _ = self.env.step(actions[0])
            else:
                observation, reward, *_ = self.env.step(actions)
            seen.append(np.asarray(observation).tobytes() + np.asarray(reward).tobytes())
        return seen

    def copied(self, how):
        twin = object.__new__(Player)
        twin.__dict__.update(self.__dict__)
        twin.env = how(self.env)
        return twin


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("before", [0, 12, 30])
def test_a_copy_goes_on_bit_for_bit_and_apart(form, how, before):
    """In the middle and at the end of an episode of 30 steps, with noise, drawn delays, and through later draws."""
    first, undisturbed = Player(form), Player(form)
    for player in (first, undisturbed):
        player.reset(seed=5)
        player.run(before)
    twin = first.copied(COPIES[how])
    expected = undisturbed.run(40)
    assert len(set(expected)) == 40
    assert twin.run(25) == expected[:25]
    assert first.run(40) == expected  # the copy has left it alone
    assert twin.run(15) == expected[25:]


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("form", FORMS)
def test_a_copy_from_before_the_first_reset(form, how):
    first = Player(form)
    twin = first.copied(COPIES[how])
    runs = []
    for player in (first, twin):
        player.reset(seed=8)
        runs.append(player.run(35))
    assert runs[0] == runs[1]


def test_a_copy_takes_changes_of_its_own():
    env = gym.make("DrillRig-v0").unwrapped
    env.reset(seed=0)
    twin = copy.deepcopy(env)
    twin.slew_limit = 0.5
    assert env.slew_limit == 2.0
    up = np.ones(1, np.float32)
    assert env.step(up)[-1]["speed_reference"] > twin.step(up)[-1]["speed_reference"]


def test_a_shallow_copy_is_another_hand_on_the_same_rig():
    env = gym.make("DrillRig-v0").unwrapped
    env.reset(seed=0)
    copy.copy(env).step(np.ones(1, np.float32))
    assert env.core.episodes["step"][0] == 1


def test_the_batch_core_can_be_copied():
    core = EpisodeBatch(4, sensors="surface")
    core.reset(np.arange(4), first_uniforms(3, 4))
    twins = [copy.deepcopy(core), pickle.loads(pickle.dumps(core))]
    for batch in (core, *twins):
        for actions in ACTIONS[:20, :1].repeat(4, axis=1):
            batch.step(actions)
    for twin in twins:
        np.testing.assert_array_equal(twin.observations, core.observations)
        assert twin.episodes.tobytes() == core.episodes.tobytes()


def test_observations_that_were_given_out_stay_as_they_were():
    env = gym.make("DrillRig-v0").unwrapped
    first, _ = env.reset(seed=0)
    kept = first.copy()
    copy.deepcopy(env).step(np.ones(1, np.float32))
    np.testing.assert_array_equal(first, kept)


def test_a_copy_of_one_that_is_rendered_draws_the_same(monkeypatch):
    pytest.importorskip("pygame", reason="rendering needs the extra `render` (pygame-ce)")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    up = np.ones(1, np.float32)
    env = gym.make("DrillRig-v0", render_mode="rgb_array")
    env.reset(seed=0)
    for _ in range(15):
        env.step(up)
    twin = pickle.loads(pickle.dumps(env))
    np.testing.assert_array_equal(twin.render(), env.render())
    twin.step(up)
    assert not np.array_equal(twin.render(), env.render())
    env.step(up)
    np.testing.assert_array_equal(twin.render(), env.render())
    window = gym.make("DrillRig-v0", render_mode="human")
    window.reset(seed=0)
    silent = copy.deepcopy(window)
    assert silent.render_mode is None
    np.testing.assert_array_equal(silent.step(up)[0], window.step(up)[0])
    window.close()


SPAWNED = """
import gymnasium as gym, numpy as np
from stable_baselines3.common.vec_env import SubprocVecEnv
import drillrig_env

class Built:
    def __init__(self, env): self.env = env
    def __call__(self): return self.env

if __name__ == "__main__":
    envs = [gym.make("DrillRig-v0", scenario="nominal") for _ in range(2)]
    for i, env in enumerate(envs):
        env.reset(seed=i)
    vec = SubprocVecEnv([Built(env) for env in envs], start_method="spawn")
    seen = vec.reset()
    expected = np.stack([env.reset()[0] for env in envs])
    np.testing.assert_array_equal(seen, expected)
    seen, rewards, _, _ = vec.step(np.ones((2, 1), np.float32))
    expected = [env.step(np.ones(1, np.float32)) for env in envs]
    np.testing.assert_array_equal(seen, np.stack([one[0] for one in expected]))
    vec.env_method("change", slew_limit=0.5)
    assert vec.get_attr("slew_limit") == [0.5, 0.5]
    before = vec.get_attr("core")[0].episodes["speed_reference"][0]
    vec.step(np.ones((2, 1), np.float32))
    after = vec.get_attr("core")[0].episodes["speed_reference"][0]
    assert abs(after - before - 0.05) < 1e-12
    vec.close()
    print("alike")
"""


@pytest.mark.slow
def test_built_environments_go_into_spawned_processes(tmp_path):
    script = tmp_path / "spawned.py"
    script.write_text(SPAWNED)
    run = subprocess.run([sys.executable, script], capture_output=True, check=False, text=True)
    assert run.stdout.strip() == "alike", run.stderr
