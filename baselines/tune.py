"""Tune a baseline on training seeds: a small search over its gains for the share of rigs that it mitigates.

python -m baselines.tune z_torque                              # on the sensors `state`
python -m baselines.tune z_torque --sensors surface            # gains for other sensors
python -m baselines.tune z_torque --sensors state surface      # one set for both: the mean over them counts
python -m baselines.tune z_torque --suites default             # starts in stick-slip alone, no load steps

The search is SciPy's differential evolution over the bounds in the class's `tuned`, with a fixed
seed; the values that the class has are among the first tries. A try is a run over draws of the suites
`default` (free the rig) and `load` (keep it out) with seeds that no suite uses; its worth is the share
mitigated less a tenth of the mean cost, the mean over suites and sensors. The values found, rounded,
are run again on fresh training seeds, printed, and written to tuned.json in the working folder. Written to
baselines/tuned.json (--output), they are the class's `tuned_values`. Tries are kept as they are made: a
search that was stopped goes on with --resume, to the same end.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from scipy.optimize import Bounds, differential_evolution

from baselines import BASELINES, Baseline
from baselines.for_fleets import OF_FLEETS
from baselines.tries import Tries
from baselines.tuned import RECORD
from drillrig_env.allowed import COUNT, Allowed
from drillrig_env.command_line import Parser, command
from drillrig_env.env.sensors import SENSORS
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import Suite, suite
from drillrig_env.files import check_writable_file, write_text
from drillrig_env.flags import of_kind
from drillrig_env.parameters import closest, refuse
from drillrig_env.seeds import TUNING_FLEETS, TUNING_SEEDS

COMMAND = "python -m baselines.tune"
_SEEDS = Allowed(TUNING_SEEDS.start, TUNING_SEEDS[-1], whole=True)
_SUITES = ("default", "wide", "load", "degraded", "unknown", "unknown_hard", "drift")
_CONTROLLERS = BASELINES | OF_FLEETS
_LINE = 20  # tries between two lines where the output is no terminal
_POPULATION = 6  # tries a generation, for each gain
_COST = 0.1  # weight of the mean cost beside the share mitigated: orders what mitigates alike


def tuning_suite(name: str, rigs: int, first_seed: int = TUNING_SEEDS.start) -> Suite:
    """Draws as in the suite of that name, of rigs for tuning. `ValueError` where they are others'."""
    last = TUNING_SEEDS.stop - rigs
    if not TUNING_SEEDS.start <= first_seed <= last:
        raise refuse("tune", "first seed", first_seed, "", f"{TUNING_SEEDS.start} to {last}, which are for tuning")
    chosen = replace(suite(name, rigs), first_seed=first_seed)
    fleet = chosen.scenario.rigs
    if fleet is None:
        return chosen
    seed = TUNING_FLEETS[(first_seed - TUNING_SEEDS.start) % len(TUNING_FLEETS)]
    return replace(chosen, scenario=replace(chosen.scenario, rigs=replace(fleet, seed=seed)))


def scores_of(
    controller: str, values: Mapping[str, float], sensors: str, chosen: Suite
) -> dict[str, npt.NDArray[np.generic]]:
    """Every score of a baseline with these values, an entry a rig of the suite."""
    kind: Any = _CONTROLLERS[controller]
    return score(run(kind(sensors, **values), chosen, sensors=sensors, threads=1))


def measure(controller: str, values: Mapping[str, float], sensors: str, chosen: Suite) -> dict[str, float]:
    """Shares mitigated (all, below and above omega_c) and mean cost of a baseline with these values."""
    scores = scores_of(controller, values, sensors, chosen)
    mitigated, below = scores["mitigated"], scores["region"] == "below"
    return {
        "mitigated": round(float(mitigated.mean()), 4),
        "below": round(float(mitigated[below].mean()), 4) if below.any() else float("nan"),
        "above": round(float(mitigated[~below].mean()), 4) if (~below).any() else float("nan"),
        "cost": round(float(scores["cost"].mean()), 4),
    }


