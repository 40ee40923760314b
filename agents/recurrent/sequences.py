"""What a rollout of a recurrent policy leaves: whole sequences of all rigs, and what each action was worth."""

from __future__ import annotations

import torch

State = tuple[torch.Tensor, torch.Tensor]
"""Hidden and cell state of an LSTM, each of shape (layers, rigs, hidden)."""


class Sequences:
    """Arrays of a rollout of `steps` control steps of `rigs` rigs, on a device; the first index is the step.

    `observations` (steps, rigs, channels) are what the policy saw, `told` (steps + 1, rigs, told channels) what its
    critic was told, the last of them of the state after the rollout: where an episode ended there, of its last one.
    No episode may begin within a rollout, so that a memory never has to be cleared on the way.
    """

    def __init__(self, steps: int, rigs: int, channels: int, told: int, device: torch.device) -> None:
        def empty(*shape: int) -> torch.Tensor:
            return torch.empty(shape, device=device)

        self.steps = steps
        self.observations, self.told = empty(steps, rigs, channels), empty(steps + 1, rigs, told)
        self.actions, self.log_probs, self.rewards = (empty(steps, rigs) for _ in range(3))
        self.first: State = empty(0), empty(0)  # the memory with which it begins
        self.advantages = self.returns = empty(0)

    def reckon(self, values: torch.Tensor, gamma: float, gae_lambda: float) -> None:
        """Returns and advantages, each of shape (steps, rigs), from the `values` (steps + 1, rigs) of what was told.

        Generalised advantage estimation (Schulman et al., 2016) with discount `gamma` and `gae_lambda`. A time limit is
        no end of the rig: its last value counts as that of any other state.
        """
        self.advantages = torch.empty_like(self.rewards)
        advantage = torch.zeros_like(self.rewards[0])
        for step in reversed(range(self.steps)):
            surprise = self.rewards[step] + gamma * values[step + 1] - values[step]
            advantage = surprise + gamma * gae_lambda * advantage
            self.advantages[step] = advantage
        self.returns = self.advantages + values[:-1]
