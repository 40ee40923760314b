"""Stable-Baselines3's wrappers around the `VecEnv`, and its own vector environments around the plain one."""

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env

vec_env = pytest.importorskip("stable_baselines3.common.vec_env", reason="needs the extra agents")
RIGS = 3
WRAPPERS = {
    "VecNormalize": vec_env.VecNormalize,
    "VecMonitor": vec_env.VecMonitor,
    "VecCheckNan": lambda env: vec_env.VecCheckNan(env, raise_exception=True),
    "VecFrameStack": lambda env: vec_env.VecFrameStack(env, 3),
}


@pytest.mark.parametrize("name", WRAPPERS)
def test_wrapped_beyond_the_end_of_episodes(name):
    env = WRAPPERS[name](drillrig_env.make_sb3(RIGS, seed=0, duration=0.5))
    observations = env.reset()
    for k in range(1, 13):
        observations, rewards, dones, infos = env.step(np.full((RIGS, 1), 0.3, np.float32))
        assert env.observation_space.contains(observations[0])
        assert np.isfinite(rewards).all()
        assert dones.all() == (k % 5 == 0)
        if dones.all():
            assert all({"episode", "terminal_observation", "is_success"} <= set(info) for info in infos)


def test_normalisation_is_kept_and_loaded(tmp_path):
    env = vec_env.VecNormalize(drillrig_env.make_sb3(RIGS, seed=0))
    env.reset()
    for _ in range(5):
        env.step(np.zeros((RIGS, 1), np.float32))
    env.save(str(tmp_path / "normalize.pkl"))
    loaded = vec_env.VecNormalize.load(str(tmp_path / "normalize.pkl"), drillrig_env.make_sb3(RIGS, seed=0))
    np.testing.assert_array_equal(loaded.obs_rms.mean, env.obs_rms.mean)


def built(began):
    env = gym.make("DrillRig-v0", duration=0.5)
    if began:
        env.reset(seed=9)
        env.step(np.ones(1, np.float32))
    return env


class Built:
    """Gives an environment that was built, and perhaps used, before its process was started."""

    def __init__(self, env):
        self.env = env

    def __call__(self):
        return self.env


@pytest.mark.clients
@pytest.mark.parametrize("began", [False, True])
def test_spawned_processes_take_built_environments(began):
    env = vec_env.SubprocVecEnv([Built(built(began)), Built(built(began))], start_method="spawn")
    ours = drillrig_env.make_sb3(2, seed=4, duration=0.5)
    try:
        env.seed(4)
        np.testing.assert_array_equal(env.reset(), ours.reset())
        for k in range(5):
            action = np.full((2, 1), 0.1 * k, np.float32)
            (observations, rewards, dones, _), (expected, expected_rewards, ended, _) = (
                env.step(action),
                ours.step(action),
            )
            np.testing.assert_array_equal(observations, expected)
            np.testing.assert_array_equal(rewards.astype(np.float32), expected_rewards)
            np.testing.assert_array_equal(dones, ended)
    finally:
        env.close()


@pytest.mark.parametrize(
    "kind", ["ours", "ours, as attributes", "dummy", pytest.param("subproc", marks=pytest.mark.clients)]
)
def test_a_curriculum_changes_the_scenario(kind):
    makers = [lambda: gym.make("drillrig_env:DrillRig-v0", duration=0.5)] * RIGS
    if kind.startswith("ours"):
        env = drillrig_env.make_sb3(RIGS, seed=0, duration=0.5)
    else:
        env = {"dummy": vec_env.DummyVecEnv, "subproc": vec_env.SubprocVecEnv}[kind](makers)
        env.seed(0)
    try:
        env.reset()
        if kind == "ours, as attributes":
            env.set_attr("scenario", {"speed_target": (4.5, 4.5)})
            env.set_attr("slew_limit", 1.0)
        else:
            env.env_method("change", scenario={"speed_target": (4.5, 4.5)}, slew_limit=1.0)
        assert env.get_attr("slew_limit") == [1.0] * RIGS
        target = env.get_attr("sensors")[0].value(env.reset(), "speed_target")
        np.testing.assert_allclose(target, 4.5, atol=1e-6)
    finally:
        env.close()


@pytest.mark.clients
def test_video_of_several_rigs(tmp_path):
    pytest.importorskip("pygame")
    pytest.importorskip("moviepy")
    env = vec_env.VecVideoRecorder(
        drillrig_env.make_sb3(2, seed=0, render_mode="rgb_array"), str(tmp_path), lambda step: step == 0, video_length=5
    )
    env.reset()
    for _ in range(6):
        env.step(np.zeros((2, 1), np.float32))
    env.close()
    assert [path.suffix for path in tmp_path.iterdir()] == [".mp4"]
