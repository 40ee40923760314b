"""The fit that a command line asks for, with a bar of how far it is, and what is kept of one that is stopped."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from drillrig_env.calibrate.calibration import Calibration, calibrate
from drillrig_env.calibrate.kept import Kept
from drillrig_env.calibrate.laws import AUTO, choose_law, starts_of_all, with_viscous_part
from drillrig_env.calibrate.records import Record
from drillrig_env.engine import Engine
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.friction import Friction
from drillrig_env.progress import Progress
from drillrig_env.rig import Rig

_NOT_OF_A_SEARCH = ("jobs", "look", "on", "output", "overwrite", "posterior", "posterior_steps", "resume")
"""Options that change nothing in what a fit finds."""


def kept_of(records: list[Record], options: argparse.Namespace) -> Kept:
    """Where starts that are done are kept: beside the folder for the result."""
    folder = options.output.resolve()
    of: dict[str, Any] = {name: str(value) for name, value in vars(options).items() if name not in _NOT_OF_A_SEARCH}
    of |= {"digests of the records": [one.digest for one in records], "versions": provenance()["versions"]}
    return Kept(folder.with_name(f"{folder.name}.search.json"), of, options.resume, options.overwrite)


def begun(options: argparse.Namespace, fixed: Mapping[str, Any]) -> tuple[Rig, Friction]:
    """The rig and friction that the fit begins with."""
    rig, friction = Rig.of(options.rig), Friction.of(options.friction)
    if options.viscous and "C_1" in fixed:
        raise ValueError("--viscous looks for C_1, which --fix holds; give one of them")
    if options.viscous or (options.law == AUTO and "C_1" not in fixed):
        rig = with_viscous_part(rig)
    return rig, friction if options.law in (None, AUTO) else replace(friction, law=options.law)


def fit_of(
    records: list[Record],
    options: argparse.Namespace,
    known: dict[str, Any],
    kept: Kept | None,
    line: str,
    engine: Engine,
) -> Calibration:
    """The fit, with a bar of how far it is. What is kept of one that Ctrl-C ends is told."""
    on = f"to go on: {line.removesuffix(' --resume')} --resume"
    rig, friction = begun(options, known["fix"])
    starts = starts_of_all(options.starts, friction) if options.law == AUTO else options.starts
    try:
        with Progress("calibrate", 1) as progress:
            progress.show("starts", 0, starts)
            found = (choose_law if options.law == AUTO else calibrate)(
                records,
                rig,
                friction,
                starts=options.starts,
                seed=options.seed,
                window=options.window,
                held_out=options.held_out,
                told=lambda done, cost: progress.show("starts", done, starts, f", best cost {cost:.4g}"),
                engine=engine,
                kept=kept,
                **known,
            )
    except KeyboardInterrupt as stop:
        if kept is not None and len(kept):
            stop.add_note(f"{len(kept)} fits are kept; {on}")
        raise
    if found.best.stopped:
        print(f"stopped by Ctrl-C after {found.best.starts} of {starts} starts; this is the best of them")
        if kept is not None:
            print(f"{on} --overwrite")
    return found
