"""Documented fields: parameters that know their meaning, their unit, their source and what is allowed.

A record of them is a frozen dataclass whose fields are made by `parameter(...)` and whose `__post_init__` calls
`check_fields`. Its error messages, its TOML files (`drillrig_env.toml`), its flags on the command line
(`drillrig_env.flags`) and its table in the documentation (`field_rows`) all come from there.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable
from dataclasses import MISSING, Field, field, fields
from typing import Any

import numpy as np

from drillrig_env.allowed import COUNT, NOT_NEGATIVE, POSITIVE, SHARE, Allowed, Kind, OneARig, Span

__all__ = [
    "COUNT",
    "NOT_NEGATIVE",
    "POSITIVE",
    "SHARE",
    "Allowed",
    "check_fields",
    "checked",
    "closest",
    "default_of",
    "describe",
    "differing",
    "field_rows",
    "parameter",
    "refuse",
]

_NUMERIC = (Allowed, OneARig, Span)  # kinds that hold nothing but numbers


def parameter(
    default: Any = MISSING,
    unit: str = "",
    meaning: str = "",
    source: str = "",
    allowed: Kind | None = None,
    *,
    factory: Callable[[], Any] | None = None,
    none: str = "",
    optional: bool = False,
) -> Any:
    """A dataclass field that is documented: its default, unit, meaning, source and what is allowed.

    `allowed` is a kind of `drillrig_env.allowed` (default: any finite number). `factory` makes the default anew for
    every record. Where None is allowed, `none` says in words what it stands for, such as "as normal_force". A file
    may leave out what is `optional`.
    """
    metadata = {
        "unit": unit,
        "meaning": meaning,
        "source": source,
        "allowed": allowed or Allowed(),
        "none": none,
        "optional": optional,
    }
    if factory is not None:
        return field(default_factory=factory, metadata=metadata)
    return field(default=default, metadata=metadata)


def refuse(where: str, name: str, value: object, unit: str, allowed: object) -> ValueError:
    """The error for an impossible value: names the thing, the value, its unit and what is allowed."""
    unit = f" {unit}" if unit else ""
    if isinstance(allowed, _NUMERIC) and not _is_numeric(value):
        fault = f"is text; write {value}, without quotes" if _reads_as_number(value) else "is not a number"
        return ValueError(f"{where}: {name} = {value!r} {fault}; allowed: {allowed}{unit}")
    return ValueError(f"{where}: {name} = {value}{unit} is not allowed; allowed: {allowed}{unit}")


def checked(where: str, name: str, value: Any, unit: str, allowed: Kind) -> Any:
    """The value as `allowed` reads it. Raises the `ValueError` of `refuse` where it is not allowed."""
    try:
        return allowed.read(value)
    except (ValueError, TypeError, OverflowError) as error:
        if str(error) and isinstance(error, ValueError) and not isinstance(allowed, _NUMERIC):
            raise ValueError(_within(where, name, str(error))) from error
        text = isinstance(value, str) and not isinstance(allowed, _NUMERIC)
        raise refuse(where, name, repr(value) if text else value, unit, allowed) from error


def _within(where: str, name: str, sentence: str) -> str:
    """A sentence about what is in a field, with where that is, each said once."""
    if sentence.startswith(f"{where}: {name} "):
        return sentence
    return f"{where}: {sentence}" if sentence.startswith(f"{name}: ") else f"{where}: {name}: {sentence}"


def check_fields(instance: Any, where: str | None = None) -> None:
    """Read every field of a record as its kind has it; `ValueError` for the first that is not allowed.

    `where` names the origin of the values in the message; default the class name.
    """
    for item in fields(instance):
        value, meta = getattr(instance, item.name), item.metadata
        if value is None and meta["none"]:
            continue
        where = where or type(instance).__name__
        object.__setattr__(instance, item.name, checked(where, item.name, value, meta["unit"], meta["allowed"]))


def describe(instance: Any) -> str:
    """A table of a record: name, value, unit, meaning and source, a line each."""
    rows = [
        (item.name, f"{getattr(instance, item.name)}", *(item.metadata[key] for key in ("unit", "meaning", "source")))
        for item in fields(instance)
    ]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    return "\n".join(
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )


def differing(one: Any, other: Any) -> list[str]:
    """What two records of one kind differ in, a text for each such field: its name, both values and the unit."""
    found = []
    for item in fields(one):
        value, instead = getattr(one, item.name), getattr(other, item.name)
        if value != instead:
            found.append(f"{item.name} = {value} and not {instead} {item.metadata['unit']}".rstrip())
    return found


def field_rows(record: type) -> list[tuple[str, str, str, str, str]]:
    """A row for every field of a record: name, default, unit, what is allowed, and meaning, for a table of a page."""
    rows = []
    for item in fields(record):
        meta = item.metadata
        default = default_of(item)
        shown = meta["none"] if default is None else "" if default is MISSING else str(default)
        rows.append((item.name, shown, meta["unit"], str(meta["allowed"]), meta["meaning"]))
    return rows


def default_of(item: Field[Any]) -> Any:
    """The default of a field; `MISSING` where it has none."""
    return item.default_factory() if item.default_factory is not MISSING else item.default


def closest(name: str, known: Iterable[object]) -> str:
    """A hint for an unknown name: the closest known one if there is one, and all that are allowed."""
    names = [str(key) for key in known]
    match = difflib.get_close_matches(str(name), names, n=1)
    hint = f"did you mean {match[0]}? " if match else ""
    return f"{hint}allowed: {', '.join(names)}"


def _is_numeric(value: object) -> bool:
    try:
        return type(value) is int or np.asarray(value).dtype.kind in "iuf"
    except ValueError:
        return False


def _reads_as_number(value: object) -> bool:
    try:
        return isinstance(value, str) and bool(np.isfinite(float(value)))
    except ValueError:
        return False
