"""The clock of a record: seconds from its column of times, sorted, each once, with its gaps told."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.records.columns import Reading
from drillrig_env.calibrate.records.quantities import factor
from drillrig_env.calibrate.records.raw import RawTable
from drillrig_env.calibrate.records.stamps import seconds_of_dates, seconds_of_stamps

_GAP = 10.0  # median sample periods that make a gap
_EPOCHS = ((1e17, "ns"), (1e14, "us"), (1e11, "ms"), (1e8, "s"))
"""Times above each of these, since 1970, are in that unit: the years from 1973 on, and long after all of us."""

_SAME = 0.9  # share of the rows of one time that are the same, where rows were written more than once
_RUN = 0.05  # share of the file that is a run of its own, and no samples that came late
_FEWEST = 8  # samples of such a run


@dataclass(frozen=True, eq=False)
class Clock:
    """When samples were taken: `order` are the rows that are kept, and `time` (n,) their times from 0 on, in s.

    The first of `notes` says how the times were read.
    """

    time: FloatArray
    order: npt.NDArray[np.int64]
    begin: float  # s: t = 0 on the file's own clock
    notes: tuple[str, ...]


def read_clock(table: RawTable, reading: Reading) -> Clock:
    """The clock in the column of times. `ValueError` where it runs backwards, stands, or is of two records."""
    seconds, begins, how = _seconds(table, reading)
    notes = [f"{reading.column.name or 'a column without a name'} is time{how}"]
    known = np.flatnonzero(np.isfinite(seconds))
    if len(known) < len(seconds):
        notes.append(f"rows without a time: {len(seconds) - len(known)} dropped")
    if len(known) < 2 or np.ptp(seconds[known]) == 0.0:
        raise ValueError(
            f"{table.source}, column {reading.column.name}: {len(known)} samples with a time, "
            f"{len(np.unique(seconds[known]))} of them apart; allowed: many, each at a time of its own"
        )
    _check_runs(table, reading, seconds, known)
    late = int(np.sum(np.diff(seconds[known]) < 0.0))
    order = known[np.argsort(seconds[known], kind="stable")]
    if late:
        notes.append(f"times that fall: {late}, the samples were sorted")
    time = seconds[order]
    ticks, first, counts = np.unique(time, return_index=True, return_counts=True)
    if len(ticks) >= 3 and np.median(counts) > 1 and not _is_written_twice(table, order, time):
        time = _spread(ticks, counts)
        notes.append(f"the clock ticks each {np.median(np.diff(ticks)):g} s: samples are spread evenly over each tick")
    elif len(ticks) < len(time):
        notes.append(f"repeated times: {len(time) - len(ticks)} samples dropped, the first of each time is kept")
        order, time = order[first], ticks
    steps = np.diff(time)
    if np.any(long := steps > _GAP * np.median(steps)):
        at = int(np.argmax(steps))
        notes.append(f"gaps: {int(long.sum())}, the longest of {steps[at]:.3g} s from {time[at] - time[0]:.6g} s on")
    return Clock(time - time[0], order, float(time[0]) if begins else 0.0, tuple(notes))


def _seconds(table: RawTable, reading: Reading) -> tuple[FloatArray, bool, str]:
    """The times in s; whether they are on a clock of the file's own; and how they were read."""
    column = reading.column
    if column.values.dtype.kind == "M":
        return seconds_of_dates(column.values), False, ", as dates"
    if column.is_text:
        seconds = seconds_of_stamps(column.values)
        if not np.any(np.isfinite(seconds)):
            first = column.values[0].decode(errors="replace")
            raise ValueError(
                f"{table.place(0)}, column {column.name}: {first!r} is no time; allowed: seconds, or time stamps such "
                "as 10:00:00.25, 2024-05-17T10:00:00.25 or 17.05.2024 10:00:00,25"
            )
        return seconds, False, ", as time stamps"
    if reading.unit:
        return column.values * factor("time", reading.unit), True, f" in {reading.unit}"
    first = column.values[np.isfinite(column.values)][:1]
    for least, unit in _EPOCHS:
        if len(first) and first[0] >= least:
            return (column.values - first[0]) * factor("time", unit), False, f" in {unit} from 1970 on"
    return column.values, True, " in s, as no unit is written"


def _is_written_twice(table: RawTable, order: npt.NDArray[np.int64], time: FloatArray) -> bool:
    """Whether rows of one time hold the same numbers too."""
    same_time = np.flatnonzero(np.diff(time) == 0.0)
    same = np.ones(len(same_time), dtype=bool)
    for column in table.columns:
        if column.values.dtype.kind == "f":
            values = np.nan_to_num(column.values[order])
            same &= values[same_time] == values[same_time + 1]
    return bool(np.mean(same) > _SAME)


def _check_runs(table: RawTable, reading: Reading, seconds: FloatArray, known: npt.NDArray[np.int64]) -> None:
    """Raise `ValueError` for a clock that runs backwards all the time, and where it begins anew for another record."""
    time = seconds[known]
    falls = np.flatnonzero(np.diff(time) < 0.0) + 1
    if len(falls) == len(time) - 1 > 1:
        raise ValueError(
            f"{table.place(int(known[0]))}, column {reading.column.name}: the clock runs backwards, "
            f"from {time[0]:g} to {time[-1]:g} s; allowed: the earliest sample first"
        )
    begins = np.concatenate([[0], falls, [len(time)]])
    lengths = np.diff(begins)
    for k in np.flatnonzero(lengths >= max(_FEWEST, _RUN * len(time)))[1:]:
        begin, end = begins[k], begins[k + 1]
        inside = np.count_nonzero((time[:begin] > time[begin]) & (time[:begin] < time[end - 1]))
        if inside > 0.5 * lengths[k]:
            raise ValueError(
                f"{table.place(int(known[begin]))}, column {reading.column.name}: the clock falls from "
                f"{time[begin - 1]:g} to {time[begin]:g} s and runs through the same times again; "
                "allowed: one record a file"
            )


def _spread(ticks: FloatArray, counts: npt.NDArray[np.int64]) -> FloatArray:
    """Times of samples whose clock ticks more slowly than they come, evenly spread over each tick.

    The first tick may have begun before the record, and the last may go on after it.
    """
    lengths = np.diff(ticks)
    usual = np.median(lengths)
    step = usual / np.median(counts)
    steps = np.append(np.where(lengths < 1.5 * usual, lengths, usual), 0.0) / counts  # none goes on through a gap
    steps[-1] = step
    begins = ticks.copy()
    if counts[0] < np.median(counts):
        begins[0], steps[0] = ticks[1] - counts[0] * step, step
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.asarray(np.repeat(begins, counts) + within * np.repeat(steps, counts))
