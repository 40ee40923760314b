"""PPO in one file, as a researcher writes it who brings a training loop of their own to the environment."""

from __future__ import annotations

from dataclasses import dataclass

import gymnasium as gym
import numpy as np
import torch
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import RecordEpisodeStatistics
from torch import nn
from torch.distributions import Normal


@dataclass(frozen=True)
class Settings:
    """What a training may be told."""

    autoreset_mode: AutoresetMode = AutoresetMode.SAME_STEP
    seed: int = 0
    rigs: int = 4
    steps: int = 32  # a rig, between updates
    updates: int = 3
    epochs: int = 4
    learning_rate: float = 3e-3
    discount: float = 0.99
    smoothing: float = 0.95  # lambda of the generalised advantage
    clip: float = 0.2


class Agent(nn.Module):
    """A Gaussian policy and a value function, each with one hidden layer."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.critic = nn.Sequential(nn.Linear(channels, 32), nn.Tanh(), nn.Linear(32, 1))
        self.actor = nn.Sequential(nn.Linear(channels, 32), nn.Tanh(), nn.Linear(32, 1))
        self.log_deviation = nn.Parameter(torch.full((1,), -0.5))

    def policy(self, observations: torch.Tensor) -> Normal:
        return Normal(self.actor(observations), self.log_deviation.exp())

    def value(self, observations: torch.Tensor) -> torch.Tensor:
        return self.critic(observations)[..., 0]


def train(settings: Settings, **kwargs) -> tuple[list[float], Agent]:
    """Returns of the episodes that ended, and the agent; `kwargs` as for the environment."""
    torch.manual_seed(settings.seed)
    mode, discount = settings.autoreset_mode, settings.discount
    envs = gym.make_vec("DrillRig-v0", num_envs=settings.rigs, autoreset_mode=mode, **kwargs)
    envs = RecordEpisodeStatistics(envs)
    agent = Agent(envs.single_observation_space.shape[0])
    optimiser = torch.optim.Adam(agent.parameters(), lr=settings.learning_rate)
    shape = (settings.steps, settings.rigs)
    first, _ = envs.reset(seed=settings.seed)
    observation, over, returns = torch.as_tensor(first), np.zeros(settings.rigs, bool), []
    for _ in range(settings.updates):
        seen, after = torch.zeros(*shape, len(first[0])), torch.zeros(*shape, len(first[0]))
        actions, scores, rewards = torch.zeros(*shape, 1), torch.zeros(shape), torch.zeros(shape)
        ended, real = torch.zeros(shape), torch.ones(shape)
        for k in range(settings.steps):
            with torch.no_grad():
                policy = agent.policy(observation)
                action = policy.sample()
            # In the mode NEXT_STEP the step after an episode's last only begins the next: nothing to learn from.
            if mode == AutoresetMode.NEXT_STEP:
                real[k] = torch.as_tensor(~over).float()
            seen[k], actions[k], scores[k] = observation, action, policy.log_prob(action)[..., 0]
            following, reward, terminated, truncated, info = envs.step(action.clamp(-1, 1).numpy())
            over = terminated | truncated
            observation = torch.as_tensor(following)
            after[k], rewards[k], ended[k] = observation, torch.as_tensor(reward), torch.as_tensor(over).float()
            if over.any():
                returns += info["episode"]["r"][over].tolist()
                if mode == AutoresetMode.SAME_STEP:
                    after[k][over] = torch.as_tensor(np.stack(info["final_obs"][over]))
        # Episodes are cut, never failed: the value of the state after the last step counts.
        with torch.no_grad():
            values = agent.value(seen)
            errors = rewards + discount * agent.value(after) - values
            advantages, running = torch.zeros(shape), torch.zeros(settings.rigs)
            for k in reversed(range(settings.steps)):
                running = errors[k] + discount * settings.smoothing * (1 - ended[k]) * running
                advantages[k] = running
        use = real.bool()
        seen, actions, scores, advantages = seen[use], actions[use], scores[use], advantages[use]
        targets = advantages + values[use]
        advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
        for _ in range(settings.epochs):
            ratio = (agent.policy(seen).log_prob(actions)[..., 0] - scores).exp()
            clipped = ratio.clamp(1 - settings.clip, 1 + settings.clip)
            gain = torch.minimum(ratio * advantages, clipped * advantages).mean()
            loss = 0.5 * (agent.value(seen) - targets).square().mean() - gain
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
    envs.close()
    return returns, agent
