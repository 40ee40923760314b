"""Rigs of all kinds, drawn at random: the largest error of the fast stepper against an independent solution.

    python -m benchmarks.any_rig
    python -m benchmarks.any_rig --rigs 200 --seed 5 --period 0.5
    python -m benchmarks.any_rig --only 17
    python -m benchmarks.any_rig --rigs 100000 --on ray

Every parameter of the rig and of its friction is the chapter's times 1/10 to 10, each on its own and evenly on a scale
of logarithms; the normal force is 0 to 200 N, v_b 0.05 to 50 s/rad, the speed reference 0.1 to 50 rad/s, and a run
takes 10 s, every other one from rest and the rest from discs that turn. The reference is Radau IIA of order 9 with the
kinks found to rounding (`benchmarks/radau9.py`), at two tolerances: a rig is judged where they agree to 1e-7. What
is shown is the largest error of any speed over the run, as a share of the rig's speed scale: its own unit of
speed, or a tenth of the largest speed of the run where that is more.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from math import log
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import kept, print_table, write_json
from benchmarks.radau9 import solve
from drillrig_env import Friction, Rig, simulate
from drillrig_env.allowed import COUNT, POSITIVE, Allowed
from drillrig_env.arrays import FloatArray
from drillrig_env.command_line import Parser, command
from drillrig_env.engine import Engine, used
from drillrig_env.files import read_json
from drillrig_env.flags import add_engine_arguments, engine_of, of_kind
from drillrig_env.model import frictionless_state
from drillrig_env.progress import Progress
from drillrig_env.stepper.units import units_of

RIGS, DURATION, SAMPLE = 1000, 10.0, 0.5  # s
TOLERANCES, AGREED, LIMIT = (1e-10, 1e-11), 1e-7, 1e-6
FACTOR, HEAVIEST, DECAY, REFERENCE = 10.0, 200.0, (0.05, 50.0), (0.1, 50.0)  # N, s/rad, rad/s
_FIXED = ("T_r2", "C_1", "C_2")  # 0 in the chapter
_IN_A_ROW = tuple(item.name for item in fields(Rig) if not item.metadata["optional"])
_NUMBER = Allowed(low=0, whole=True)


@dataclass(frozen=True)
class Case:
    """One run: a rig, its friction, where it begins and its speed reference (rad/s)."""

    rig: Rig
    friction: Friction
    state: tuple[float, ...]
    speed_reference: float

    def numbers(self) -> list[float]:
        """All of it as a row of numbers."""
        return [
            *(getattr(self.rig, name) for name in _IN_A_ROW),
            *self.friction.as_array()[0].tolist(),
            *self.state,
            self.speed_reference,
        ]

    @classmethod
    def of(cls, numbers: Sequence[float]) -> Case:
        """The run that a row of `numbers` stands for."""
        own = len(_IN_A_ROW)
        row = [float(number) for number in numbers]
        return cls(Rig(*row[:own]), Friction(*row[own : own + 4]), tuple(row[own + 4 : -1]), row[-1])


def draw(count: int, seed: int) -> list[Case]:
    """Runs drawn at random, the same for the same seed."""
    rng = np.random.default_rng(seed)
    names = [item.name for item in fields(Rig) if item.name not in _FIXED]
    cases = []
    for number in range(count):
        factors = FACTOR ** rng.uniform(-1.0, 1.0, len(names))
        rig = Rig(**{name: getattr(Rig(), name) * float(u) for name, u in zip(names, factors, strict=True)})
        kinetic, fall = FACTOR ** rng.uniform(-1.0, 1.0, 2) * [0.306, 0.194]
        v_b, speed = (float(np.exp(rng.uniform(log(low), log(high)))) for low, high in (DECAY, REFERENCE))
        friction = Friction(float(rng.uniform(0.0, HEAVIEST)), float(kinetic + fall), float(kinetic), v_b)
        turning = (0.0, 0.0, speed, speed, speed, 0.5, 0.0)
        start = tuple(frictionless_state(rig, 0.0).tolist()) if number % 2 else turning
        cases.append(Case(rig, friction, start, speed))
    return cases


def reference(case: Case) -> FloatArray | None:
    """Speeds every `SAMPLE` s, shape (21, 3); None where the reference does not agree with itself or gives up."""
    try:
        rough, fine = (
            solve(
                case.rig,
                case.friction,
                np.array(case.state),
                case.speed_reference,
                SAMPLE,
                round(DURATION / SAMPLE),
                tolerance,
            )[:, 2:5]
            for tolerance in TOLERANCES
        )
    except ArithmeticError:
        return None
    return fine if np.abs(rough - fine).max() <= AGREED * speed_scale(case, fine) else None


def speed_scale(case: Case, speeds: FloatArray) -> float:
    """What errors are shares of, rad/s."""
    return max(units_of(case.rig).speed, 0.1 * float(np.abs(speeds).max()))


def error_of(case: Case, speeds: FloatArray, period: float) -> float:
    """Largest error of any speed of `simulate`, sampled every `period` (s), as a share of the speed scale.

    Raises what `simulate` raises.
    """
    run = simulate(case.rig, case.friction, case.state, case.speed_reference, DURATION, period)
    found = run.state[:: round(SAMPLE / period), 2:5]
    return float(np.abs(found - speeds).max() / speed_scale(case, speeds))


def outcome_of(period: float, piece: tuple[int, Case]) -> dict[str, Any]:
    """What comes of a run: its number, and its error, the error that was raised, or neither."""
    number, case = piece
    speeds = reference(case)
    outcome: dict[str, Any] = {"rig": number}
    if speeds is not None:
        try:
            outcome["error"] = error_of(case, speeds, period)
        except (ValueError, ArithmeticError) as refusal:
            outcome["refusal"] = str(refusal)
    return outcome


def outcomes(
    cases: Mapping[int, Case], period: float, progress: Progress, engine: Engine | None = None
) -> Iterator[dict[str, Any]]:
    """What comes of the runs, as they are done."""
    with used(engine) as at:
        for done, (_, outcome) in enumerate(at.each(partial(outcome_of, period), list(cases.items())), 1):
            yield outcome
            progress.show("rigs", done, len(cases))


def tabulate(results: Sequence[dict[str, Any]], cases: Mapping[int, Case]) -> None:
    """Print how many rigs are within the limit, and the worst of them."""
    errors = sorted((result["error"], result["rig"]) for result in results if "error" in result)
    refused = [result for result in results if "refusal" in result]
    judged = len(errors) + len(refused)
    above = sum(error > LIMIT for error, _ in errors)
    rows = [("rigs", f"{len(results):,}"), ("judged", f"{judged:,}"), ("refused with an error", f"{len(refused):,}")]
    rows.append((f"above {LIMIT:g} and not refused", f"{above:,}"))
    if errors:
        for name, share in (("median", 0.5), ("99 %", 0.99), ("largest", 1.0)):
            rows.append((f"error, {name}", f"{np.quantile([error for error, _ in errors], share):.1e}"))
    print_table(["Any rig", "of the speed scale"], rows)
    for error, number in errors[-1:]:
        case = cases[number]
        print(f"\nlargest: {error:.1e}, rig {number} at {case.speed_reference:g} rad/s\n{case.rig}\n{case.friction}")
    for result in refused:
        print(f"\nrefused: rig {result['rig']}: {result['refusal']}\n{cases[result['rig']].rig}")


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Solve all rigs, print the table and write the figures."""
    parser = Parser(prog="python -m benchmarks.any_rig", description=__doc__)
    add = parser.add_argument
    add("--rigs", type=of_kind(COUNT), default=RIGS, help=f"how many (default: {RIGS})")
    add("--seed", type=of_kind(_NUMBER), default=0, help="which ones (default: 0)")
    add("--period", type=of_kind(POSITIVE), default=0.1, help=f"sample period in s, a part of {SAMPLE} (default: 0.1)")
    add("--only", type=of_kind(_NUMBER), help="the number of one rig alone")
    add(
        "--resume",
        action="store_true",
        help="go on with the figures of a run that was stopped, given the same arguments",
    )
    add_engine_arguments(parser, "rigs")
    add("--json", type=Path, help="where to write the figures (default: results/benchmarks/any_rig.json, or any_rig_N)")
    chosen = parser.parse_args(arguments)
    if (SAMPLE / chosen.period) % 1.0 != 0.0:
        parser.error(f"--period {chosen.period:g} s is not a part of {SAMPLE} s")
    cases = dict(enumerate(draw(chosen.rigs, chosen.seed)))
    if chosen.only is not None:
        if chosen.only not in cases:
            parser.error(f"--only {chosen.only}: the rigs are 0 to {chosen.rigs - 1}")
        cases = {chosen.only: cases[chosen.only]}
    name = "any_rig" if chosen.only is None else f"any_rig_{chosen.only}"
    file = chosen.json or Path(f"results/benchmarks/{name}.json")
    made = {"seed": chosen.seed, "period": chosen.period}
    try:
        engine = engine_of(chosen)
        results = _of_before(file, made) if chosen.resume else []
    except (ValueError, ImportError) as error:
        parser.error(str(error))
    done = {outcome["rig"] for outcome in results}
    left = {number: case for number, case in cases.items() if number not in done}

    def tell() -> None:
        results.sort(key=lambda one: one["rig"])
        tabulate(results, cases)
        write_json(file, {**made, "outcomes": results})

    with kept(file, tell), engine, Progress("any rig", parts=1) as progress:
        for outcome in outcomes(left, chosen.period, progress, engine):
            results.append(outcome)


def _of_before(file: Path, made: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The outcomes in a file; `ValueError` where there are none, or of other arguments."""
    if not file.is_file():
        raise ValueError(f"there is nothing to go on with: {file} is missing")
    earlier = read_json(file, "remove it").get("results", {})
    for name, value in made.items():
        if earlier.get(name) != value:
            raise ValueError(f"{file} is of {name} = {earlier.get(name)}, not {value}")
    found: list[dict[str, Any]] = earlier["outcomes"]
    return found


if __name__ == "__main__":
    raise SystemExit(main())
