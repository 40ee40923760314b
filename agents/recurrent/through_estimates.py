"""A network that acts on what its memory tells: the layers that act imitate a teacher who is told what they are told.

The memory learns to tell rig, friction, load and state from what was seen, and nothing else; the layers behind it learn
to act on the truth. Put in a row they act on estimates as if those were true: certainty equivalence. The estimates are
linear in the memory, so that both together are again the network of `AsymmetricPPO`, and trial may go on from there.
"""

from __future__ import annotations

from typing import Any

import torch
from torch import nn

from agents.recurrent.asymmetric import AsymmetricPPO


class ToldActor(nn.Module):
    """The acting layers of a model's network as they are where they are told what its critic is told."""

    def __init__(self, model: AsymmetricPPO) -> None:
        super().__init__()
        policy: Any = model.policy
        self.model = (model,)  # not a part of this one
        self.behind = policy.mlp_extractor.policy_net[0]  # the memory, in the network that acts
        self.first = nn.Linear(model.told_channels, self.behind.out_features).to(model.device)
        self.others = nn.Sequential(*policy.mlp_extractor.policy_net[1:], policy.action_net)

    def forward(self, told: torch.Tensor) -> torch.Tensor:
        """Mean actions, shape (steps, rigs), of what is `told` (steps, rigs, channels)."""
        found: torch.Tensor = self.others(self.first(told)).squeeze(-1)
        return found

    def settle(self) -> None:
        """Let the network act on what its memory estimates, as it would on the truth."""
        estimator = self.model[0].estimator
        with torch.no_grad():
            self.behind.weight.copy_(self.first.weight @ estimator.weight)
            self.behind.bias.copy_(self.first.weight @ estimator.bias + self.first.bias)
