"""A shipped model by its algorithm alone: loaded and stacked as any other, it acts as the agent of the contract."""

import numpy as np
import pytest
from stable_baselines3.common.vec_env import VecFrameStack

import drillrig_env
from agents.policy.run_folder import MODEL, find_run, read_config, shipped
from agents.training.hyperparameters import algorithm_class
from drillrig_env.policy import load

RIGS, STEPS = 4, 30


@pytest.mark.parametrize("name", shipped())
def test_it_acts_bit_for_bit_as_the_agent_does(name):
    agent = load(name)
    agent = agent.at_slew_limit(agent.slew_limit)  # the model's action is a share of the limit that it was trained with
    env = drillrig_env.make_sb3(RIGS, seed=5, env_id=agent.env_id, duration=STEPS / 20, **agent.env_kwargs)
    if agent.frames > 1:
        env = VecFrameStack(env, agent.frames)
    folder = find_run(name)
    model = algorithm_class(read_config(folder)["algorithm"]).load(folder / MODEL, device="cpu")
    channels = len(agent.sensors.names)
    observation, state, memory, starts = env.reset(), None, None, np.ones(RIGS, dtype=bool)
    for _ in range(STEPS):  # two episodes
        action, state = model.predict(observation, state, starts, deterministic=True)
        same, memory = agent.predict(observation[:, -channels:], memory, starts)
        np.testing.assert_array_equal(action, same)
        observation, _, starts, _ = env.step(action)
    assert starts.all()
