"""An evaluation in pieces: some rigs of a suite for one training seed of a policy, cut by the rigs' numbers alone.

Where a piece is done changes nothing in it: its size belongs to the suite (a network's batch decides its last bits),
its draws follow from the rigs' numbers, and a policy is made anew for each.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from drillrig_env.evaluation.histories import TRACES
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import LARGE, Suite
from drillrig_env.files import read_arrays, written_whole

if TYPE_CHECKING:
    from drillrig_env.evaluation.contest import Contestant

PIECES = "pieces"
"""The folder, in that of an evaluation, of pieces whose policy is not done yet."""

_TRACES = "traces"

Told = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Piece:
    """Rigs `first` to `first` + `count` - 1 of a suite for one seed of a contestant, which is told by its place."""

    contestant: int
    seed: str
    first: int
    count: int


@dataclass(frozen=True)
class Played:
    """What came of a piece: a row of scores a rig, and where wanted TRACES of its rigs, shape (traces, rigs, steps)."""

    scores: dict[str, npt.NDArray[Any]]
    traces: npt.NDArray[np.float32] | None = None


class Field:
    """Contestants in a suite: called with a piece, it plays it. `told` hears of steps, where that can be heard."""

    def __init__(self, suite: Suite, contestants: Sequence[Contestant], told: Told | None = None) -> None:
        self.suite, self.contestants, self.told = suite, list(contestants), told

    def __call__(self, piece: Piece) -> Played:
        """Play a piece. Raises whatever the policy raises."""
        contestant = self.contestants[piece.contestant]
        part = self.suite.part(piece.first, piece.count)
        shown = None
        if self.told is not None:
            all_pieces, told = pieces_of(self.suite, contestant, piece.contestant), self.told
            before = all_pieces.index(piece)

            def shown(done: int, of: int) -> None:
                told(contestant.name, before * of + done, len(all_pieces) * of)

        episodes = run(contestant.members[piece.seed](self.suite), part, progress=shown, **contestant.env)
        numbers = np.arange(piece.first, piece.first + piece.count)
        scores = {"seed": np.full(piece.count, piece.seed), "episode": numbers, **score(episodes)}
        traces = None
        if piece.seed == next(iter(contestant.members)) and (piece.first == 0 or self.suite.rigs <= LARGE):
            traces = np.stack([getattr(episodes, name) for name in TRACES]).astype(np.float32)
        return Played(scores, traces)


def pieces_of(suite: Suite, contestant: Contestant, place: int) -> list[Piece]:
    """All pieces of a contestant in a suite, in the order of their rows."""
    return [
        Piece(place, seed, first, min(suite.piece, suite.rigs - first))
        for seed in contestant.members
        for first in range(0, suite.rigs, suite.piece)
    ]


def file_name(policy: str) -> str:
    """A policy's name as that of a file: as it is where it can be, or else made so, and unlike any other's."""
    plain = re.sub(r"[^A-Za-z0-9_-]", "_", policy)
    return plain if plain == policy else f"{plain}-{hashlib.sha256(policy.encode()).hexdigest()[:6]}"


class Gathered:
    """One contestant's pieces as they come; where there are several, and a `folder`, they are kept there.

    Pieces that an earlier run has left in the folder count; one that is damaged is done again.
    """

    def __init__(self, suite: Suite, contestant: Contestant, place: int, folder: Path | None) -> None:
        self.suite, self.contestant = suite, contestant
        self.pieces = pieces_of(suite, contestant, place)
        self._held: dict[Piece, Played] = {}
        self._folder = None
        if folder is not None and len(self.pieces) > 1:
            self._folder = folder / PIECES / suite.name / file_name(contestant.name)
        self._kept = {piece for piece in self.pieces if self._is_kept(piece)}

    @property
    def open(self) -> list[Piece]:
        """The pieces that are not done."""
        return [piece for piece in self.pieces if piece not in self._held and piece not in self._kept]

    def take(self, piece: Piece, played: Played) -> None:
        """Take what came of a piece."""
        if self._folder is None:
            self._held[piece] = played
            return
        arrays = played.scores if played.traces is None else {**played.scores, _TRACES: played.traces}
        with written_whole(self._path(piece)) as new:
            np.savez(new, **arrays)  # type: ignore[arg-type]  # the stub takes a name for a flag
        self._kept.add(piece)

    def played(self) -> Iterator[Played]:
        """What came of all pieces, one after another in the order of their rows, once all are done."""
        return map(self._of, self.pieces)

    def traces(self, rig: int) -> npt.NDArray[np.float32]:
        """TRACES of a rig by its number, of the first seed; shape (traces, steps)."""
        piece = next(one for one in self.pieces if one.first <= rig < one.first + one.count)
        found = self._of(piece).traces
        assert found is not None
        return found[:, rig - piece.first]

    def forget(self) -> None:
        """Remove the files: what was in them is elsewhere now."""
        if self._folder is not None:
            for piece in self._kept:
                self._path(piece).unlink(missing_ok=True)
            for folder in (self._folder, self._folder.parent, self._folder.parent.parent):
                with suppress(OSError):  # where others are left
                    folder.rmdir()

    def _of(self, piece: Piece) -> Played:
        if piece in self._held:
            return self._held[piece]
        arrays = read_arrays(self._path(piece), "remove it, and --resume does it again")
        traces = arrays.pop(_TRACES, None)
        return Played(arrays, traces)

    def _is_kept(self, piece: Piece) -> bool:
        if self._folder is None or not self._path(piece).is_file():
            return False
        try:
            return len(self._of(piece).scores["seed"]) == piece.count
        except ValueError:
            return False

    def _path(self, piece: Piece) -> Path:
        assert self._folder is not None
        return self._folder / f"{piece.seed or 'only'}_{piece.first}.npz"
