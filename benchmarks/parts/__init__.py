"""The parts of the performance page: for each benchmark its tables, its picture and what it comes to."""

from __future__ import annotations

from benchmarks.parts.batches import BATCHES
from benchmarks.parts.environments import ENVIRONMENTS
from benchmarks.parts.part import Part
from benchmarks.parts.room import ROOM
from benchmarks.parts.solvers import SOLVERS
from benchmarks.parts.stability import STABILITY
from benchmarks.parts.startup import STARTUP
from benchmarks.parts.training import TRAINING

__all__ = ["PARTS", "Part"]

PARTS: tuple[Part, ...] = (SOLVERS, BATCHES, ENVIRONMENTS, STARTUP, TRAINING, STABILITY, ROOM)
"""In the page's order."""
