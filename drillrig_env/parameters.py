"""Parameters that know their unit, their source and what is allowed; read from and written to TOML."""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import MISSING, Field, dataclass, field, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


@dataclass(frozen=True)
class Allowed:
    """An interval: the values that a parameter may take. An open end excludes the bound itself."""

    low: float = -np.inf
    high: float = np.inf
    low_open: bool = False
    high_open: bool = False

    def holds(self, value: float | np.ndarray) -> bool:
        """Whether every entry of `value` is a finite number inside the interval."""
        x = np.asarray(value, dtype=float)
        above = x > self.low if self.low_open else x >= self.low
        below = x < self.high if self.high_open else x <= self.high
        return bool(np.all(np.isfinite(x) & above & below))

    def __str__(self) -> str:
        low = f"{'>' if self.low_open else '>='} {self.low:g}" if np.isfinite(self.low) else ""
        high = f"{'<' if self.high_open else '<='} {self.high:g}" if np.isfinite(self.high) else ""
        return " and ".join(part for part in (low, high) if part) or "any finite number"


POSITIVE = Allowed(low=0.0, low_open=True)
NOT_NEGATIVE = Allowed(low=0.0)


def parameter(default: Any, unit: str, meaning: str, source: str, allowed: Allowed) -> Any:
    """A dataclass field for a physical parameter: its unit, meaning, source and allowed values."""
    metadata = {"unit": unit, "meaning": meaning, "source": source, "allowed": allowed}
    return field(default=default, metadata=metadata)


def refuse(where: str, name: str, value: object, unit: str, allowed: object) -> ValueError:
    """The error for an impossible value: names the thing, the value, its unit and what is allowed."""
    unit = f" {unit}" if unit else ""
    return ValueError(f"{where}: {name} = {value}{unit} is not allowed; allowed: {allowed}{unit}")


def check_fields(instance: Any, where: str | None = None) -> None:
    """Raise `ValueError` for the first field of a parameter dataclass that is not allowed.

    `where` names the origin of the values in the message; default the class name.
    """
    for item in fields(instance):
        value, meta = getattr(instance, item.name), item.metadata
        if not _is_numeric(value) or not meta["allowed"].holds(value):
            raise refuse(where or type(instance).__name__, item.name, value, meta["unit"], meta["allowed"])


def describe(instance: Any) -> str:
    """A table of a parameter dataclass: name, value, unit, meaning and source, a line each."""
    rows = [
        (item.name, f"{getattr(instance, item.name)}", *(item.metadata[key] for key in ("unit", "meaning", "source")))
        for item in fields(instance)
    ]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    return "\n".join(
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )


def write_section(instance: Any, path: str | Path, section: str) -> None:
    """Write a parameter dataclass of plain numbers as the only table, `[section]`, of a TOML file."""
    lines = [f"[{section}]"]
    for item in fields(instance):
        meta = item.metadata
        unit = f" [{meta['unit']}]" if meta["unit"] else ""
        lines.append(
            f"{item.name} = {float(getattr(instance, item.name))!r}  # {meta['meaning']}{unit} ({meta['source']})"
        )
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def read_section(path: str | Path, section: str, of: type[T]) -> T:
    """Read `[section]` of a TOML file as an instance of the parameter dataclass `of`.

    Every key must be there and no other. Raises `ValueError` that names the file and the key,
    the value, its unit and what is allowed; `FileNotFoundError` where there is no such file.
    """
    try:
        tables = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path}: not a TOML file: {error}") from error
    if section not in tables:
        raise ValueError(f"{path}: the table [{section}] is missing; tables found: {sorted(tables) or 'none'}")
    values, known = tables[section], {item.name: item for item in fields(of)}  # type: ignore[arg-type]
    if not isinstance(values, dict):
        raise ValueError(f"{path}: [{section}] must be a table of keys, not {values!r}")
    where = f"{path}: [{section}]"
    for key in values:
        if key not in known:
            raise ValueError(f"{where}: unknown key {key} = {values[key]}; {closest(key, known)}")
    for name, item in known.items():
        if name not in values:
            raise ValueError(f"{where}: the key {name} is missing: {_expected(item)}")
        if not _is_numeric(values[name]):
            raise ValueError(f"{where}: {name} = {values[name]!r} is not a number; expected {_expected(item)}")
        if not item.metadata["allowed"].holds(values[name]):
            raise refuse(where, name, values[name], item.metadata["unit"], item.metadata["allowed"])
    try:
        return of(**{name: float(value) for name, value in values.items()})
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def closest(name: str, known: Any) -> str:
    """A hint for an unknown name: the closest known one if there is one, and all that are allowed."""
    match = difflib.get_close_matches(str(name), [str(key) for key in known], n=1)
    hint = f"did you mean {match[0]}? " if match else ""
    return f"{hint}allowed: {', '.join(str(key) for key in known)}"


def _is_numeric(value: object) -> bool:
    if isinstance(value, bool | np.bool_):
        return False
    return isinstance(value, int | float) or (
        isinstance(value, np.ndarray | np.number) and np.issubdtype(value.dtype, np.number)
    )


def _expected(item: Field[Any]) -> str:
    meta = item.metadata
    default = "" if item.default is MISSING else f"; the default rig has {item.default}"
    unit = f" {meta['unit']}" if meta["unit"] else ""
    return f"{meta['meaning']}, {meta['allowed']}{unit}{default}"
