"""How fits from many starts are done: by which engine, and what of them is kept."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.kept import Ended, Kept
from drillrig_env.engine import Engine, Local

if TYPE_CHECKING:
    from drillrig_env.calibrate.projection import Problem

Solve: TypeAlias = "Callable[[Problem, int, FloatArray], Ended]"
"""A fit of a problem with at most so many steps from one start."""

_SPEEDS = np.geomspace(0.01, 100.0, 41)
"""Speeds (rad/s) at which a law of the user's own is looked at: its file may have changed."""


@dataclass(frozen=True, eq=False)
class Search:
    """The engine that does the fits, and where those that are done are kept; neither changes a bit of how they end."""

    engine: Engine = field(default_factory=Local)
    kept: Kept | None = None

    def each(
        self, solve: Solve, problem: Problem, steps: int, places: Sequence[FloatArray]
    ) -> Iterator[tuple[int, Ended]]:
        """The number of each place and where the fit from there ended: those kept first, others as they are done."""
        if self.kept is None:
            yield from self.engine.each(partial(solve, problem, steps), places)
            return
        keys = [key_of(problem, steps, place) for place in places]
        open_ones = []
        for number, key in enumerate(keys):
            ended = self.kept.get(key)
            if ended is None:
                open_ones.append(number)
            else:
                yield number, ended
        for k, ended in self.engine.each(partial(solve, problem, steps), [places[number] for number in open_ones]):
            self.kept.put(keys[open_ones[k]], ended)
            yield open_ones[k], ended


def key_of(problem: Problem, steps: int, place: FloatArray) -> str:
    """The digest of all that decides how a fit from `place` ends."""
    unknowns = problem.unknowns
    law = unknowns.friction.torque(unknowns.rig, _SPEEDS)
    found = hashlib.sha256()
    for part in (unknowns, law, problem.noise, problem.windows, steps, place):
        _take(found, part)
    return found.hexdigest()


def _take(found: hashlib._Hash, part: Any) -> None:
    """Take in a record with all of its fields, a list, an array or a plain value."""
    if is_dataclass(part):
        part = [getattr(part, one.name) for one in fields(part)]
    if isinstance(part, list):
        found.update(f"[{len(part)}]".encode())
        for one in part:
            _take(found, one)
    elif isinstance(part, np.ndarray):
        found.update(f"{part.dtype}{part.shape}".encode())
        found.update(np.ascontiguousarray(part).tobytes())
    else:
        found.update(str(part).encode() + b";")
