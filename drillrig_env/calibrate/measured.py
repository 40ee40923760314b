"""Score a measured time series against the model: P_C (4-10) and APL (4-11) of every measured speed.

FILE is what a logger writes: text of any separator, MATLAB, TDMS, Parquet or Excel, with a column of times
and one or more of the speeds of bit, collars and top; docs/records.md has all that is read. Such as

    time [s];bit_speed [rpm];top_speed [rpm]
    12,50;0,00;0,00
    12,55;0,03;3,93

How it was read is printed first. The first sample becomes t = 0. There the model starts, with the same
speed reference and load:

drillrig measured FILE --speed-reference 3.14 --normal-force 25
drillrig measured FILE --speed-reference 3.14 --normal-force 0:0 50:25  # load at 50 s
drillrig measured FILE --speed-reference 3.14 --normal-force 25 --rig rig.toml
drillrig measured FILE --speed-reference 3.14 --normal-force 25 --map "Sensor 2=bit_speed:rpm" "T=time:ms"
drillrig measured FILE --map "WOB=normal_force:kN"  # where columns have them

A perfect match has P_C = 1 and APL = 0. In table 4.2 the chapter's rig has P_C 0.89 to 0.96 and APL
0.01 to 0.17 for its bit speed. For another rig, write the chapter's as a template, and edit it:

drillrig info --write rig.toml --write-friction friction.toml
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import ceil
from pathlib import Path
from typing import Literal

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.records import Record, check_reference, parse_map, read_record
from drillrig_env.command_line import Parser, command
from drillrig_env.files import check_writable_file, written_whole
from drillrig_env.flags import add_friction_argument, add_rig_argument, add_schedule_argument, of_kind
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.indicators import CHAPTER_WINDOW, Score, score_signals, score_table
from drillrig_env.inputs import Inputs, Schedule
from drillrig_env.model import steady_state
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, Allowed, closest, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.simulation import simulate

Start = Literal["rest", "steady"]

STARTS: tuple[Start, ...] = ("rest", "steady")
_SAMPLE_PERIOD = 1e-3  # s; interpolating at 0.01 s would miss how the drive answers a step by up to 1 rad/s


def reproduce(
    record: Record,
    rig: RigLike = None,
    friction: FrictionLike = None,
    *,
    speed_reference: Schedule | None = None,
    normal_force: Schedule | None = None,
    start: Start = "rest",
) -> dict[str, FloatArray]:
    """The measured speeds as the model has them at the record's times, by name, each (n,) in rad/s.

    The model starts at t = 0: at rest, or with `start` "steady" in the steady rotation (4-16) of its
    first speed reference and normal force. Both are as recorded where they are not given, and the force
    the friction's where it was not recorded. Other arguments as for `simulate`; between samples 1 ms
    apart the result is interpolated. Raises `ValueError` as `simulate` does, for a record that begins
    before t = 0, without a speed reference, for speeds that the reference cannot have made, such as rpm
    beside rad/s, for an unknown start, and for a steady one at a speed reference of 0.
    """
    begin, end = float(record.time[0]), float(record.time[-1])
    if not NOT_NEGATIVE.holds(begin):
        raise refuse("reproduce", "first time of the record", begin, "s", NOT_NEGATIVE)
    if start not in STARTS:
        raise ValueError(f"reproduce: start = {start!r} is not known; {closest(start, STARTS)}")
    rig, friction = Rig.of(rig), Friction.of(friction)
    if speed_reference is None:
        speed_reference = record.schedule(record.speed_reference)
    if speed_reference is None:
        raise _not_recorded(record, "speed_reference", "rad/s")
    if normal_force is None:
        normal_force = record.schedule(record.normal_force)
    check_reference(record, Inputs.of(friction, speed_reference, normal_force, None).reference(record.time, 0.0))
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
    return {name: np.interp(record.time, simulated.time, simulated.signals()[name]) for name in record.speeds}


def score_record(
    record: Record,
    rig: RigLike = None,
    friction: FrictionLike = None,
    *,
    speed_reference: Schedule | None = None,
    normal_force: Schedule | None = None,
    start: Start = "rest",
    window: float = CHAPTER_WINDOW,
) -> list[Score]:
    """Score every measured speed against the model, over the first `window` (s) and over all samples.

    Samples that are masked do not count. Arguments and errors as for `reproduce` and
    `drillrig_env.indicators.score_signals`.
    """
    simulated = reproduce(
        record, rig, friction, speed_reference=speed_reference, normal_force=normal_force, start=start
    )
    return _scores(record, simulated, window)


def write_comparison(path: str | Path, record: Record, simulated: Mapping[str, FloatArray]) -> None:
    """Write a CSV file: `time` (s), and every speed beside the model's, `NAME` and `NAME_model` (rad/s)."""
    columns = {"time": record.time}
    for name, measured in record.speeds.items():
        columns |= {name: measured, f"{name}_model": simulated[name]}
    table = np.column_stack(list(columns.values()))
    with written_whole(path) as new:
        np.savetxt(new, table, "%.10g", ",", header=",".join(columns), comments="")


def _not_recorded(record: Record, name: str, unit: str) -> ValueError:
    flag = f"--{name.replace('_', '-')} {unit.upper()}"
    return ValueError(f"{record.source}: {name} ({unit}) was not recorded; give it, {flag}, or tell its column")


def _scores(record: Record, simulated: Mapping[str, FloatArray], window: float) -> list[Score]:
    scores = []
    for name, measured in record.speeds.items():
        known = np.isfinite(measured)
        scores += score_signals(record.time[known], {name: measured[known]}, {name: simulated[name][known]}, window)
    return scores


@command
def main(arguments: Sequence[str] | None = None, prog: str = "python -m drillrig_env.calibrate.measured") -> int:
    """Parse the command line, say how the file was read, simulate, print the table, write the comparison."""
    parser = Parser(prog=prog, description=__doc__)
    add = parser.add_argument
    add("file", metavar="FILE", type=Path, help="the measurement")
    add_schedule_argument(parser, "--speed-reference", "rad/s", "a number, or time:value pairs (default: as recorded)")
    add_schedule_argument(parser, "--normal-force", "N", "the same; stands in for the friction's")
    add(
        "--map",
        nargs="+",
        default=[],
        metavar="COLUMN=QUANTITY:UNIT",
        help="what columns are, by name or as #2 by position, such as Bit_Speed=bit_speed:rpm; QUANTITY none: not read",
    )
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
        record = read_record(options.file, parse_map(options.map))
        print(*(f"{options.file}: {note}" for note in record.notes), sep="\n", file=sys.stderr)
        if options.start_time is not None:
            record = record.since(options.start_time)
        if options.normal_force is None and record.normal_force is None:
            raise _not_recorded(record, "normal_force", "N")
        simulated = reproduce(
            record,
            options.rig,
            options.friction,
            speed_reference=options.speed_reference,
            normal_force=options.normal_force,
            start=options.start,
        )
        print(score_table(_scores(record, simulated, options.window)))
        if options.output:
            write_comparison(options.output, record, simulated)
            print(f"measured and simulated signals: {options.output.resolve()}")
    except (ValueError, FileNotFoundError, IsADirectoryError) as error:
        parser.error(error)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
