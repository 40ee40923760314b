"""Show a rig in numbers: its parameters, and what follows from them at a normal force.

  drillrig info                                         # the chapter's rig at 10 N; another at what corresponds to it
  drillrig info --rig my_rig.toml --normal-force 20
  drillrig info --write my_rig.toml --write-friction my_friction.toml   # the chapter's, to edit

Below the critical speed omega_c steady rotation is unstable: the rig will stick and slip. Above the fold
there is no stick-slip (at heavy loads: above the end, a little higher). Between them both are stable, and what
the rig does depends on what it did before.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import isfinite, nan
from pathlib import Path

from drillrig_env.allowed import NOT_NEGATIVE, POSITIVE, File
from drillrig_env.cli.own_rig import USUAL_FRICTION, Usual
from drillrig_env.command_line import Parser, command
from drillrig_env.files import check_writable_file
from drillrig_env.flags import add_friction_argument, add_rig_argument, of_kind
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales


@command
def main(arguments: Sequence[str] | None = None, prog: str = "drillrig info") -> int:
    """Parse the command line, then write files or print what is known of the rig."""
    parser = Parser(prog=prog, description=__doc__)
    add = parser.add_argument
    add_rig_argument(parser)
    add_friction_argument(parser, USUAL_FRICTION)
    add("--normal-force", type=of_kind(NOT_NEGATIVE, "N"), metavar="N", help="in place of the friction's own")
    add("--speed-reference", type=of_kind(POSITIVE, "rad/s"), metavar="RAD/S", help="also the orbit at this speed")
    add("--write", type=of_kind(File()), metavar="FILE", help="write the rig as a TOML file, and print nothing else")
    add("--write-friction", type=of_kind(File()), metavar="FILE", help="write the friction in the same way")
    options = parser.parse_args(arguments)
    rig, usual = Rig.of(options.rig), Usual.of(options.rig)
    friction = usual.friction if options.friction is None else Friction.of(options.friction)
    if options.normal_force is not None:
        friction = replace(friction, normal_force=options.normal_force)
    if options.write or options.write_friction:
        wanted: list[tuple[Rig | Friction, Path | None]] = [(rig, options.write), (friction, options.write_friction)]
        for _, path in wanted:
            if path and path.exists():
                parser.error(f"{path} is there already, and nothing is written over it")
            if path:
                check_writable_file(path)
        for record, path in wanted:
            if path:
                record.to_toml(path)
                print(path.resolve())
        return 0
    print(rig.describe(), "", friction.describe(), "", sep="\n")
    if options.friction is None:
        print(f"friction: {usual.whose}; --friction FILE takes another, --normal-force N another force\n")
    for line in _derived(rig, friction):  # one by one: where a number cannot be computed, those before it are said
        print(line)
    if options.speed_reference is not None:
        print("", *_orbit(rig, friction, options.speed_reference), sep="\n")
    return 0


def _derived(rig: Rig, friction: Friction) -> Iterator[str]:
    """What follows from the parameters, a line each: name, value, unit, meaning."""
    from drillrig_env.stability import critical_slope, critical_speed, end_of_stick_slip, fold_speed

    low, high = rig.string_frequencies
    yield _line("f_1, f_2", f"{_number(low)}, {_number(high)}", "Hz", "frequencies of the string, the top held still")
    yield _line("1/f_1, 1/f_2", f"{_number(1 / low)}, {_number(1 / high)}", "s", "its periods")
    yield _line("impedance", _number(rig.impedance), "N m s/rad", "of the string, for torque laws at the top")
    try:
        scales = Scales.of(rig)
        grown = f"{scales.time:.4g}, {scales.speed:.4g}, {scales.force:.4g}"
        yield _line("scales", grown, "", "of times, speeds and normal forces; the chapter's are 1")
    except ValueError as error:
        yield _line("scales", "?", "", str(error))
    try:
        slope = critical_slope(rig)
        about = "the steepest fall of friction that leaves rotation stable" if isfinite(slope) else "no slope is stable"
        yield _line("slope_min", _number(slope), "N m s/rad", about)
    except ValueError as error:
        yield _line("slope_min", "?", "N m s/rad", str(error))
    try:
        speed = float(critical_speed(rig, friction))
        about = "critical speed: below it steady rotation is unstable" if isfinite(speed) else "no speed is stable"
        yield _line("omega_c", _number(speed), "rad/s", about)
    except ValueError as error:
        yield _line("omega_c", "?", "rad/s", str(error))
    fold, unknown = nan, ""
    try:
        fold = float(fold_speed(rig, friction))
    except (ValueError, FloatingPointError) as error:
        unknown = str(error)
    try:
        end = end_of_stick_slip(rig, friction)
    except (ValueError, FloatingPointError) as error:
        yield _line("fold", "?", "rad/s", str(error))
        return
    both = "above it there is no stick-slip; from omega_c to here both are stable"
    if end.kind == "none":
        yield _line("fold", "none", "", "no stick-slip: friction is too weak, or falls within the stick zone alone")
    elif end.kind == "grazing":
        yield _line("fold", _number(float(end.speed)), "rad/s", both)
    else:
        if unknown:
            yield _line("fold", "?", "rad/s", unknown)
        elif isfinite(fold):
            yield _line("fold", _number(fold), "rad/s", "orbits that slip all the time end here")
        yield _line("end", _number(float(end.speed)), "rad/s", both)


def _orbit(rig: Rig, friction: Friction, speed_reference: float) -> Iterator[str]:
    """The stick-slip of the rig at a speed reference, a line for each of its numbers."""
    from drillrig_env.stability import stick_slip_orbit

    try:
        orbit = stick_slip_orbit(rig, friction, speed_reference)
    except (ValueError, FloatingPointError) as error:  # no such orbit, or none that can be computed
        yield f"at {speed_reference:g} rad/s: {error}"
        return
    yield f"stick-slip at {speed_reference:g} rad/s:"
    yield _line("period", _number(orbit.period), "s", "of the orbit")
    yield _line("stuck", f"{orbit.stuck:.3f}", "", "share of the period in which the bit stands still")
    yield _line("highest", _number(orbit.highest[0].max()), "rad/s", "largest bit speed")


def _number(value: float) -> str:
    """Four digits, whatever the size: a rig may count in micronewtons."""
    return f"{value:#.4g}".rstrip(".")


def _line(name: str, value: str, unit: str, meaning: str) -> str:
    return f"{name:<13} {value:<14} {unit:<10} {meaning}".rstrip()
