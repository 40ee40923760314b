"""What acts in a model, whichever algorithm it is of: its mean action, and how far it explores."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.sac.policies import SACPolicy


@dataclass(frozen=True)
class Actor:
    """What acts in a model: its mean action, a function of observations, and the parameters behind it.

    `spread` are the parameters of how far it explores, of which the first is the logarithm itself.
    """

    mean: Callable[[torch.Tensor], torch.Tensor]
    parameters: list[torch.nn.Parameter]
    spread: list[torch.nn.Parameter]

    def explore(self, log_std: float) -> None:
        """Explore everywhere with the same spread, of this logarithm."""
        with torch.no_grad():
            for parameter in self.spread:
                parameter.fill_(0.0)
            self.spread[0].fill_(log_std)


def is_finite(network: torch.nn.Module) -> bool:
    """Whether all weights of a network are numbers."""
    return all(bool(one.isfinite().all()) for one in network.parameters())


def actor_of(model: BaseAlgorithm) -> Actor:
    """The acting part of PPO or SAC; with a memory that of `AsymmetricPPO`, for episodes from their beginning on.

    `ValueError` for another algorithm.
    """
    policy: Any = model.policy
    recurrent: Any = model
    if hasattr(model, "no_memory"):

        def from_the_beginning(observations: torch.Tensor) -> torch.Tensor:
            means: torch.Tensor = recurrent.acts(observations, recurrent.no_memory(observations.shape[1]))[0]
            return means

        parts = (policy.lstm_actor, policy.mlp_extractor.policy_net, policy.action_net)
        return Actor(from_the_beginning, [one for part in parts for one in part.parameters()], [policy.log_std])
    if isinstance(policy, SACPolicy):
        actor: Any = policy.actor

        def squashed(observations: torch.Tensor) -> torch.Tensor:
            features = actor.extract_features(observations, actor.features_extractor)
            return torch.tanh(actor.mu(actor.latent_pi(features)))

        acting = [*actor.latent_pi.parameters(), *actor.mu.parameters()]
        return Actor(squashed, acting, [actor.log_std.bias, actor.log_std.weight])
    if isinstance(policy, ActorCriticPolicy) and isinstance(model, PPO):

        def mean(observations: torch.Tensor) -> torch.Tensor:
            found: torch.Tensor = network.action_net(
                network.mlp_extractor.forward_actor(network.extract_features(observations))
            )
            return found

        network: Any = policy
        acting = [*network.mlp_extractor.policy_net.parameters(), *network.action_net.parameters()]
        return Actor(mean, acting, [network.log_std])
    raise ValueError(f"{type(model).__name__} cannot imitate; allowed: PPO, SAC, AsymmetricPPO")
