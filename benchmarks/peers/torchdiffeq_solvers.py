"""torchdiffeq: dopri5 over a batch, all rigs in step; it has no implicit method for a right-hand side as stiff as this.

It takes thousands of steps a second of motion, each some hundred calls of PyTorch, and so gets one second only.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.case import START, Rigs, array_rates
from benchmarks.peers.peer import BatchPeer, Library, Run, Setting, settings
from drillrig_env.arrays import FloatArray

LIBRARY = Library("torchdiffeq", "torchdiffeq", "torchdiffeq")


def prepare_batch(rigs: Rigs, setting: Setting, times: FloatArray, threads: int) -> Run:
    """Many rigs with dopri5, on PyTorch's threads."""
    import torch
    from torchdiffeq import odeint

    torch.set_num_threads(threads)
    contact = torch.from_numpy(rigs.contacts).unbind(1)
    starts, grid = torch.from_numpy(START).repeat(len(rigs), 1), torch.from_numpy(times)

    def right_hand_side(_t: Any, x: Any) -> Any:
        return torch.stack(array_rates(torch, x.unbind(1), contact), dim=1)

    def run() -> FloatArray:
        with torch.no_grad():
            states = odeint(right_hand_side, starts, grid, rtol=setting.rtol, atol=setting.atol, method="dopri5")
        return np.asarray(states.permute(1, 0, 2))

    return run


BATCH_PEERS = (
    BatchPeer(
        LIBRARY,
        "dopri5, all cores",
        "PyTorch right-hand side, not compiled",
        settings(1e-6),
        prepare_batch,
        duration=1.0,
    ),
)
