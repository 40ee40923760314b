"""How often the intervals of a calibration hold the truth: twins, records of rigs that are known, fitted one by one.

    python -m benchmarks.calibration              # about an hour on two cores; writes docs/coverage.md
    python -m benchmarks.calibration --twins 5 --kinds chapter other --output few.md --results few.json

Four kinds of rig: the chapter's; one of other size, 2.5 times slower and 20 times as strong; one whose friction falls
as a Gaussian, fitted with that law; and one whose disc turns untrue by 5 %, which the fit does not know. Each twin has
three records at 100 Hz, as a logger writes them: steps of the speed without load, a slow sweep under load, and
stick-slip; with references that jump between samples, noise, speeds in steps of 0.01 of their unit, glitches and a gap.
One disc is weighed (J_1 known).

Coverage is the share of twins whose true value lies in the 90 % interval, over all parameters that the fit calls
determined, of the worst one of those that it calls so in half of the twins, and of critical speed and end of stick-slip
at the load of the records. The results file is written after each twin, and what it holds is not fitted again: a run
that was stopped goes on when the command is given again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.coverage import Coverage, Results, page
from benchmarks.measure import kept, note
from drillrig_env import Friction, Rig, Tilt, simulate
from drillrig_env.allowed import COUNT, File
from drillrig_env.calibrate.beside import beside
from drillrig_env.calibrate.calibration import BY_RECORDS, Calibration, calibrate
from drillrig_env.calibrate.meaning import meanings
from drillrig_env.calibrate.misfit import misfits
from drillrig_env.calibrate.records import Record
from drillrig_env.calibrate.unknowns import values_of
from drillrig_env.command_line import Parser, command
from drillrig_env.files import check_writable_file, write_text
from drillrig_env.flags import add_engine_arguments, engine_of, of_kind
from drillrig_env.inputs import Inputs
from drillrig_env.jit.threads import available_threads
from drillrig_env.scales import Scales
from drillrig_env.stability import critical_speed, end_of_stick_slip

PAGE = Path(__file__).parents[1] / "docs" / "coverage.md"
RESULTS = PAGE.parent / "performance" / "calibration.json"
TWINS, STARTS = 50, 1
_FIRST = 1000  # seed: how intervals are made was chosen on twins of seeds below 100
_SLOW, _STRONG = 2.5, 20.0
_GLITCHES, _STEP, _GAP = 4, 0.01, 0.5  # a record; of a speed, in its unit; s on the chapter's rig
_OFF = 0.15  # how far the fit begins from the truth, a standard deviation of logarithms
_NOISE = {"bit_speed": 0.02, "top_speed": 0.02, "current": 0.02, "voltage": 0.05}


@dataclass(frozen=True)
class Kind:
    """A rig that twins are made of."""

    rig: Rig
    friction: Friction  # N_1 is that of the loaded records
    tilt: Tilt | None = None


def kinds() -> dict[str, Kind]:
    """The kinds by name."""
    chapter = Rig()
    slow = replace(
        chapter,
        **{name: getattr(chapter, name) * _STRONG * _SLOW**2 for name in ("J_1", "J_2", "J_3")},
        **{name: getattr(chapter, name) * _STRONG for name in ("k_1", "k_2", "K_T", "T_f", "r_1")},
        **{name: getattr(chapter, name) * _STRONG * _SLOW for name in ("d_1", "d_2", "C_m")},
        **{name: getattr(chapter, name) * _SLOW for name in ("L", "K_E", "k_p")},
        omega_s=chapter.omega_s / _SLOW,
    )
    return {
        "chapter": Kind(chapter, Friction(20.0)),
        "other": Kind(slow, Friction(20.0, v_b=_SLOW)),
        "gaussian": Kind(chapter, Friction(20.0, v_b=0.5, law="gaussian")),
        "untrue": Kind(chapter, Friction(20.0), Tilt(0.05, (2,))),
    }


def records_of(kind: Kind, seed: int) -> list[Record]:
    """The three records of a twin."""
    scales, force = Scales.of(kind.rig), float(np.max(kind.friction.normal_force))
    time, speed = scales.time, scales.speed
    random = np.random.default_rng([seed, 7])
    early = 0.01 * time * random.uniform()  # the reference does not jump at samples
    sweep = [(max(0.0, 0.5 * k * time - early), (7.0 - 4.6 * k / 120.0) * speed) for k in range(120)]
    steps = [(max(0.0, t * time - early), v * speed) for t, v in ((0, 2.0), (10, 4.0), (20, 3.0), (30, 6.0))]
    return [
        logged(kind, name, reference, [(0.0, load)], length * time, random)
        for name, reference, load, length in (
            ("steps", steps, 0.0, 40.0),
            ("sweep", sweep, force, 60.0),
            ("stick-slip", [(0.0, 2.0 * speed)], force, 30.0),
        )
    ]


def logged(
    kind: Kind,
    name: str,
    reference: Any,
    load: Sequence[tuple[float, float]],
    length: float,
    random: np.random.Generator,
    *,
    period: float = 0.01,
    channels: Sequence[str] = tuple(_NOISE),
) -> Record:
    """A run of `length` s as a logger writes it, every `period` (s on the chapter's rig), with noise from `random`.

    `reference` (rad/s) and `load` (N) are schedules as `simulate` takes them; the loads change at samples.
    """
    scales = Scales.of(kind.rig)
    period *= scales.time
    run = simulate(kind.rig, kind.friction, None, reference, length, period, normal_force=load, tilt=kind.tilt)
    units = {"bit_speed": scales.speed, "top_speed": scales.speed, "current": 1.0, "voltage": 1.0}
    if scales.speed != 1.0:
        units["current"] = float(np.ptp(run.current)) or 1.0
        units["voltage"] = units["current"] * kind.rig.R / Rig().R
    signals = {}
    gap = random.uniform(0.2, 0.8) * length
    lost = (run.time >= gap) & (run.time < gap + _GAP * scales.time)
    for channel in channels:
        size = _NOISE[channel]
        values = getattr(run, channel) + size * units[channel] * random.standard_normal(len(run.time))
        if channel.endswith("speed"):
            values = _STEP * units[channel] * np.rint(values / (_STEP * units[channel]))
        values[random.choice(len(values), _GLITCHES, replace=False)] = np.nan  # which reading has masked
        signals[channel] = np.where(lost, np.nan, values)
    pressed = Inputs.of(kind.friction, reference, load, None).force(run.time, 1e-6 * period)  # as set, however untrue
    return Record(name, "", run.time, signals, run.speed_reference, pressed)


def fitted(kind: Kind, seed: int) -> Calibration:
    """The calibration of a twin, from somewhere near its rig."""
    random = np.random.default_rng([seed, 8])
    names = ("J_2", "J_3", "k_1", "k_2", "d_1", "d_2", "L", "R", "K_T", "K_E", "C_m", "T_f", "k_p", "k_i")
    off = {name: getattr(kind.rig, name) * float(np.exp(_OFF * random.standard_normal())) for name in names}
    truth = kind.friction
    friction = replace(truth, mu_s=truth.mu_s * 0.95, mu_k=truth.mu_k * 1.05, v_b=truth.v_b * 0.9)
    start = replace(kind.rig, **off)
    return calibrate(records_of(kind, seed), start, friction, fix={"J_1": None}, starts=STARTS, seed=seed)


def covered(kind: Kind, found: Calibration) -> Coverage:
    """Whether each determined parameter, and each speed, lies in its interval; and whether a misfit is told."""
    truth, force = values_of(kind.rig, kind.friction), float(np.max(kind.friction.normal_force))
    parameters = {
        name: bool(low <= truth[name] <= high) for name, _, low, high, told in found.rows() if told == BY_RECORDS
    }
    true = (float(critical_speed(kind.rig, kind.friction)), float(end_of_stick_slip(kind.rig, kind.friction).speed))
    means = meanings(found, force)
    speeds = {one.name: bool(one.low <= speed <= one.high) for one, speed in zip(means, true, strict=True)}
    return Coverage(parameters, speeds, bool(misfits(found, beside(found))))


def judged(twin: tuple[str, int]) -> Coverage:
    """Fit the twin of a kind and a seed, and see what its intervals hold."""
    name, seed = twin
    kind = kinds()[name]
    return covered(kind, fitted(kind, seed))


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Fit the twins, keep what is found of each, and write the page."""
    parser = Parser(prog="python -m benchmarks.calibration", description=__doc__)
    add = parser.add_argument
    add("--twins", type=of_kind(COUNT), default=TWINS, metavar="N", help=f"of each kind (default: {TWINS})")
    add("--kinds", choices=kinds(), nargs="+", default=list(kinds()), help="which (default: all)")
    add("--output", type=of_kind(File()), default=PAGE, help="the page (default: docs/coverage.md)")
    add(
        "--results", type=of_kind(File()), default=RESULTS, help="what each twin gave (default: beside the page's data)"
    )
    add("--overwrite", action="store_true", help="begin anew, whatever the results file holds")
    jobs = available_threads()
    add_engine_arguments(parser, "twins", f"{jobs}, the cores")
    chosen = parser.parse_args(arguments)
    twins = [(name, _FIRST + k) for k in range(chosen.twins) for name in chosen.kinds]  # all kinds grow alike
    try:
        check_writable_file(chosen.results)
        results = Results.read(chosen.results, chosen.overwrite)
        engine = engine_of(chosen, jobs)
    except (ValueError, ImportError, OSError) as error:
        parser.error(str(error))
    missing = [twin for twin in twins if twin not in results.found]

    def report() -> None:
        write_text(chosen.output, page(results, twins))

    with kept(chosen.output, report), engine:
        for done, (number, found) in enumerate(engine.each(judged, missing), 1):
            results.add(missing[number], found)
            note(f"{done} of {len(missing)} twins")


if __name__ == "__main__":
    raise SystemExit(main())
