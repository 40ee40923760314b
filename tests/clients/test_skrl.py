"""skrl's PPO on a rig and on several."""

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env  # noqa: F401 - registers the environments

pytestmark = pytest.mark.clients
torch = pytest.importorskip("torch", reason="needs the extra clients")
pytest.importorskip("skrl", reason="needs the extra clients")


def models(env):
    from skrl.utils.model_instantiators.torch import deterministic_model, gaussian_model

    network = [{"name": "net", "input": "OBSERVATIONS", "layers": [16], "activations": "tanh"}]
    spaces = {"observation_space": env.observation_space, "action_space": env.action_space, "device": env.device}
    parts = {
        "policy": gaussian_model(**spaces, network=network, output="ACTIONS"),
        "value": deterministic_model(**spaces, network=network, output="ONE"),
    }
    for role, model in parts.items():
        model.init_state_dict(role=role)
    return parts


@pytest.mark.parametrize("rigs", [None, 3])
def test_a_few_steps_of_ppo(rigs, tmp_path):
    from skrl.agents.torch.ppo import PPO
    from skrl.envs.wrappers.torch import wrap_env
    from skrl.memories.torch import RandomMemory
    from skrl.trainers.torch import SequentialTrainer

    plain = gym.make_vec("DrillRig-v0", num_envs=rigs, duration=0.5) if rigs else gym.make("DrillRig-v0", duration=0.5)
    env = wrap_env(plain)
    assert env.num_envs == (rigs or 1)
    torch.manual_seed(0)
    parts = models(env)
    before = [parameter.detach().clone() for parameter in parts["policy"].parameters()]
    agent = PPO(
        models=parts,
        memory=RandomMemory(memory_size=16, num_envs=env.num_envs, device=env.device),
        observation_space=env.observation_space,
        action_space=env.action_space,
        device=env.device,
        cfg={"rollouts": 16, "experiment": {"directory": str(tmp_path), "write_interval": 0, "checkpoint_interval": 0}},
    )
    trainer = SequentialTrainer(
        cfg={"timesteps": 32, "headless": True, "disable_progressbar": True},
        env=env,
        agents=agent,
    )
    trainer.train()
    after = list(parts["policy"].parameters())
    assert all(bool(torch.isfinite(parameter).all()) for parameter in after)
    assert not all(torch.equal(*pair) for pair in zip(before, after, strict=True))


@pytest.mark.parametrize("rigs", [None, 3])
def test_steps_are_the_environments_own(rigs):
    from skrl.envs.wrappers.torch import wrap_env

    def make():
        return gym.make_vec("DrillRig-v0", num_envs=rigs) if rigs else gym.make("DrillRig-v0")

    env, plain = wrap_env(make()), make()
    env._seed = 5
    observations, _ = env.reset()
    expected, _ = plain.reset(seed=5)
    np.testing.assert_array_equal(observations.numpy().reshape(expected.shape), expected)
    observations, rewards, *_ = env.step(torch.full((env.num_envs, 1), 0.5))
    expected, expected_rewards, *_ = plain.step(np.full(plain.action_space.shape, 0.5, np.float32))
    np.testing.assert_array_equal(observations.numpy().reshape(expected.shape), expected)
    np.testing.assert_array_equal(rewards.numpy().ravel(), np.float32(expected_rewards).ravel())
