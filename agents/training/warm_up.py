"""How a training begins: episodes out of step with each other, and a critic that learns before the actor does."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.vec_env import VecEnv

from agents.policy.environment import batch_of
from agents.training.actor import actor_of
from agents.training.hyperparameters import algorithm_class


def stagger(env: VecEnv, apart: int = 1) -> None:
    """Let the first episodes end one after another, so that a rollout holds all of their phases.

    They do so at multiples of `apart` control steps.
    """
    core = batch_of(env).core
    core.episodes["step"] = np.arange(len(core)) * (core.steps // apart) // len(core) * apart


def steps_held(algorithm: str, chosen: Mapping[str, Any]) -> int:
    """Steps of the environment for which hyperparameters hold the actor of an algorithm, while its critic learns."""
    kind = algorithm_class(algorithm)
    name = "n_steps" if issubclass(kind, OnPolicyAlgorithm) else "train_freq"
    rollout = chosen.get(name, inspect.signature(kind).parameters[name].default)
    length = rollout[0] if isinstance(rollout, list | tuple) else rollout
    return int(chosen.get("critic_iterations", 0) * length * chosen.get("n_envs", 1))


class WarmUp(BaseCallback):
    """Stagger the first episodes, and hold the actor for the first `iterations` rollouts: only the critic learns.

    An actor that knows something already would else be pulled by a critic that knows nothing. What SAC pays for
    exploring is held too: it would fall as long as nothing answers it.
    """

    def __init__(self, iterations: int, staggered: bool) -> None:
        super().__init__()
        self.iterations, self.staggered = iterations, staggered
        self._hook: Any = None

    def _on_training_start(self) -> None:
        if self.staggered and self.num_timesteps == 0:
            stagger(self.training_env, self._rollout() if hasattr(self.model, "no_memory") else 1)
        price = getattr(self.model, "ent_coef_optimizer", None)
        if self.iterations and price is not None:
            self._hook = price.register_step_pre_hook(self._hold)

    def _on_rollout_end(self) -> None:
        if not self.iterations:
            return
        actor = actor_of(self.model)
        for parameter in (*actor.parameters, *actor.spread):
            parameter.requires_grad_(self._learns())

    def _on_training_end(self) -> None:
        if self._hook is not None:
            self._hook.remove()

    def _hold(self, optimiser: torch.optim.Optimizer, *_: object) -> None:
        if not self._learns():
            optimiser.zero_grad()

    def _learns(self) -> bool:
        """Whether the actor learns from the last rollout."""
        return self.num_timesteps > self.iterations * self._rollout() * self.training_env.num_envs

    def _rollout(self) -> int:
        """Steps of every rig between two updates."""
        model: Any = self.model
        return int(model.n_steps if isinstance(model, OnPolicyAlgorithm) else model.train_freq.frequency)

    def _on_step(self) -> bool:
        return True
