"""An anchor: while it learns by trial, the actor is held near what it could do before its first step.

A critic that has only begun to learn praises actions that it has never seen, and an actor that follows forgets in a
thousand updates what it imitated in a minute. As in TD3+BC (Fujimoto & Gu, 2021), the actor's cost has a second
term, the cost of imitation, here towards the actor of the first model: it may move where the critic insists.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm

from agents.policy.run_folder import FIRST_MODEL
from agents.policy.weights import load_weights
from agents.training.actor import actor_of
from agents.training.checkpoint import save_model
from agents.training.imitation import imitation_cost

_ROWS = 1024  # observations for which the actor is compared in an update


class Anchor(BaseCallback):
    """Add `strength` times the cost of imitation of the first model to the actor's cost in every update.

    The first model is written into the run's `folder` and read from there by a training that goes on; `config` is
    the run's. The observations are those that the update itself can draw on.
    """

    def __init__(self, folder: Path, config: Mapping[str, Any], strength: float) -> None:
        super().__init__()
        self.path, self.config, self.strength = folder / FIRST_MODEL, config, strength
        self._hook: Any = None

    def _on_training_start(self) -> None:
        model: Any = self.model
        if self.num_timesteps == 0:
            save_model(self.path, model)
        # The first weights are overwritten at once: a resumed training draws on as an uncut one.
        with torch.random.fork_rng():
            loaded = load_weights(self.path, self.config)
        loaded.policy.to(model.device)
        first = actor_of(loaded)
        actor = actor_of(model)
        optimiser = model.policy.optimizer if isinstance(model, OnPolicyAlgorithm) else model.actor.optimizer

        def pull(*_: object) -> None:
            if not actor.parameters[0].requires_grad:  # the critic's warm-up
                return
            observations = self._observations()
            with torch.no_grad():
                wanted = first.mean(observations).clamp(-1.0, 1.0)
            (self.strength * imitation_cost(actor.mean(observations), wanted)).backward()  # type: ignore[no-untyped-call]

        self._hook = optimiser.register_step_pre_hook(pull)

    def _on_training_end(self) -> None:
        self._hook.remove()

    def _on_step(self) -> bool:
        return True

    def _observations(self) -> torch.Tensor:
        """Some of the observations that this update learns from."""
        model: Any = self.model
        if not isinstance(model, OnPolicyAlgorithm):
            return model.replay_buffer.sample(_ROWS).observations  # type: ignore[no-any-return]
        every = model.rollout_buffer.observations
        rows: torch.Tensor = torch.from_numpy(every.reshape(-1, every.shape[-1]))
        return rows[torch.randint(len(rows), (_ROWS,))].to(model.device)
