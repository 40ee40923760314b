"""What a documented field may hold: numbers in an interval, pairs of them, choices, switches, paths, records.

Each kind reads a value (`read`), or the text of a command line (`parse`), as a record keeps it, and says in
words what is allowed (`str`). A `ValueError` without words leaves the sentence to `drillrig_env.parameters`, which
knows the field's name and unit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np


class Kind(Protocol):
    """What every kind of value offers."""

    def read(self, value: Any) -> Any:
        """The value as a record keeps it. `ValueError` where it is not allowed."""

    def parse(self, text: str) -> Any:
        """The same from a word of a command line."""


@dataclass(frozen=True)
class Allowed:
    """A number in an interval. An open end excludes the bound itself; `whole` numbers are read as `int`."""

    low: float = -np.inf
    high: float = np.inf
    low_open: bool = False
    high_open: bool = False
    whole: bool = False

    def holds(self, value: object) -> bool:
        """Whether `value`, a number or an array of numbers, is finite and inside the interval, every entry of it.

        Text, truth values and complex numbers are no numbers here.
        """
        try:
            x = np.asarray(float(value) if type(value) is int else value)  # NumPy's integers end at 2^64
        except (ValueError, OverflowError):  # lists of unequal lengths, and what no float can hold
            return False
        if x.dtype.kind not in "iuf" or (self.whole and np.any(x != np.round(x))):
            return False
        above = x > self.low if self.low_open else x >= self.low
        below = x < self.high if self.high_open else x <= self.high
        return bool(np.all(np.isfinite(x) & above & below))

    def read(self, value: Any) -> float | int:
        """The number, as `float`, or `int` where it must be whole."""
        if np.ndim(value) != 0 or not self.holds(value):
            raise ValueError
        return int(value) if self.whole else float(value)

    def parse(self, text: str) -> float | int:
        """The number in a text; 2e6 is a whole one too."""
        return self.read(float(text))

    def __str__(self) -> str:
        exactly = ".0f" if self.whole else "g"
        low = f"{'>' if self.low_open else '>='} {self.low:{exactly}}" if np.isfinite(self.low) else ""
        high = f"{'<' if self.high_open else '<='} {self.high:{exactly}}" if np.isfinite(self.high) else ""
        words = " and ".join(part for part in (low, high) if part)
        if self.whole:
            return f"whole, {words}" if words else "any whole number"
        return words or "any finite number"


POSITIVE = Allowed(low=0.0, low_open=True)
NOT_NEGATIVE = Allowed(low=0.0)
SHARE = Allowed(0.0, 1.0)
COUNT = Allowed(low=1, whole=True)


@dataclass(frozen=True)
class OneARig:
    """A number, or an array with one entry a rig; each within `allowed`."""

    allowed: Allowed

    def read(self, value: Any) -> Any:
        """The number or array as it is; a list or tuple becomes an array."""
        if not self.allowed.holds(value):
            raise ValueError
        return np.asarray(value, dtype=float) if isinstance(value, Sequence) else value

    def parse(self, text: str) -> float:
        """One number for every rig."""
        return self.allowed.parse(text)

    def __str__(self) -> str:
        return str(self.allowed)


@dataclass(frozen=True)
class Span:
    """A pair (low, high) with low <= high, each within `allowed`; on a command line `low:high`."""

    allowed: Allowed

    def read(self, value: Any) -> tuple[float, float]:
        """The pair as a tuple."""
        if isinstance(value, str) or np.shape(value) != (2,):
            raise ValueError
        low, high = (self.allowed.read(bound) for bound in value)
        if low > high:
            raise ValueError
        return low, high

    def parse(self, text: str) -> tuple[float, float]:
        """The pair in a text such as 1:5."""
        low, _, high = text.partition(":")
        return self.read((float(low), float(high or low)))

    def __str__(self) -> str:
        return f"(low, high) with low <= high, each {self.allowed}"


@dataclass(frozen=True)
class Choice:
    """One of some names."""

    names: tuple[str, ...]

    def read(self, value: Any) -> str:
        """The name."""
        if not isinstance(value, str) or value not in self.names:
            raise ValueError
        return str(value)

    def parse(self, text: str) -> str:
        """The name."""
        return self.read(text)

    def __str__(self) -> str:
        return " or ".join(repr(name) for name in self.names)


@dataclass(frozen=True)
class Switch:
    """True or False."""

    def read(self, value: Any) -> bool:
        """The truth value; numbers and text are none."""
        if not isinstance(value, bool | np.bool_):
            raise ValueError
        return bool(value)

    def parse(self, text: str) -> bool:
        """The truth value in "true", "false", "yes", "no", "on" or "off"."""
        words = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
        if text.lower() not in words:
            raise ValueError
        return words[text.lower()]

    def __str__(self) -> str:
        return "True or False"


@dataclass(frozen=True)
class Text:
    """A text that is not empty; `what` says in words what it names."""

    what: str = "a text"

    def read(self, value: Any) -> str:
        """The text."""
        if not isinstance(value, str) or not value:
            raise ValueError
        return str(value)

    def parse(self, text: str) -> str:
        """The text."""
        return self.read(text)

    def __str__(self) -> str:
        return self.what


@dataclass(frozen=True)
class File:
    """A path to a file or folder; `what` says in words which."""

    what: str = "a path"

    def read(self, value: Any) -> Path:
        """The path."""
        if not isinstance(value, str | Path) or not str(value):
            raise ValueError
        return Path(value)

    def parse(self, text: str) -> Path:
        """The path."""
        return self.read(text)

    def __str__(self) -> str:
        return self.what


@dataclass(frozen=True)
class Made:
    """Anything that a function makes of what is given, such as a record of a dictionary; `what` says what it takes.

    `by` raises `ValueError` for what it does not take, with a sentence of its own.
    """

    by: Callable[[Any], Any]
    what: str

    def read(self, value: Any) -> Any:
        """What `by` makes of the value."""
        return self.by(value)

    def parse(self, text: str) -> Any:
        """What `by` makes of the text."""
        return self.by(text)

    def __str__(self) -> str:
        return self.what
