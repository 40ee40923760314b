"""Cells of a text file: where a line is parted, and what a cell says."""

from __future__ import annotations

import csv
import re

MISSING = frozenset({"", "na", "n/a", "nan", "-nan", "#n/a", "null", "none", "-", "--", "missing", "1.#qnan"})
"""What a cell without a value holds, in small letters."""

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[+-]?inf(inity)?", re.IGNORECASE)
_COMMENT = re.compile(r'\s*"?(#|%|//|!)\s*')


def is_comment(line: str) -> bool:
    """Whether a line is a comment: it begins with #, %, // or !."""
    return _COMMENT.match(line) is not None


def uncommented(line: str) -> str:
    """What a comment says."""
    return _COMMENT.sub("", line, count=1)


def split(line: str, separator: str) -> list[str]:
    """The cells of a line, without blanks and quotes around them; a separator within quotes parts nothing.

    The separator " " stands for any number of blanks and tabs.

    >>> split('0.5;"1,5"; 2', ";")
    ['0.5', '1,5', '2']
    """
    if separator == " ":
        cells = line.split()
    elif '"' in line:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    else:
        cells = line.split(separator)
    return [cell.strip().strip('"').strip() for cell in cells]


def number(cell: str, decimal: str = ".") -> float | None:
    """The number that a cell holds, NaN for one that is missing; None where it is neither.

    >>> number("1,5", ","), number("1_000"), number("N/A")
    (1.5, None, nan)
    """
    if decimal == "," and "." not in cell:
        cell = cell.replace(",", ".", 1)
    elif decimal == ",":
        return None
    if _NUMBER.fullmatch(cell):
        return float(cell.lower().replace("d", "e"))
    if cell.lower() in MISSING:
        return float("nan")
    return float(cell) if _NOT_FINITE.fullmatch(cell) else None
