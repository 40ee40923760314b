"""How a text file is laid out: its separator, decimal mark, header and units, found from its first lines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

from drillrig_env.calibrate.records.cells import MISSING, is_comment, number, split, uncommented
from drillrig_env.calibrate.records.quantities import guess, is_unit
from drillrig_env.calibrate.records.stamps import is_stamp

_SEPARATORS = ("\t", ";", "|", ",", " ")
_NAMED = {"\t": "tabs", ";": "semicolons", "|": "bars", ",": "commas", " ": "blanks"}
_HALF = 0.5
_SHARE = 0.8  # of the cells of a column that are values, or there is something wrong with more than some cells
_SAMPLE = 100  # lines


@dataclass(frozen=True)
class Layout:
    """How the lines of a text file are to be read."""

    separator: str
    decimal: str
    names: tuple[str, ...]  # "" each where there is no header
    units: tuple[str, ...]  # "" where none is written in a row of its own
    body: int  # the first line with samples, counted from 0
    text: tuple[bool, ...]  # which columns hold clock times or other text
    headerless: bool

    @property
    def count(self) -> int:
        """The number of columns."""
        return len(self.names)

    def __str__(self) -> str:
        comma = ", decimal comma" if self.decimal == "," else ""
        units = ", units in a row of their own" if any(self.units) else ""
        return f"parted by {_NAMED[self.separator]}{comma}{units}"


def find_layout(source: str, lines: Sequence[str], mapped: Collection[str] = ()) -> Layout:
    """The layout of a file that begins with these lines; `mapped` are names of columns that its user has told.

    Raises `ValueError`, naming the line, where there are no samples, or where the header does not fit them.
    """
    used = [(i, line) for i, line in enumerate(lines) if line.strip() and not is_comment(line)]
    sample = [line for _, line in used[len(used) // 2 :][-_SAMPLE:]]
    separator, decimal, count = _parting(source, sample)
    table = [cells for line in sample if len(cells := split(line, separator)) == count]
    values = [_share(lambda cell: _is_value(cell, decimal), [row[k] for row in table]) >= _SHARE for k in range(count)]
    text = [_share(lambda cell: number(cell, decimal) is None, [row[k] for row in table]) > _HALF for k in range(count)]

    def numbers_of(line: str) -> list[bool]:
        """Which cells are values, of those in columns of values that hold something; none in a short line."""
        cells = [cell for cell, is_value in zip(split(line, separator), values, strict=False) if is_value]
        return [_is_value(c, decimal) for c in cells if not _is_missing(c)] if len(cells) >= sum(values) else []

    body = next((i for i, line in used if (found := numbers_of(line)) and all(found)), None)
    if body is None:
        raise ValueError(f"{source}: no line of numbers; allowed: a header, then a line of numbers for each time")
    empty = [all(_is_missing(row[k]) for row in table) for k in range(count)]
    head = {i: _head_cells(lines[i], separator, count, empty) for i in range(body) if lines[i].strip()}
    header = _find_header({i: cells for i, cells in head.items() if len(cells) == count}, mapped)
    if header is None:
        if above := [i for i in head if not is_comment(lines[i])]:
            raise _unlike(source, body, count, above[-1], len(head[above[-1]]), separator)
        blank = ("",) * count
        return Layout(separator, decimal, blank, blank, body, tuple(text), headerless=True)
    last, names, units = header
    body = next(i for i, line in used if i > last and any(numbers_of(line)))  # it may hold a cell that is no number
    return Layout(separator, decimal, names, units, body, tuple(text), headerless=False)


def _unlike(source: str, body: int, count: int, above: int, names: int, separator: str) -> ValueError:
    """The error for a header that has not as many cells as the samples have."""
    both = "; is the comma both separator and decimal mark? part the cells by something else"
    return ValueError(
        f"{source}, line {body + 1}: {count} cells, and {names} names in line {above + 1}; "
        f"allowed: as many cells as names{both if separator == ',' else ''}"
    )


def _parting(source: str, sample: Sequence[str]) -> tuple[str, str, int]:
    """Separator, decimal mark and number of columns that make the most of some lines numbers and clock times."""
    best, found = 0.0, ("", "", 0)
    for separator in _SEPARATORS:
        rows = [split(line, separator) for line in sample]
        if not rows:
            break
        count, lines = Counter(map(len, rows)).most_common(1)[0]
        cells = [cell for row in rows if len(row) == count for cell in row]
        for decimal in (".", ","):
            quality = lines / len(rows) * sum(_is_value(cell, decimal) for cell in cells) / max(len(cells), 1)
            if count >= 2 and quality > best:
                best, found = quality, (separator, decimal, count)
    if not best:
        raise ValueError(
            f"{source}: no columns of numbers; allowed: a header, then a line for each time, its numbers parted by "
            "commas, semicolons, tabs, bars or blanks"
        )
    return found


def _head_cells(line: str, separator: str, count: int, empty: Sequence[bool]) -> list[str]:
    """The cells of a line above the samples; columns at the end that hold nothing need no name."""
    cells = split(uncommented(line) if is_comment(line) else line, separator)
    if is_comment(line) and len(cells) != count:
        cells = next((parted for mark in _SEPARATORS if len(parted := split(uncommented(line), mark)) == count), cells)
    while len(cells) > count and cells[-1] in ("", "Comment"):  # LabVIEW has a name for comments that are not there
        cells.pop()
    while len(cells) < count and all(empty[len(cells) :]):
        cells.append("")
    return cells


def _find_header(
    rows: Mapping[int, list[str]], mapped: Collection[str]
) -> tuple[int, tuple[str, ...], tuple[str, ...]] | None:
    """The last line of the header, its names and its units ("" where there are none); None without a header.

    The names are the row of which most is known and not half is units, the units the next one with a unit in it.
    """
    of_units = [i for i, row in rows.items() if _share(is_unit, [c for c in row if not _is_missing(c)]) >= _HALF]
    candidates = [i for i in rows if i not in of_units] or of_units
    if not candidates:
        return None
    named = max(candidates, key=lambda i: sum(cell in mapped or guess(cell) is not None for cell in rows[i]))
    below = next((i for i in rows if i > named and any(map(is_unit, rows[i]))), named)
    units = rows[below] if below != named else []
    plain = tuple("" if _is_missing(cell) else cell.strip("[](){}<>") for cell in units) or ("",) * len(rows[named])
    return max(named, below), tuple(rows[named]), plain


def _is_missing(cell: str) -> bool:
    return cell.lower() in MISSING


def _is_value(cell: str, decimal: str) -> bool:
    return number(cell, decimal) is not None or is_stamp(cell)


def _share(holds: Callable[[str], bool], cells: Sequence[str]) -> float:
    return sum(map(holds, cells)) / len(cells) if cells else 0.0
