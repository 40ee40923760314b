"""The shortest steps of rigs, whose tables are made when a kernel first needs them.

A kernel that is on its way down the ladder cannot come back to Python for them. It calls a function of Python's
instead, by its address, which takes the lock of the interpreter for as long as it makes them. They depend on nothing
but the rig, so that it does not matter who asks for them, nor when.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from drillrig_env.drive import Drive, Limiting
from drillrig_env.rig import Rig
from drillrig_env.stepper.ladder import DEPTH, RUNG
from drillrig_env.stepper.limits import with_lag
from drillrig_env.stepper.rungs import in_units, shortest_rungs
from drillrig_env.stepper.units import units_of

CALL = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64)
"""What makes a function callable for a kernel."""

_UNSOLVED = np.full(DEPTH, np.nan).astype(RUNG)
"""Tables with which no step is solved."""


def address_of(call: Any) -> int:
    """The address of a CALL, for as long as it is kept."""
    return int(ctypes.cast(call, ctypes.c_void_p).value or 0)


class Shortest:
    """Makes the tables of the shortest steps of a rig on a drive, by its number, and keeps them.

    It writes where they are into the rig's record of `ladders`.
    """

    def __init__(self, rigs: Sequence[tuple[Rig, Drive | Limiting | None]], period: float, ladders: np.ndarray) -> None:
        self._rigs, self._period, self._ladders = tuple(rigs), period, ladders
        self._kept = dict[int, np.ndarray]()

    def __call__(self, number: int) -> int:
        """The address of the tables. Where memory is wanting, or Ctrl-C comes, of ones with which no step is solved."""
        try:
            if number not in self._kept:
                self._kept.setdefault(number, self._made(number))  # another thread may have been faster
                self._ladders["shortest"][number] = self._kept[number].ctypes.data
            return self._kept[number].ctypes.data
        except (MemoryError, KeyboardInterrupt):  # no error can leave a kernel
            return _UNSOLVED.ctypes.data

    def _made(self, number: int) -> np.ndarray:
        rig, drive = self._rigs[number]
        rig = with_lag(rig)
        units = units_of(rig)
        with np.errstate(over="ignore", invalid="ignore"):
            return shortest_rungs(*in_units(rig, drive, units, self._period), units)
