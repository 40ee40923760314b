"""Score a measured time series against the model: P_C (4-10) and APL (4-11) of every measured speed.

FILE.csv has a header and cells separated by commas: `time` (s, ascending) and any of `bit_speed`,
`collar_speed`, `top_speed` (rad/s); what else `drillrig simulate --csv` writes is passed over. Such as

    time,bit_speed,top_speed
    12.50,0.000,0.000
    12.55,0.003,0.412

The first sample becomes t = 0. There the model starts, with the same speed reference and load:

drillrig measured FILE.csv --speed-reference 3.14 --normal-force 25
drillrig measured FILE.csv --speed-reference 3.14 --normal-force 0:0 50:25  # load at 50 s
drillrig measured FILE.csv --speed-reference 3.14 --normal-force 25 --rig rig.toml

A perfect match has P_C = 1 and APL = 0. In table 4.2 the chapter's rig has P_C 0.89 to 0.96 and APL
0.01 to 0.17 for its bit speed. For another rig, write the chapter's as a template, and edit it:

drillrig info --write rig.toml --write-friction friction.toml
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import ceil, isfinite
from pathlib import Path
from typing import Literal

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.command_line import Parser, command
from drillrig_env.files import check_writable_file, written_whole
from drillrig_env.flags import add_friction_argument, add_rig_argument, add_schedule_argument, of_kind
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.indicators import CHAPTER_WINDOW, Score, score_signals, score_table
from drillrig_env.inputs import Schedule
from drillrig_env.model import steady_state
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, Allowed, closest, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.simulation import SIGNALS, simulate

Start = Literal["rest", "steady"]

STARTS: tuple[Start, ...] = ("rest", "steady")
SPEEDS = ("bit_speed", "collar_speed", "top_speed")
COLUMNS = ("time", *SPEEDS)
_PASSED_OVER = frozenset(SIGNALS) - frozenset(COLUMNS)
"""Columns that `drillrig simulate --csv` writes beside these; there is nothing to score in them."""

_SAMPLE_PERIOD = 1e-3  # s; interpolating at 0.01 s would miss how the drive answers a step by up to 1 rad/s


@dataclass(frozen=True, eq=False)
class Measurement:
    """A measured run: `time` (n,) in s, ascending from 0, and `signals` by name, each (n,) in rad/s."""

    time: FloatArray
    signals: dict[str, FloatArray]


def read_measurement(path: str | Path, start_time: float | None = None) -> Measurement:
    """Read a CSV file: a header, `time` (s, ascending) and any of `SPEEDS` (rad/s). Empty lines are skipped.

    What else `drillrig simulate --csv` writes is passed over.

    The first sample becomes t = 0; or `start_time` (s, on the file's own clock) does, and what was
    sampled before is left out. Raises `ValueError` that names file, line (counted from 1, as an editor
    does) and column of what cannot be right, or a `start_time` that leaves fewer than 2 samples;
    `OSError` where the file cannot be read.
    """
    # replaced, a byte that is not UTF-8 ends up in an error that names its line and column
    text = Path(path).read_text(encoding="utf-8-sig", errors="replace")
    lines = [
        (f"{path}, line {number}", [cell.strip().strip('"') for cell in line.split(",")])
        for number, line in enumerate(text.split("\n"), start=1)
        if line.strip()
    ]
    where, header = lines[0] if lines else (f"{path}, line 1", [])
    _check_header(where, header)
    if len(lines) < 3:
        raise ValueError(f"{lines[-1][0]}, column time: samples in the file: {len(lines) - 1}; allowed: >= 2")
    table = np.array([_numbers(where, header, cells) for where, cells in lines[1:]])
    time = table[:, header.index("time")]
    if np.any(late := np.diff(time) <= 0):
        row = int(np.argmax(late)) + 1
        raise ValueError(
            f"{lines[row + 1][0]}, column time: {time[row]} s is not allowed; "
            f"allowed: > {time[row - 1]} s, the sample before"
        )
    start = float(time[0]) if start_time is None else start_time
    if not time[0] <= start <= time[-2]:
        raise refuse(str(path), "start_time", start, "s", f">= {time[0]} and <= {time[-2]}")
    table = table[time >= start]
    return Measurement(
        time=table[:, header.index("time")] - start,
        signals={name: table[:, header.index(name)] for name in SPEEDS if name in header},
    )


def _check_header(where: str, header: Sequence[str]) -> None:
    if all(_is_number(name) for name in header):
        raise ValueError(f"{where}, column 1: the header is missing; allowed: {', '.join(COLUMNS)}")
    for position, name in enumerate(header):
        if name not in COLUMNS and name not in _PASSED_OVER:
            raise ValueError(f"{where}, column {position + 1}: {name!r} is not known; {closest(name, COLUMNS)}")
        if name in header[:position]:
            raise ValueError(f"{where}, column {position + 1}: {name} is there twice; allowed: once")
    if "time" not in header:
        raise ValueError(f"{where}, column time: missing; found: {', '.join(header)}")
    if not set(header) & set(SPEEDS):
        raise ValueError(f"{where}, column 2: no speed beside time; allowed: any of {', '.join(SPEEDS)}")


def _numbers(where: str, header: Sequence[str], cells: Sequence[str]) -> list[float]:
    if len(cells) < len(header):
        raise ValueError(f"{where}, column {header[len(cells)]}: no cell; the header has {len(header)}")
    if len(cells) > len(header):
        raise ValueError(f"{where}, column {len(header) + 1}: a cell too many; the header has {len(header)}")
    for name, cell in zip(header, cells, strict=True):
        if not _is_number(cell) or not isfinite(float(cell)):
            raise ValueError(f"{where}, column {name}: {cell!r} is not allowed; allowed: a finite number")
    return [float(cell) for cell in cells]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def reproduce(
    measurement: Measurement,
    rig: RigLike = None,
    friction: FrictionLike = None,
    *,
    speed_reference: Schedule,
    normal_force: Schedule | None = None,
    start: Start = "rest",
) -> dict[str, FloatArray]:
    """The measured signals as the model has them at the measurement's times, by name, each (n,) in rad/s.

    The model starts at t = 0: at rest, or with `start` "steady" in the steady rotation (4-16) of its
    first speed reference and normal force. Other arguments as for `simulate`; between samples 1 ms
    apart the result is interpolated. Raises `ValueError` as `simulate` does, for a measurement that
    begins before t = 0, for an unknown start, and for a steady one at a speed reference of 0.
    """
    begin, end = float(measurement.time[0]), float(measurement.time[-1])
    if not NOT_NEGATIVE.holds(begin):
        raise refuse("reproduce", "first time of the measurement", begin, "s", NOT_NEGATIVE)
    if start not in STARTS:
        raise ValueError(f"reproduce: start = {start!r} is not known; {closest(start, STARTS)}")
    rig, friction = Rig.of(rig), Friction.of(friction)
    run = partial(
        simulate,
        rig,
        friction,
        speed_reference=speed_reference,
        normal_force=normal_force,
        sample_period=_SAMPLE_PERIOD,
    )
    initial_state = None
    if start == "steady":
        inputs = run(duration=_SAMPLE_PERIOD)  # a run of one step reads and checks both schedules
        omega_ref, N_1 = float(inputs.speed_reference[0]), float(inputs.normal_force[0])
        if not POSITIVE.holds(omega_ref):
            raise refuse("steady start", "first speed_reference", omega_ref, "rad/s", POSITIVE)
        initial_state = steady_state(rig, replace(friction, normal_force=N_1), omega_ref)
    simulated = run(initial_state=initial_state, duration=_SAMPLE_PERIOD * ceil(end / _SAMPLE_PERIOD))
    return {
        name: np.interp(measurement.time, simulated.time, simulated.signals()[name]) for name in measurement.signals
    }


def score_measurement(
    measurement: Measurement,
    rig: RigLike = None,
    friction: FrictionLike = None,
    *,
    speed_reference: Schedule,
    normal_force: Schedule | None = None,
    start: Start = "rest",
    window: float = CHAPTER_WINDOW,
) -> list[Score]:
    """Score every measured signal against the model, over the first `window` (s) and over all samples.

    Arguments and errors as for `reproduce` and `drillrig_env.indicators.score_signals`.
    """
    simulated = reproduce(
        measurement, rig, friction, speed_reference=speed_reference, normal_force=normal_force, start=start
    )
    return score_signals(measurement.time, measurement.signals, simulated, window)


def write_comparison(path: str | Path, measurement: Measurement, simulated: Mapping[str, FloatArray]) -> None:
    """Write a CSV file: `time` (s), and every signal beside the model's, `NAME` and `NAME_model` (rad/s)."""
    columns = {"time": measurement.time}
    for name, measured in measurement.signals.items():
        columns |= {name: measured, f"{name}_model": simulated[name]}
    table = np.column_stack(list(columns.values()))
    with written_whole(path) as new:
        np.savetxt(new, table, "%.10g", ",", header=",".join(columns), comments="")


@command
def main(arguments: Sequence[str] | None = None, prog: str = "python -m drillrig_env.calibrate.measured") -> int:
    """Parse the command line, simulate, print the table and, where asked, write the comparison."""
    parser = Parser(prog=prog, description=__doc__)
    add = parser.add_argument
    add("file", metavar="FILE.csv", type=Path, help="the measurement")
    add_schedule_argument(parser, "--speed-reference", "rad/s", "a number, or time:value pairs", required=True)
    add_schedule_argument(parser, "--normal-force", "N", "the same; stands in for the friction's", required=True)
    add_rig_argument(parser)
    add_friction_argument(parser)
    add("--start", choices=STARTS, default="rest", help="state of the rig at t = 0 (default: rest)")
    add(
        "--start-time",
        metavar="S",
        type=of_kind(Allowed(), "s"),
        help="time in the file that is t = 0 (default: the first sample)",
    )
    add(
        "--window",
        metavar="S",
        type=of_kind(Allowed(), "s"),
        default=CHAPTER_WINDOW,
        help="also score the first S s (default: 10)",
    )
    add("--output", metavar="CSV", type=Path, help="write the model's signals beside the measured ones")
    options = parser.parse_args(arguments)
    try:
        if options.output and options.output.resolve() == options.file.resolve():
            raise ValueError(f"--output {options.output} is not allowed: it is the measurement itself")
        if options.output:
            check_writable_file(options.output)
        measurement = read_measurement(options.file, options.start_time)
        simulated = reproduce(
            measurement,
            options.rig,
            options.friction,
            speed_reference=options.speed_reference,
            normal_force=options.normal_force,
            start=options.start,
        )
        print(score_table(score_signals(measurement.time, measurement.signals, simulated, options.window)))
        if options.output:
            write_comparison(options.output, measurement, simulated)
            print(f"measured and simulated signals: {options.output.resolve()}")
    except (ValueError, FileNotFoundError) as error:
        parser.error(str(error))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