def search(
    controller: str,
    sensors: Sequence[str],
    suites: Sequence[Suite],
    budget: int,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    tries: Tries | None = None,
) -> dict[str, float]:
    """The best values of the class's `tuned` arguments in about `budget` tries, to three digits.

    The search begins around `starting_point`. `progress` is called after each try with the best worth
    so far. `tries` keeps them, and answers those that it holds already. `ValueError` for a controller that is not
    known or has nothing to tune, and for a `budget` below 1.
    """
    if budget < 1:
        raise refuse("tune", "budget", budget, "tries", ">= 1")
    kept = Tries() if tries is None else tries
    bounds = _tunable(controller).tuned
    low, high = zip(*bounds.values(), strict=True)
    known = starting_point(controller, sensors)
    start = np.clip([known[name] for name in bounds], low, high) if known else None
    best = -np.inf

    def loss(values: np.ndarray) -> float:
        nonlocal best
        given = dict(zip(bounds, map(float, values), strict=True))
        worth = kept.worth(list(given.values()), lambda: _worth(controller, given, sensors, suites))
        best = max(best, worth)
        if progress:
            progress(best)
        return -worth

    generations = max(budget // (_POPULATION * len(bounds)) - 1, 0)
    result = differential_evolution(
        loss, Bounds(low, high), maxiter=generations, popsize=_POPULATION, rng=seed, tol=0.0, polish=False, x0=start
    )
    return {name: float(f"{value:.3g}") for name, value in zip(bounds, result.x, strict=True)}


def _worth(controller: str, values: Mapping[str, float], sensors: Sequence[str], suites: Sequence[Suite]) -> float:
    """The share mitigated less a tenth of the mean cost, the mean over suites and sensors."""
    found = [measure(controller, values, name, chosen) for name in sensors for chosen in suites]
    return float(np.mean([entry["mitigated"] - _COST * entry["cost"] for entry in found]))


def starting_point(controller: str, sensors: Sequence[str]) -> dict[str, float]:
    """The values that the class has for the first of these sensors; empty where it has none."""
    return dict(_tunable(controller).tuned_values.get(sensors[0], {}))


def _tunable(controller: str) -> type[Baseline]:
    able = [name for name, kind in _CONTROLLERS.items() if kind.tuned]
    if controller not in able:
        raise ValueError(f"tune: controller {controller!r} has no gains to tune; {closest(controller, able)}")
    return _CONTROLLERS[controller]


def read_record(record: Path) -> list[dict[str, Any]]:
    """The entries of a record; none where there is no such file. `ValueError` where it is damaged."""
    if not record.exists():
        return []
    try:
        entries = json.loads(record.read_text(encoding="utf-8"))
        return [{**entry, "controller": entry["controller"], "sensors": entry["sensors"]} for entry in entries]
    except (ValueError, TypeError, KeyError) as error:
        raise ValueError(f"{record} is no record of tuning ({error}); choose another --output") from error


def keep(record: Path, entry: dict[str, Any]) -> None:
    """Append an entry to the record, in place of an earlier one of the same controller and sensors."""
    same = (entry["controller"], entry["sensors"])
    entries = [old for old in read_record(record) if (old["controller"], old["sensors"]) != same]
    write_text(record, json.dumps([*entries, entry], indent=2) + "\n")


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Parse the command line, search, check on fresh rigs, print and keep."""
    parser = _parser()
    chosen = parser.parse_args(arguments)
    output: Path = chosen.output
    settings = {
        name: getattr(chosen, name)
        for name in ("controller", "sensors", "suites", "rigs", "first_seed", "seed", "budget")
    }
    try:
        start = starting_point(chosen.controller, chosen.sensors)
        suites = [tuning_suite(name, chosen.rigs, chosen.first_seed) for name in chosen.suites]
        fresh = [tuning_suite(name, chosen.check, chosen.first_seed + chosen.rigs) for name in chosen.suites]
        read_record(output)
        tries = Tries(output.with_suffix(".tries.json"), {**settings, "start": start}, chosen.resume)
    except ValueError as error:
        parser.error(error)
    check_writable_file(output)
    try:
        with _Shown(chosen.controller, chosen.budget) as shown:
            values = search(chosen.controller, chosen.sensors, suites, chosen.budget, chosen.seed, shown.tell, tries)
        checked = {
            name: {faced.name: measure(chosen.controller, values, name, faced) for faced in fresh}
            for name in chosen.sensors
        }
    except KeyboardInterrupt as stop:
        stop.add_note(f"{tries.path} keeps {len(tries)} of about {chosen.budget} tries; to go on, add --resume")
        raise
    entry = {
        "controller": chosen.controller,
        "sensors": chosen.sensors,
        "suites": chosen.suites,
        "start": start,
        "values": values,
        "checked": checked,
        "rigs": chosen.rigs,
        "fresh_rigs": chosen.check,
        "first_seed": chosen.first_seed,
        "seed": chosen.seed,
        "budget": chosen.budget,
        **{key: value for key, value in provenance().items() if key != "machine"},
    }
    keep(output, entry)
    tries.forget()
    Console().print_json(data=entry)
    print(f"kept in {output.resolve()}")


def _parser() -> Parser:
    parser = Parser(prog=COMMAND, description=__doc__)
    add, count = parser.add_argument, of_kind(COUNT)
    add("controller", help="name of the baseline")
    add("--sensors", nargs="+", choices=list(SENSORS), default=["state"], help="default: state")
    add("--suites", nargs="+", choices=_SUITES, default=["default", "load"], help="default: default load")
    add(
        "--rigs",
        type=count,
        default=150,
        help="rigs of each suite in a try (default: 150; of a fleet with 16 draws each)",
    )
    add("--budget", type=count, default=240, help="tries, about (default: 240)")
    add("--seed", type=of_kind(Allowed(low=0, whole=True)), default=0, help="of the search (default: 0)")
    add("--first-seed", type=of_kind(_SEEDS), default=TUNING_SEEDS.start, help="of the rigs (default: %(default)s)")
    add("--check", type=count, default=1000, help="fresh rigs of each suite for the check (default: 1000)")
    add("--output", type=Path, default=Path(RECORD.name), help="the record (default: %(default)s in this folder)")
    add("--resume", action="store_true", help="go on with a search that was stopped, given the same arguments")
    return parser


class _Shown:
    """How far a search is: a bar in a terminal, lines elsewhere."""

    def __init__(self, controller: str, budget: int) -> None:
        self.controller, self.budget, self.tries = controller, budget, 0
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        self.bar = Progress(*columns)
        self.lines = not self.bar.console.is_terminal
        self.task = self.bar.add_task(controller, total=budget, visible=not self.lines)

    def __enter__(self) -> _Shown:
        self.bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.bar.stop()

    def tell(self, best: float) -> None:
        """Tell that one more try is done, and the best worth so far."""
        self.tries += 1
        self.bar.update(self.task, advance=1, description=f"{self.controller}: best {best:.4f}")
        if self.lines and self.tries % _LINE == 0:
            print(f"{self.controller}: {self.tries} of about {self.budget} tries, best {best:.4f}", flush=True)


if __name__ == "__main__":
    raise SystemExit(main())
