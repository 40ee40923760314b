"""Text files: lines of cells, read in large pieces, and line by line where a piece is not all numbers."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.records.cells import is_comment, number, split
from drillrig_env.calibrate.records.layout import Layout, find_layout
from drillrig_env.calibrate.records.raw import Column, RawTable, Unread

_PIECE, _SMALL = 1 << 22, 1 << 13  # bytes that are read at once, and where that much cannot be
_LOOKED_AT = 400  # lines of which the layout is found
_LINE_FEED = 10


@dataclass
class _Piece:
    """What some lines hold: numbers (rows, columns), text by column, and the number of each line."""

    numbers: FloatArray
    text: dict[int, npt.NDArray[np.bytes_]]
    lines: npt.NDArray[np.int64]


@dataclass
class _Faults:
    """What was not as it should be, line by line: by column its unread cells, and lines that are too short."""

    unread: dict[int, Unread] = field(default_factory=dict)
    short: list[int] = field(default_factory=list)

    def add(self, column: int, row: int, text: str) -> None:
        first = self.unread.get(column, Unread(0, row, text))
        self.unread[column] = Unread(first.count + 1, first.row, first.text)


def read_text(source: str, content: bytes, mapped: Collection[str] = ()) -> RawTable:
    """The table in a text file with this content; `mapped` are names of columns that its user has told.

    Raises `ValueError`, naming the line, where it is no table.
    """
    content, encoding = decoded(content)
    start = content[: 1 << 20].decode(errors="replace").split("\n")
    layout = find_layout(source, start[:_LOOKED_AT], mapped)
    at = 0
    for _ in range(layout.body):
        at = content.index(b"\n", at) + 1
    faults = _Faults()
    pieces, rows, line = [], 0, layout.body + 1
    for large in _pieces(content[at:], _PIECE):
        whole = _read_at_once(large, layout, line)
        for piece in (large,) if whole else _pieces(large, _SMALL):
            read = whole or _read_at_once(piece, layout, line) or _read_lines(source, piece, layout, line, rows, faults)
            rows += len(read.lines)
            line += piece.count(b"\n")
            pieces.append(read)
    table = np.concatenate([piece.numbers for piece in pieces])
    columns = []
    for k, name in enumerate(layout.names):
        values = np.concatenate([piece.text[k] for piece in pieces]) if layout.text[k] else table[:, k]
        columns.append(Column(name, values, layout.units[k], faults.unread.get(k)))
    notes = [f"{encoding} text, {layout}, samples from line {layout.body + 1} on"]
    if faults.short:
        notes.append(f"lines that end too early: {len(faults.short)}, the first is line {faults.short[0]}")
    numbers = np.concatenate([piece.lines for piece in pieces])
    return RawTable(source, columns, "line", numbers, tuple(notes), layout.headerless)


def decoded(content: bytes) -> tuple[bytes, str]:
    """A file's content as UTF-8 with line feeds and one at its end, and the name of the encoding that it had."""
    encoding = "UTF-8"
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        content, encoding = content.decode("utf-16", errors="replace").encode(), "UTF-16"
    elif b"\0" in content[:1000]:
        order = "utf-16-le" if content[1:2] == b"\0" else "utf-16-be"
        content, encoding = content.decode(order, errors="replace").encode(), "UTF-16"
    elif not content.isascii():
        try:
            content.decode()
        except UnicodeDecodeError:
            content, encoding = content.decode("cp1252", errors="replace").encode(), "Windows-1252"
    content = content.removeprefix(b"\xef\xbb\xbf")
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return (content if content.endswith(b"\n") else content + b"\n"), encoding


def _pieces(content: bytes, size: int) -> Iterator[bytes]:
    """Whole lines of the content, about `size` bytes at once."""
    at = 0
    while at < len(content):
        end = content.find(b"\n", min(at + size, len(content) - 1)) + 1
        yield content[at:end]
        at = end


def _read_at_once(piece: bytes, layout: Layout, line: int) -> _Piece | None:
    """A piece in which every line has all its cells, numbers where they should be; None for any other."""
    if layout.decimal == "," and (layout.separator == "," or b"." in piece):
        return None
    codes = np.frombuffer(piece.replace(b'"', b""), np.uint8)
    if layout.separator == " ":
        codes = _parted_by_one_blank(codes)
    separator = ord(layout.separator)
    bounds = np.flatnonzero((codes == separator) | (codes == _LINE_FEED))
    count = layout.count
    if len(bounds) % count:
        return None
    ends = bounds.reshape(-1, count)
    marks = codes[ends]
    if np.any(marks[:, :-1] != separator) or np.any(marks[:, -1] != _LINE_FEED):
        return None
    begins = np.concatenate([[0], bounds[:-1] + 1]).reshape(-1, count)
    codes = codes.copy()
    text = {}
    for k in np.flatnonzero(layout.text):
        widths = ends[:, k] - begins[:, k]
        if np.any(widths != widths[0]) or widths[0] == 0:
            return None
        places = begins[:, k, None] + np.arange(widths[0])
        text[int(k)] = np.ascontiguousarray(codes[places]).view(f"S{widths[0]}").ravel()
        codes[places] = ord("0")
    if layout.decimal == ",":
        codes[codes == ord(",")] = ord(".")
    codes[bounds] = ord(" ")
    if len(empty := bounds[np.diff(bounds, prepend=-1) == 1]):
        codes = np.insert(codes, np.repeat(empty, 3), np.tile(np.frombuffer(b"nan", np.uint8), len(empty)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            numbers = np.fromstring(codes.tobytes(), sep=" ")
        except (ValueError, DeprecationWarning):
            return None
    if numbers.size != ends.size:
        return None
    return _Piece(numbers.reshape(ends.shape), text, np.arange(line, line + len(ends)))


def _parted_by_one_blank(codes: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Lines whose cells are parted by one blank each, and none at their ends."""
    blank = (codes == ord(" ")) | (codes == ord("\t"))
    end = codes == _LINE_FEED
    before = np.concatenate([[True], (blank | end)[:-1]])
    after = np.concatenate([end[1:], [True]])
    kept = ~(blank & (before | after))
    return np.asarray(np.where(blank, np.uint8(ord(" ")), codes)[kept])


def _read_lines(source: str, piece: bytes, layout: Layout, line: int, rows: int, faults: _Faults) -> _Piece:
    """A piece line by line; what is no number is NaN and goes to `faults`."""
    cells_of, lines = [], []
    for position, content in enumerate(piece.decode(errors="replace").split("\n")):
        if not content.strip() or is_comment(content):
            continue
        cells = split(content, layout.separator)
        if tuple(cells) == layout.names:  # some loggers write the header again
            continue
        while len(cells) > layout.count and not cells[-1]:
            cells.pop()
        if len(cells) > layout.count:
            raise ValueError(f"{source}, line {line + position}: {len(cells)} cells; allowed: {layout.count}, as above")
        if len(cells) < layout.count:
            faults.short.append(line + position)
            cells += [""] * (layout.count - len(cells))
        cells_of.append(cells)
        lines.append(line + position)
    numbers = np.full((len(cells_of), layout.count), np.nan)
    text = {
        int(k): np.array([cells[k].encode() for cells in cells_of], dtype=bytes) for k in np.flatnonzero(layout.text)
    }
    for row, cells in enumerate(cells_of):
        for k, cell in enumerate(cells):
            if k not in text:
                value = number(cell, layout.decimal)
                if value is None:
                    faults.add(k, rows + row, cell)
                else:
                    numbers[row, k] = value
    return _Piece(numbers, text, np.array(lines, dtype=np.int64))
