"""Fit a rig and its friction to records of it: what logger files tell of it, and how well.

  drillrig calibrate noload.csv sweep.csv stick_slip.csv --fix J_1=0.0288 --output my_rig
  drillrig calibrate run.csv --speed-reference 2.0 --normal-force 0:0 10:20 --look
  drillrig simulate --rig my_rig --speed-reference 2

Speed reference and normal force are columns of the records, or given here for those without. Speeds, currents and
voltages leave one common scale of all torques open: fix or weigh one disc (--fix J_1=0.0288, --weigh J_1=0.02) or K_T,
or log the torque into the string. Three kinds of record together tell most: steps of the speed without load, a slow
sweep of it under load, and some 20 s of stick-slip. --look says what the records can tell before any fit. The folder
has rig.toml and friction.toml, intervals, joint draws and a page, index.html. Ctrl-C ends the search for better starts;
the best so far goes on. With --output, starts that are done are kept beside the folder until all are, and --resume goes
on with them, whatever stopped the search, to the same result.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from drillrig_env.allowed import COUNT, POSITIVE, Allowed
from drillrig_env.calibrate.calibration import STARTS, Calibration
from drillrig_env.calibrate.fit_of_command import begun, fit_of, kept_of
from drillrig_env.calibrate.held_out import HELD_OUT, SHARE
from drillrig_env.calibrate.kept import Kept
from drillrig_env.calibrate.laws import AUTO
from drillrig_env.calibrate.look import HEADINGS, look
from drillrig_env.calibrate.records import Record, parse_map, read_record
from drillrig_env.calibrate.sampled import STEPS, emcee_module, sampled
from drillrig_env.command_line import Parser, command
from drillrig_env.engine import Engine
from drillrig_env.flags import (
    add_engine_arguments,
    add_friction_argument,
    add_rig_argument,
    add_schedule_argument,
    engine_of,
    of_kind,
)
from drillrig_env.friction.contact import LAWS
from drillrig_env.jit.threads import available_threads
from drillrig_env.markdown import table
from drillrig_env.progress import Progress
from drillrig_env.stepper.finite import NotFiniteError


@command
def main(arguments: Sequence[str] | None = None, prog: str = "drillrig calibrate") -> int:
    """Parse the command line, read the records, fit, print what is known and write the folder."""
    parser = Parser(prog=prog, description=__doc__)
    add = parser.add_argument
    add("records", metavar="RECORD", nargs="+", type=Path, help="logger files; see docs/records.md")
    add("--map", metavar="COLUMN=QUANTITY[:UNIT]", nargs="+", default=[], help='such as "Bit_Speed=bit_speed:rpm"')
    add_rig_argument(parser)
    add_friction_argument(parser)
    add_schedule_argument(parser, "--speed-reference", "rad/s", "of records without a column of it")
    add_schedule_argument(parser, "--normal-force", "N", "the same")
    add("--fix", metavar="NAME[=VALUE]", nargs="+", default=[], help="parameters that are known")
    add("--weigh", metavar="NAME=SHARE", nargs="+", default=[], help="known within a relative standard deviation")
    add(
        "--law",
        choices=[*LAWS, AUTO],
        help="of friction (default: that of --friction), or auto: the best of all in windows held out, with --viscous",
    )
    add("--viscous", action="store_true", help="look for a viscous loss of the bit, C_1, where the rig has none")
    add(
        "--posterior",
        choices=["normal", "emcee"],
        default="normal",
        help="what joint draws are of: a normal distribution of the logarithms, or Markov chains (default: normal)",
    )
    add("--posterior-steps", type=of_kind(COUNT), metavar="N", help=f"most steps of such a chain (default: {STEPS})")
    add("--window", type=of_kind(POSITIVE, "s"), metavar="S", help="length of a piece with a start of its own (by rig)")
    add(
        "--held-out",
        type=of_kind(SHARE),
        default=HELD_OUT,
        metavar="SHARE",
        help=f"of each record's windows, not fitted but judged by (default: {HELD_OUT:g})",
    )
    add("--starts", type=of_kind(COUNT), default=STARTS, help=f"places that the fit begins from (default: {STARTS})")
    add("--seed", type=of_kind(Allowed(0, whole=True)), default=0, help="of these places and of the draws (default: 0)")
    add_engine_arguments(parser, "starts, walkers and draws", "the cores")
    add("--look", action="store_true", help="say what the records can tell, and fit nothing")
    add("--output", metavar="DIR", type=Path, help="folder for the result; with --look a picture, .png or .svg")
    add("--overwrite", action="store_true", help="in place of one that is there")
    add("--resume", action="store_true", help="go on with a search that was stopped, given the same arguments")
    words = list(sys.argv[1:] if arguments is None else arguments)
    options = parser.parse_args(words)
    try:
        with _folder(options) as folder:
            kept = _run(options, folder, f"{prog} {shlex.join(words)}")
        if folder is not None:
            print(f"written: {options.output.resolve()}")
        if kept is not None:
            kept.remove()
    except (ValueError, ImportError, OSError, NotFiniteError) as error:
        parser.error(error)
    return 0


def _folder(options: argparse.Namespace) -> AbstractContextManager[Path | None]:
    """The folder to write the result into, which no other process has; None where there is none to write."""
    if options.output is None:
        return nullcontext()
    if options.look:
        from drillrig_env.calibrate.pictures.look import check_place

        check_place(options.output, options.overwrite)
        return nullcontext()
    from drillrig_env.calibrate.result import reserved

    return reserved(options.output, options.overwrite)


def _run(options: argparse.Namespace, folder: Path | None, line: str) -> Kept | None:
    """Read the records, look or fit, say what is known, and write the files; the search, where it is at its end."""
    if options.resume and folder is None:
        raise ValueError("--resume is given without --output, beside which a search is kept; give both")
    if options.posterior == "emcee":
        emcee_module()  # it may be missing, which is to be told before the fit
    elif options.posterior_steps is not None:
        raise ValueError("--posterior-steps is given without --posterior emcee; give both")
    known: dict[str, Any] = {"fix": dict(map(_fixed, options.fix)), "weigh": dict(map(_weighed, options.weigh))}
    columns = parse_map(options.map)
    records = [read_record(path, columns) for path in options.records]
    for one in records:
        print(f"{one.source}: {'; '.join(one.notes)}")
    records = _with_inputs(records, options)
    if options.look:
        told = look(records, *begun(options, known["fix"]), window=options.window, **known)
        print(table(HEADINGS, told.rows(), words=(HEADINGS[0], HEADINGS[2])), "", *told.advice(), sep="\n")
        if options.output is not None:
            from drillrig_env.calibrate.pictures.look import write_look

            write_look(options.output, told)
            print(f"written: {options.output.resolve()}")
        return None
    kept = kept_of(records, options) if folder is not None else None
    with engine_of(options, available_threads()) as engine:
        found = fit_of(records, options, known, kept, line, engine)
        if options.posterior == "emcee":
            with Progress("calibrate", 1) as progress:
                steps = options.posterior_steps or STEPS
                found = sampled(
                    found,
                    steps,
                    lambda done, time: progress.show("steps", done, steps, f", autocorrelation time {time:.0f}"),
                    engine,
                )
        _report(found, line, folder, engine)
    return None if found.best.stopped else kept


def _report(found: Calibration, line: str, folder: Path | None, engine: Engine) -> None:
    """Print what is known, and write the folder where one is asked for."""
    from drillrig_env.calibrate.report import Report

    with Progress("calibrate", 1) as progress:
        report = Report.of(found, line, lambda done, of: progress.show("rigs drawn", done, of), engine=engine)
    for title, headings, rows in report.tables():
        print(f"\n{title}\n\n{table(headings, rows, words=3)}")
    print("", *report.sentences(), sep="\n")
    if folder is None:
        return
    from drillrig_env.calibrate.pictures import draw_all
    from drillrig_env.calibrate.result import write_result

    write_result(folder, report, draw_all(report))


def _with_inputs(records: list[Record], options: argparse.Namespace) -> list[Record]:
    """The records, and where they have no column of an input, the one that the command line gives.

    `ValueError` where every record has a column of what is given.
    """
    for name in ("speed_reference", "normal_force"):
        if (schedule := getattr(options, name)) is None:
            continue
        if all(getattr(one, name) is not None for one in records):
            told = f"--{name.replace('_', '-')} is given, but every record has a column of it"
            raise ValueError(f"{told}; leave it out, or the column by --map COLUMN=none")
        times, values = np.array(schedule).T
        for k, one in enumerate(records):
            if getattr(one, name) is None:
                held = values[np.clip(np.searchsorted(times, one.time + 1e-9, side="right") - 1, 0, None)]
                records[k] = replace(one, **{name: held})
    return records


def _fixed(text: str) -> tuple[str, float | None]:
    """A parameter of --fix, with its value where one is given."""
    name, given, value = text.partition("=")
    return name, _number(text, value) if given else None


def _weighed(text: str) -> tuple[str, float]:
    """A parameter of --weigh with its share."""
    name, _, value = text.partition("=")
    return name, _number(text, value)


def _number(text: str, value: str) -> float:
    try:
        return float(value)
    except ValueError:
        raise ValueError(f"{text!r} is not allowed; allowed: NAME=NUMBER") from None


if __name__ == "__main__":
    raise SystemExit(main(prog="python -m drillrig_env.calibrate.command"))
