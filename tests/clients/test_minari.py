"""Minari's data sets: episodes with their infos, and the environment rebuilt from what the data set says of it."""

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env

pytestmark = pytest.mark.clients
minari = pytest.importorskip("minari", reason="needs the extra clients")
pytest.importorskip("jax", reason="needs the extra clients")
pytest.importorskip("h5py", reason="needs the extra clients")

STEPS = 8
RIG = {"J_1": 0.03}
SCENARIO = {"normal_force": (12.0, 12.0), "load_step": 1.0}
KWARGS = {
    "plain": {},
    "rig and scenario as dictionaries": {"rig": RIG, "scenario": SCENARIO},
    "rig and scenario as objects": {
        "rig": drillrig_env.Rig(J_1=0.03),
        "scenario": drillrig_env.Scenario(normal_force=(12.0, 12.0), load_step=1.0),
    },
    "noise, delay and drive": {"noise": 1.0, "delay": (1, 3), "drive": (0.04, 0.06, 1.0)},
    "reward and sensors": {"reward": {"action": 0.1}, "sensors": ("top_speed", "current", "speed_target")},
}


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))


def collected(name, episodes=3, **kwargs):
    env = minari.DataCollector(gym.make(name, duration=STEPS / 10, **kwargs), record_infos=True)
    env.action_space.seed(0)
    for episode in range(episodes):
        env.reset(seed=episode)
        over = False
        while not over:
            *_, terminated, truncated, _ = env.step(env.action_space.sample())
            over = terminated or truncated
    return env.create_dataset("drillrig/test-v0", author="a", author_email="a@b.c", code_permalink="https://b.c")


@pytest.mark.parametrize("name", drillrig_env.ENVIRONMENTS)
def test_episodes_come_back_with_their_infos(name):
    collected(name)
    data = minari.load_dataset("drillrig/test-v0")
    assert (data.total_episodes, data.total_steps) == (3, 3 * STEPS)
    for episode in data:
        assert episode.truncations.tolist() == [False] * (STEPS - 1) + [True]
        for key, values in episode.infos.items():
            assert np.asarray(values).shape == (STEPS + 1,), key
        assert episode.infos["is_success"].dtype == np.bool_
        targets = np.unique(episode.infos["speed_target"])
        assert len(targets) == (2 if name == "DrillRigDrift-v0" else 1)  # whose target steps


@pytest.mark.parametrize("kwargs", KWARGS.values(), ids=KWARGS)
def test_environment_is_rebuilt_from_the_data_set(kwargs):
    collected("DrillRig-v0", **kwargs)
    data = minari.load_dataset("drillrig/test-v0")
    env = data.recover_environment()
    for number, episode in enumerate(data):
        observation, _ = env.reset(seed=number)
        np.testing.assert_array_equal(observation, episode.observations[0])
        for k, action in enumerate(episode.actions):
            observation, reward, *_ = env.step(action)
            np.testing.assert_array_equal(observation, episode.observations[k + 1])
            assert reward == episode.rewards[k]
