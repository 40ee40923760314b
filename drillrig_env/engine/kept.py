"""Pieces of work whose results, arrays by name, are kept in a folder as they come, to go on from after any stop."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from drillrig_env.engine.contract import Engine
from drillrig_env.files import json_text, owned, read_arrays, read_json, write_text, written_whole

P = TypeVar("P")
Arrays = Mapping[str, npt.NDArray[Any]]

_OF = "work.json"
_REMEDY = "remove it, and it is done again"


def each_kept(
    engine: Engine, work: Callable[[P], Arrays], pieces: Sequence[P], folder: Path | None, of: str
) -> Iterator[tuple[int, Arrays]]:
    """The number of each piece and its arrays: first those that the folder has, then the others as they are done.

    Without a `folder` nothing is kept. `of` says what all of the work is: a folder of other work is refused with a
    `ValueError`. A file that is damaged counts as not there.
    """
    if folder is None:
        yield from engine.each(work, pieces)
        return
    with owned(folder):
        definition = {"work": hashlib.sha256(of.encode()).hexdigest(), "pieces": len(pieces)}
        if (folder / _OF).exists() and read_json(folder / _OF, _REMEDY) != definition:
            raise ValueError(f"{folder} holds pieces of other work; remove it, or name another folder")
        write_text(folder / _OF, json_text(definition))
        open_ones = []
        for number in range(len(pieces)):
            if (found := _read(folder, number)) is None:
                open_ones.append(number)
            else:
                yield number, found
        for k, arrays in engine.each(work, [pieces[number] for number in open_ones]):
            with written_whole(_path(folder, open_ones[k])) as new:
                np.savez(new, **arrays)  # type: ignore[arg-type]  # the stub takes a name for a flag
            yield open_ones[k], arrays


def _path(folder: Path, number: int) -> Path:
    return folder / f"piece_{number}.npz"


def _read(folder: Path, number: int) -> Arrays | None:
    if not _path(folder, number).is_file():
        return None
    try:
        return read_arrays(_path(folder, number), _REMEDY)
    except ValueError:
        return None
