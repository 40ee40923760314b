"""What a file holds before anything is made of it: named columns of numbers, dates or text, and where each stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[Any]
"""A column: floats (NaN where a cell holds none), `datetime64`, or text as bytes of UTF-8."""


@dataclass(frozen=True)
class Unread:
    """Cells of a column that are neither numbers nor empty: how many, and the first of them."""

    count: int
    row: int
    text: str


@dataclass(frozen=True, eq=False)
class Column:
    """A column of a file: its name, the unit where that stands apart from the name, and its values, shape (n,)."""

    name: str
    values: Values
    unit: str = ""
    unread: Unread | None = None

    @property
    def is_text(self) -> bool:
        """Whether its cells are text, such as clock times or messages."""
        return self.values.dtype.kind == "S"


@dataclass(frozen=True, eq=False)
class RawTable:
    """The columns of a file, all of one length, and notes on how it was read."""

    source: str
    columns: Sequence[Column]
    rows: str = "row"  # what a sample is in the file: a line, a row
    numbers: npt.NDArray[np.int64] | None = None  # those of the samples in the file, where they do not count from 1
    notes: tuple[str, ...] = field(default=())
    headerless: bool = False

    def place(self, row: int) -> str:
        """File and line of a sample, counted from 0, for a message."""
        number = row + 1 if self.numbers is None else int(self.numbers[row])
        return f"{self.source}, {self.rows} {number}"


def column(name: str, values: Any, unit: str = "") -> Column:
    """A column of what a library read: numbers as floats, dates as `datetime64`, and all else as text."""
    array = np.asarray(values)
    if array.dtype.kind in "iufb":
        array = array.astype(float)
    elif array.dtype.kind != "M":
        array = np.array([str(value).encode() for value in array], dtype=bytes)
    return Column(str(name), array, unit)


def of_one_length(source: str, columns: Sequence[Column]) -> tuple[list[Column], str]:
    """Those columns that are as long as most are, and a note on the others, "" where there are none.

    Raises `ValueError` where there is no column at all.
    """
    if not columns:
        raise ValueError(
            f"{source}: holds no vectors of numbers; allowed: one of times and one of each signal, by name"
        )
    lengths = [len(one.values) for one in columns]
    usual = max(set(lengths), key=lambda length: (lengths.count(length), length))
    others = [one.name for one in columns if len(one.values) != usual]
    note = f"left out, not of {usual} samples as the others are: {', '.join(others)}" if others else ""
    return [one for one in columns if len(one.values) == usual], note
