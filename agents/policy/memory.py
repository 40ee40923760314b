"""Memory of a recurrent network as policies have it: arrays with one row a rig."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from stable_baselines3.common.base_class import BaseAlgorithm

Rows = tuple[npt.NDArray[Any], ...]
"""Hidden state and cell state of all layers, each of shape (rigs, layers * hidden)."""


def lstm_of(model: BaseAlgorithm) -> Any:
    """The `torch.nn.LSTM` of the part of a model that acts; None where it has no memory."""
    return getattr(model.policy, "lstm_actor", None)


def width_of(lstm: Any) -> int:
    """Numbers of a rig in each of the two parts of a memory."""
    return int(lstm.num_layers * lstm.hidden_size)


def rows_of(memory: Rows) -> Rows:
    """A memory as Stable-Baselines3 has it, (layers, rigs, hidden) each, with a row a rig."""
    return tuple(np.swapaxes(part, 0, 1).reshape(part.shape[1], -1) for part in memory)


def layers_of(rows: Rows, layers: int) -> Rows:
    """What `rows_of` was given, for so many layers."""
    return tuple(np.ascontiguousarray(np.swapaxes(part.reshape(len(part), layers, -1), 0, 1)) for part in rows)
