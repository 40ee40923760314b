"""Which column of a file is what, in which unit: as its user tells, else by names and units where these are plain."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drillrig_env.calibrate.records.quantities import (
    LEFT_OUT,
    QUANTITIES,
    UNITS,
    bracketed,
    guess,
    read_target,
    unit_of,
    units_allowed,
)
from drillrig_env.calibrate.records.raw import Column, RawTable
from drillrig_env.calibrate.records.stamps import is_stamp
from drillrig_env.parameters import closest


@dataclass(frozen=True, eq=False)
class Reading:
    """A column that is read: as which quantity, in which unit, and whether its user has said so."""

    column: Column
    quantity: str
    unit: str  # one of `UNITS`, or "" for time stamps, and for times whose unit goes unsaid
    stated: bool  # whether the unit is written in the file or told
    told: bool  # whether the user has told the unit

    def __str__(self) -> str:
        unit = f" in {self.unit}" if self.unit else ""
        how = "as told" if self.told else "" if self.stated or not unit else "as no unit is written"
        return f"{self.column.name} is {self.quantity}{unit}" + (f", {how}" if how else "")


def parse_map(words: Sequence[str]) -> dict[str, str]:
    """The mapping of columns in words such as `Bit_Speed=bit_speed:rpm`, as `read_record` takes it.

    Raises `ValueError` for a word that is none, and for what `bit_speed:rpm` may not be.

    >>> parse_map(["RPM surf=top_speed:rpm", "WOB=normal_force:kN"])
    {'RPM surf': 'top_speed:rpm', 'WOB': 'normal_force:kN'}
    """
    mapping = {}
    for word in words:
        name, equals, target = word.rpartition("=")
        if not equals or not name.strip():
            raise ValueError(f"{word!r} is not allowed; allowed: COLUMN=QUANTITY:UNIT, such as Bit_Speed=bit_speed:rpm")
        read_target(target)
        mapping[name.strip()] = target
    return mapping


def find_columns(table: RawTable, mapping: Mapping[str, str]) -> tuple[dict[str, Reading], list[str]]:
    """The columns to read, by quantity, and the names of those that are left out.

    `mapping` says of columns, by name or as "#2" by position, what they are, such as "bit_speed:rpm". Raises
    `ValueError` for what it cannot mean, for a quantity that two columns claim, and for a unit that does not fit.
    """
    told = {_position(table, name): target for name, target in mapping.items()}
    if table.headerless and not told:
        raise ValueError(
            f"{table.place(0)}: the header is missing; write one, or tell the columns by position: "
            '--map "#1=time:s" "#2=bit_speed:rpm"'
        )
    readings: dict[str, Reading] = {}
    left_out: dict[int, str] = {}
    for position, column in enumerate(table.columns):
        target = told.get(position)
        reading = _as_guessed(table, column) if target is None else _as_told(table, column, target)
        if reading is None or (target is None and _is_told(reading.quantity, told.values())):
            if column.name or not _is_empty(column):
                left_out[position] = column.name or f"#{position + 1}"
        elif reading.quantity in readings:
            other = readings[reading.quantity].column.name
            raise ValueError(
                f"{table.source}: the columns {other!r} and {column.name!r} are both {reading.quantity}; "
                f'say which is not to be read: --map "{column.name}={LEFT_OUT}"'
            )
        else:
            readings[reading.quantity] = reading
    stamped = [position for position in left_out if position not in told and _holds_times(table.columns[position])]
    if "time" not in readings and len(stamped) == 1:  # whatever it is called
        readings["time"] = Reading(table.columns[stamped[0]], "time", "", stated=False, told=False)
        del left_out[stamped[0]]
    return readings, list(left_out.values())


def _holds_times(column: Column) -> bool:
    return column.values.dtype.kind == "M" or (column.is_text and is_stamp(column.values[0].decode(errors="replace")))


def _position(table: RawTable, name: str) -> int:
    """Where the column is that a user names: exactly, or but for capitals and blanks, or by "#" and position."""
    names = [column.name for column in table.columns]
    if name in names:
        return names.index(name)
    if name.startswith("#") and name[1:].isdigit() and 1 <= int(name[1:]) <= len(names):
        return int(name[1:]) - 1
    alike = [k for k, other in enumerate(names) if other.strip().lower() == name.strip().lower()]
    if len(alike) == 1:
        return alike[0]
    raise ValueError(f"{table.source}: column {name!r} is not there; {closest(name, [n for n in names if n])}")


def _is_told(quantity: str, targets: Iterable[str]) -> bool:
    return any(read_target(target)[0] == quantity for target in targets)


def _is_empty(column: Column) -> bool:
    return column.values.dtype.kind == "f" and bool(np.all(np.isnan(column.values)))


def _as_told(table: RawTable, column: Column, target: str) -> Reading | None:
    quantity, unit = read_target(target)
    if quantity == LEFT_OUT:
        return None
    if unit:
        return Reading(column, quantity, unit, stated=True, told=True)
    found = guess(column.name)
    written = column.unit or bracketed(column.name) or (found.unit if found else "")
    if quantity == "time" and column.values.dtype.kind != "f":
        return Reading(column, quantity, "", stated=True, told=False)
    if not written:
        return Reading(column, quantity, _usual(quantity), stated=False, told=False)
    return Reading(column, quantity, _known_unit(table, column, quantity, written), stated=True, told=False)


def _as_guessed(table: RawTable, column: Column) -> Reading | None:
    """What a column is by its name and unit; None where that is not plain."""
    found = guess(column.name)
    if found is None or (column.is_text and found.quantity != "time"):
        return None
    written = column.unit or found.unit
    if not written:
        named = found.own_name or found.quantity == "time"
        return Reading(column, found.quantity, _usual(found.quantity), stated=False, told=False) if named else None
    if found.quantity == "time" and column.values.dtype.kind != "f":
        return Reading(column, "time", "", stated=True, told=False)  # whatever it says, such as [hh:mm:ss]
    known = _known_unit(table, column, found.quantity, written)
    return Reading(column, found.quantity, known, stated=True, told=False)


def _known_unit(table: RawTable, column: Column, quantity: str, written: str) -> str:
    kind = QUANTITIES[quantity]
    known = unit_of(kind, written)
    if known is None:
        raise ValueError(
            f"{table.source}: {written!r} of column {column.name!r} is no unit of {quantity}; allowed: "
            f'{units_allowed(kind)}; tell it, or leave it out: --map "{column.name}={LEFT_OUT}"'
        )
    return known


def _usual(quantity: str) -> str:
    return "" if quantity == "time" else next(iter(UNITS[QUANTITIES[quantity]]))
