"""How a training begins: episodes out of step with each other, and a critic that learns before the actor does."""

from __future__ import annotations

from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.vec_env import VecEnv

from agents.policy.environment import batch_of
from agents.training.imitation import actor_of


def stagger(env: VecEnv) -> None:
    """Let the first episodes end one after another, so that a rollout holds all of their phases."""
    core = batch_of(env).core
    core.episodes["step"] = np.arange(len(core)) * core.steps // len(core)


class WarmUp(BaseCallback):
    """Stagger the first episodes, and hold the actor for the first `iterations` rollouts: only the critic learns.

    An actor that knows something already would else be pulled by a critic that knows nothing.
    """

    def __init__(self, iterations: int, staggered: bool) -> None:
        super().__init__()
        self.iterations, self.staggered = iterations, staggered

    def _on_training_start(self) -> None:
        if self.staggered and self.num_timesteps == 0:
            stagger(self.training_env)

    def _on_rollout_end(self) -> None:
        if not self.iterations:
            return
        actor = actor_of(self.model)
        learns = self.num_timesteps > self.iterations * self._rollout() * self.training_env.num_envs
        for parameter in (*actor.parameters, *actor.spread):
            parameter.requires_grad_(learns)

    def _rollout(self) -> int:
        """Steps of every rig between two updates."""
        model: Any = self.model
        return int(model.n_steps if isinstance(model, OnPolicyAlgorithm) else model.train_freq.frequency)

    def _on_step(self) -> bool:
        return True
