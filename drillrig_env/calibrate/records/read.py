"""From a file of a logger to a record: columns found, times sorted, units made SI, glitches masked, all of it told."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.records.angle import speed_of_angle
from drillrig_env.calibrate.records.clock import Clock, read_clock
from drillrig_env.calibrate.records.columns import Reading, find_columns
from drillrig_env.calibrate.records.frames import read_excel, read_parquet
from drillrig_env.calibrate.records.glitches import find_glitches, without_values
from drillrig_env.calibrate.records.matlab import read_matlab
from drillrig_env.calibrate.records.plausible import (
    check_clock,
    check_length,
    check_motion,
    check_reference,
    check_sampling,
    check_speeds,
)
from drillrig_env.calibrate.records.quantities import QUANTITIES, factor
from drillrig_env.calibrate.records.raw import RawTable
from drillrig_env.calibrate.records.record import SPEEDS, Record
from drillrig_env.calibrate.records.tdms import read_tdms
from drillrig_env.calibrate.records.text import read_text
from drillrig_env.files import digest

SIGNALS = (*SPEEDS, "current", "voltage", "torque_into_string")
_UNREAD = 0.01  # share of a column's cells that may be neither numbers nor empty
_READERS = {
    ".mat": read_matlab,
    ".tdms": read_tdms,
    ".parquet": read_parquet,
    ".pq": read_parquet,
    ".xlsx": read_excel,
    ".xlsm": read_excel,
}
"""What reads a file by how its name ends; any other is text."""


def read_record(path: str | Path, columns: Mapping[str, str] | None = None) -> Record:
    """The record in a file of a logger: text of any separator, MATLAB, TDMS, Parquet or Excel; see docs/records.md.

    `path` is the file.

    `columns` says what columns are, by name or by position as "#2": `{"Bit_Speed": "bit_speed:rpm", "#1": "time:ms"}`.
    What it does not name is taken by name and unit where these are plain, or left out; `Record.notes` tell of all.

    Raises `ValueError`, naming file, line or time and what would help, for what is no record of a rig; `ImportError`
    where a format needs a package that is not installed; and `OSError` where the file cannot be read.
    """
    source = str(path)
    columns = {} if columns is None else columns
    table = _table(Path(path), columns)
    readings, left_out = find_columns(table, columns)
    _check_columns(table, readings)
    clock = read_clock(table, readings["time"])
    notes = [*table.notes, *clock.notes[:1], *(str(one) for name, one in readings.items() if name != "time")]
    if left_out:
        notes.append(f"left out: {', '.join(left_out)}")
    notes += clock.notes[1:]
    values = {name: _values(table, reading, clock, notes) for name, reading in readings.items() if name != "time"}
    for name in [name for name in values if QUANTITIES[name] == "angle"]:
        _differentiate(name, clock, values, readings, notes)
    signals = {name: values[name] for name in SIGNALS if name in values}
    _leave_out_unconnected(signals, notes)
    for name in (*SPEEDS, "torque_into_string"):  # discs cannot jump; current and voltage do, as the drive acts
        if name in signals:
            _mask(name, clock.time, signals, notes)
    record = Record(
        source=source,
        digest=digest(path),
        time=clock.time,
        signals=signals,
        speed_reference=_held("speed_reference", values),
        normal_force=_force(source, values, notes),
        notes=tuple(notes),
        begin=clock.begin,
    )
    check_length(record)
    check_motion(record)
    check_clock(record, readings["time"])
    check_speeds(record, readings)
    check_sampling(record)
    if record.speed_reference is not None:
        check_reference(record, record.speed_reference)
    return record


def _table(path: Path, columns: Mapping[str, str]) -> RawTable:
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder; allowed: a file")
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        return read_text(str(path), path.read_bytes(), columns)
    path.open("rb").close()  # a file that is not there is the same error in every format
    return reader(str(path))


def _check_columns(table: RawTable, readings: Mapping[str, Reading]) -> None:
    """Raise `ValueError` for what is missing, and for columns that are read and hold other things than numbers."""
    names = ", ".join(column.name for column in table.columns if column.name)
    speeds = [name for name in readings if name in SPEEDS or QUANTITIES[name] == "angle"]
    for what, there in (("time", "time" in readings), ("speed of a disc", bool(speeds))):
        if not there:
            target = "time:s" if what == "time" else "bit_speed:rpm"
            raise ValueError(
                f"{table.place(0)}: no column is plainly a {what}; found: {names}; tell which one is: "
                f'--map "COLUMN={target}"'
            )
    for name, reading in readings.items():
        column = reading.column
        if name != "time" and column.values.dtype.kind != "f":
            first = column.values[0].decode(errors="replace") if column.is_text else str(column.values[0])
            raise ValueError(f"{table.place(0)}, column {column.name}: {first!r} is not allowed; allowed: numbers")
        if column.unread is not None and column.unread.count > _UNREAD * len(column.values):
            raise ValueError(
                f"{table.place(column.unread.row)}, column {column.name}: {column.unread.text!r} is not allowed; "
                f"allowed: a number, or nothing ({column.unread.count} such cells)"
            )


def _values(table: RawTable, reading: Reading, clock: Clock, notes: list[str]) -> FloatArray:
    """The values of a column in SI units, at the times of the clock; NaN where there is none."""
    column = reading.column
    values = without_values(column.values)[clock.order] * factor(QUANTITIES[reading.quantity], reading.unit)
    if not np.any(np.isfinite(values)):
        raise ValueError(f"{table.source}, column {column.name}: no value in {len(values)} samples; allowed: numbers")
    if absent := int(np.sum(np.isnan(values))):
        unread = f", {column.unread.text!r} among them" if column.unread is not None else ""
        notes.append(f"{reading.quantity}: {absent} samples without a value{unread}")
    return np.asarray(values)


def _differentiate(
    angle: str, clock: Clock, values: dict[str, FloatArray], readings: dict[str, Reading], notes: list[str]
) -> None:
    """Put the speed in the place of an angle, unless it was measured as well."""
    speed = angle.replace("angle", "speed")
    if speed in values:
        notes.append(f"left out: {angle}, as {speed} is there")
        return
    values[speed], how = speed_of_angle(clock.time, values.pop(angle))
    readings[speed] = readings[angle]
    notes.append(f"{speed}: {angle} {how}")


def _mask(name: str, time: FloatArray, signals: dict[str, FloatArray], notes: list[str]) -> None:
    """Mask the glitches of a signal."""
    glitches = find_glitches(time, signals[name])
    if np.any(glitches):
        signals[name] = np.where(glitches, np.nan, signals[name])
        first = time[np.argmax(glitches)]
        notes.append(f"{name}: {int(glitches.sum())} samples masked as glitches, the first at {first:.6g} s")


def _leave_out_unconnected(signals: dict[str, FloatArray], notes: list[str]) -> None:
    """Leave out speeds that are 0 at all times, where another is not: no sensor is connected there."""
    still = [name for name in SPEEDS if name in signals and not np.any(np.nan_to_num(signals[name]))]
    if len(still) < sum(name in signals for name in SPEEDS):
        for name in still:
            del signals[name]
            notes.append(f"left out: {name}, which is 0 rad/s at all times")


def _held(name: str, values: Mapping[str, FloatArray]) -> FloatArray | None:
    """An input of the rig, which goes on as it was where no value was written; None where it was not recorded."""
    if name not in values:
        return None
    given = values[name]
    known = np.isfinite(given)
    held = np.maximum.accumulate(np.where(known, np.arange(len(given)), int(np.argmax(known))))
    return np.asarray(given[held])


def _force(source: str, values: Mapping[str, FloatArray], notes: list[str]) -> FloatArray | None:
    """The normal force, held as other inputs; a little below 0 it is the sensor's zero that has moved."""
    force = _held("normal_force", values)
    if force is None or force.min() >= 0.0:
        return force
    if force.min() < -0.2 * force.max():
        raise ValueError(
            f"{source}: normal_force is {force.min():.4g} to {force.max():.4g} N; allowed: >= 0 N; "
            'turn it round or leave it out: --map "COLUMN=normal_force:-N", --map "COLUMN=none"'
        )
    notes.append(f"normal_force: {int(np.sum(force < 0.0))} samples below 0 N are read as 0 N")
    return np.maximum(force, 0.0)
