"""Records of documented fields from and to TOML; or from whatever users give: an object, changes, a file."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import Field, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from drillrig_env.files import write_text
from drillrig_env.parameters import checked, closest, default_of, refuse

T = TypeVar("T")

_BASE, _CHAPTER = "base", "chapter"
_OF_A_CALIBRATION = ("rig", "friction")
"""Tables that a calibration writes into its folder, as rig.toml and friction.toml."""


def record_of(record: type[T], section: str, value: Any) -> T:
    """A record from what a user gives for it.

    None is the default record; a record stands for itself; a dictionary holds changes to the default; a path leads to
    a TOML file with the table `[section]`, of a rig or a friction also to a calibration's folder. Raises `ValueError`
    that names what is not allowed (the closest known name for an unknown key) and `FileNotFoundError` where there is no
    such file.
    """
    if value is None:
        return record()
    if isinstance(value, record):
        return value
    if isinstance(value, Mapping):
        return _with_changes(record, section, value)
    if isinstance(value, str | Path):
        in_folder = section in _OF_A_CALIBRATION and value != "" and Path(value).is_dir()  # "" is the working folder
        return read_section(Path(value) / f"{section}.toml" if in_folder else value, section, record)
    name = record.__name__
    allowed = f"a {name}, a dictionary of changes to {name}(), or the path of a TOML file with the table [{section}]"
    raise refuse(section, section, repr(value), "", allowed)


def write_section(instance: Any, path: str | Path, section: str) -> None:
    """Write a record of plain numbers as the only table, `[section]`, of a TOML file."""
    write_text(path, section_text(instance, section))


def section_text(instance: Any, section: str) -> str:
    """A record of numbers and names as the text of a TOML table: a line a field, with meaning, unit and source."""
    lines = [f"[{section}]"]
    for item in fields(instance):
        meta = item.metadata
        unit = f" [{meta['unit']}]" if meta["unit"] else ""
        value = getattr(instance, item.name)
        shown = repr(float(value)) if np.asarray(value).dtype.kind in "iuf" else json.dumps(str(value))
        lines.append(f"{item.name} = {shown}  # {meta['meaning']}{unit} ({meta['source']})")
    return "\n".join(lines) + "\n"


def read_section(path: str | Path, section: str, record: type[T]) -> T:
    """Read `[section]` of a TOML file as a record.

    Every key must be there (but for optional ones) and no other, since a forgotten one would silently be the chapter's;
    a table that says `base = "chapter"` holds changes to the chapter's values. Raises `ValueError` that names the file
    and the key, the value, its unit and what is allowed; `FileNotFoundError` where there is no such file.
    """
    try:
        tables = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise FileNotFoundError(f"{section}: there is no file {path}") from error
    except OSError as error:
        raise ValueError(f"{section}: {str(path)!r} is no file that can be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: not a TOML file: {error}") from error
    if section not in tables:
        raise ValueError(f"{path}: the table [{section}] is missing; tables found: {sorted(tables) or 'none'}")
    if not isinstance(tables[section], dict):
        raise ValueError(f"{path}: [{section}] must be a table of keys, not {tables[section]!r}")
    values, where = dict(tables[section]), f"{path}: [{section}]"
    base = values.pop(_BASE, None)
    if base not in (None, _CHAPTER):
        raise ValueError(f'{where}: {_BASE} = {base!r} is not known; allowed: {_BASE} = "{_CHAPTER}", or every key')
    read = _with_changes(record, where, values)
    for item in fields(record):  # type: ignore[arg-type]
        if item.name not in values and base is None and not item.metadata["optional"]:
            raise ValueError(
                f"{where}: the key {item.name} is missing: {_expected(item)}; "
                f'with {_BASE} = "{_CHAPTER}" in the table, keys that are missing are the chapter\'s'
            )
    return read


def _with_changes(record: type[T], where: str, changes: Mapping[Any, Any]) -> T:
    """The default record with some of its fields changed."""
    known = {item.name: item for item in fields(record)}  # type: ignore[arg-type]
    for key, value in changes.items():
        if key not in known:
            raise ValueError(f"{where}: unknown key {key} = {value!r}; {closest(key, known)}")
        meta = known[key].metadata
        if value is None and meta["none"]:
            continue
        checked(where, key, value, meta["unit"], meta["allowed"])
    try:
        return record(**changes)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error


def _expected(item: Field[Any]) -> str:
    meta = item.metadata
    unit = f" {meta['unit']}" if meta["unit"] else ""
    return f"{meta['meaning']}, {meta['allowed']}{unit}; the default is {default_of(item)}"
