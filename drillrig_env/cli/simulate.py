"""Run a rig in time, and say how it ends: calm, or in stick-slip.

  drillrig simulate --speed-reference 2.5 --normal-force 20
  drillrig simulate --speed-reference 0:2 50:3.5 --normal-force 0:0 10:20 --duration 100 --picture run.png
  drillrig simulate --rig my_rig.toml --csv run.csv

What changes with time is given as time:value pairs: 0:2 50:3.5 is 2 from the start and 3.5 from 50 s on. What is not
given is what the chapter's rig has, 2 rad/s, 10 N, 60 s and 0.01 s, in the scales of the rig, and is printed. The CSV
file has a column for every signal, in SI units: time, the seven states, the inputs, voltage and torques.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import replace
from math import floor, isfinite, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drillrig_env.allowed import POSITIVE, File
from drillrig_env.cli.own_rig import SAMPLE_PERIOD, SPEED_REFERENCE, USUAL_FRICTION, Usual
from drillrig_env.command_line import Parser, command
from drillrig_env.files import check_writable_file, written_whole
from drillrig_env.flags import add_friction_argument, add_rig_argument, add_schedule_argument, of_kind
from drillrig_env.scales import DURATION

if TYPE_CHECKING:
    from drillrig_env.friction import Friction
    from drillrig_env.rig import Rig
    from drillrig_env.simulation import Simulation

_PICTURES = (".png", ".svg", ".pdf")

_TAKEN = {"friction": "", "speed_reference": "rad/s", "duration": "s", "sample_period": "s"}
"""What a run takes from the rig where it is not told, and the unit of what is a number."""

_OF_FRICTION = ("normal_force", "v_b")

_LEAST_SAMPLES = 20
"""Samples in the window at the end of a run, with fewer of which nobody can tell whether it is calm."""


@command
def main(arguments: Sequence[str] | None = None, prog: str = "drillrig simulate") -> int:
    """Parse the command line, simulate, print how the run ends, and write what is asked for."""
    parser = Parser(prog=prog, description=__doc__)
    add = parser.add_argument
    add_rig_argument(parser)
    add_friction_argument(parser, USUAL_FRICTION)
    add_schedule_argument(parser, "--speed-reference", "rad/s", f"of the drive (default: {SPEED_REFERENCE:g}, by rig)")
    add_schedule_argument(parser, "--normal-force", "N", "in place of the friction's own (the chapter's: 10, by rig)")
    seconds: dict[str, Any] = {"type": of_kind(POSITIVE, "s"), "metavar": "S"}
    add("--duration", help=f"length of the run (default: {DURATION:g}, by rig)", **seconds)
    add("--sample-period", help=f"between two samples (default: {SAMPLE_PERIOD:g}, by rig)", **seconds)
    add("--csv", type=of_kind(File()), metavar="FILE", help="write every signal there")
    add("--picture", type=of_kind(File()), metavar="FILE", help=f"draw the run; {', '.join(_PICTURES)}")
    options = parser.parse_args(arguments)
    if options.picture and options.picture.suffix not in _PICTURES:
        parser.error(f"--picture {options.picture} is not allowed; allowed: a name that ends in {', '.join(_PICTURES)}")
    for path in (options.csv, options.picture):
        if path:
            check_writable_file(path)

    from drillrig_env.simulation import simulate

    usual = Usual.of(options.rig)
    given = {name: value for name, value in vars(options).items() if value is not None}
    chosen = {name: given.get(name, getattr(usual, name)) for name in _TAKEN}
    try:
        run = simulate(options.rig, normal_force=options.normal_force, **chosen)
    except ValueError as error:
        parser.error(error)
    if taken := _taken(usual, given):
        print(f"{usual.whose}: {', '.join(taken)}")
    print(_ending(run))
    if options.csv:
        _write_csv(run, options.csv)
        print(f"signals: {options.csv.resolve()}")
    if options.picture:
        try:
            from drillrig_env.plots.run import save_run
        except ImportError as error:
            parser.error(error)
        save_run(run, options.picture)
        print(f"picture: {options.picture.resolve()}")
    return 0


def _taken(usual: Usual, given: Container[str]) -> list[str]:
    """What the run took without being told, with its unit."""
    friction = usual.friction.single()
    numbers = {
        "normal_force": (friction.normal_force, "N"),
        "v_b": (friction.v_b, "s/rad"),
        **{name: (getattr(usual, name), unit) for name, unit in _TAKEN.items() if unit},
    }
    return [
        f"{name} = {value:.4g} {unit}"
        for name, (value, unit) in numbers.items()
        if name not in given and not (name in _OF_FRICTION and "friction" in given)
    ]


def _ending(run: Simulation) -> str:
    """What the bit did over the end of the run, and what the stability analysis says of the rig there."""
    pressed = replace(run.friction, normal_force=float(run.normal_force[-1]))
    return f"{_last(run)}\ncritical speed at N_1 = {pressed.normal_force:g} N: {_critical_speed(run.rig, pressed)}"


def _last(run: Simulation) -> str:
    """How the run ended, judged over the window of the rig's own time."""
    from drillrig_env.scales import Scales
    from drillrig_env.verdict import STUCK_SPEED, WINDOW, is_calm, stick_slip_index

    try:
        scales = Scales.of(run.rig)
        window = WINDOW * scales.time
    except ValueError as error:
        return f"calm or not: ? ({error})"
    last = run.time >= run.time[-1] - window
    if last.sum() < _LEAST_SAMPLES:
        return f"calm or not: ? (the last {window:.4g} s hold {last.sum()} samples; allowed: >= {_LEAST_SAMPLES})"
    speed = run.bit_speed[last]
    low, high, mean = float(speed.min()), float(speed.max()), float(speed.mean())
    stuck = high < STUCK_SPEED * scales.speed
    verdict = "stuck" if stuck else "calm" if is_calm(low, high, mean, scales.speed) else "not calm"
    shown = f".{_decimals(max(abs(high), abs(mean), STUCK_SPEED * scales.speed))}f"
    index = "" if stuck else f", stick-slip index {float(stick_slip_index(low, high, mean)):.3f}"
    return (
        f"last {min(window, run.time[-1]):.4g} s: {verdict}; bit speed {low:{shown}} to {high:{shown}} rad/s, "
        f"mean {mean:{shown}}{index}"
    )


def _critical_speed(rig: Rig, friction: Friction) -> str:
    from drillrig_env.stability import critical_speed

    try:
        speed = float(critical_speed(rig, friction))
    except ValueError as error:
        return f"? ({error})"
    return f"{speed:.{_decimals(speed)}f} rad/s" if isfinite(speed) else "none, no speed is stable"


def _decimals(speed: float) -> int:
    """Decimals that show a speed, three at least."""
    return max(3, 3 - floor(log10(speed))) if speed > 0.0 else 3


def _write_csv(run: Simulation, path: Path) -> None:
    import numpy as np

    signals = run.signals()
    table = np.column_stack(list(signals.values()))
    with written_whole(path) as new:
        np.savetxt(new, table, "%.10g", ",", header=",".join(signals), comments="")
