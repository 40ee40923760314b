"""Tune a baseline on training seeds: a small search over its gains for the share of rigs that it mitigates.

python -m baselines.tune z_torque                              # on the sensors `state`
python -m baselines.tune z_torque --sensors surface            # gains for other sensors
python -m baselines.tune z_torque --sensors state surface      # one set for both: the mean over them counts
python -m baselines.tune z_torque --suites default             # starts in stick-slip alone, no load steps

The search is SciPy's differential evolution over the bounds in the class's `tuned`, with a fixed
seed; the values that the class has are among the first tries. A try is a run over draws of the suites
`default` (free the rig) and `load` (keep it out) with seeds that no suite uses; its worth is the share
mitigated less a tenth of the mean cost, the mean over suites and sensors. The values found, rounded,
are run again on fresh training seeds, printed, and written to tuned.json: they are the class's
`tuned_values`.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from scipy.optimize import Bounds, differential_evolution

from baselines import BASELINES, Baseline, make
from baselines.tuned import RECORD
from drillrig_env.env.sensors import SENSORS
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import Suite, suite
from drillrig_env.parameters import closest, refuse
from drillrig_env.seeds import TUNING_SEEDS

_POPULATION = 6  # tries a generation, for each gain
_COST = 0.1  # weight of the mean cost beside the share mitigated: orders what mitigates alike


def tuning_suite(name: str, rigs: int, first_seed: int = TUNING_SEEDS.start) -> Suite:
    """Draws as in the suite of that name, of rigs for tuning. `ValueError` where they are others'."""
    last = TUNING_SEEDS.stop - rigs
    if not TUNING_SEEDS.start <= first_seed <= last:
        raise refuse("tune", "first seed", first_seed, "", f"{TUNING_SEEDS.start} to {last}, which are for tuning")
    return replace(suite(name, rigs), first_seed=first_seed)


def measure(controller: str, values: Mapping[str, float], sensors: str, chosen: Suite) -> dict[str, float]:
    """Shares mitigated (all, below and above omega_c) and mean cost of a baseline with these values."""
    policy = make(controller, sensors=sensors, **values)
    scores = score(run(policy, chosen, sensors=sensors, threads=1))
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
) -> dict[str, float]:
    """The best values of the class's `tuned` arguments in about `budget` tries, to three digits.

    The search begins around `starting_point`. `progress` is called after each try with the best worth
    so far. `ValueError` for a controller that is not known or has nothing to tune.
    """
    bounds = _tunable(controller).tuned
    low, high = zip(*bounds.values(), strict=True)
    known = starting_point(controller, sensors)
    start = np.clip([known[name] for name in bounds], low, high) if known else None
    best = -np.inf

    def loss(values: np.ndarray) -> float:
        nonlocal best
        given = dict(zip(bounds, map(float, values), strict=True))
        found = [measure(controller, given, name, chosen) for name in sensors for chosen in suites]
        worth = float(np.mean([entry["mitigated"] - _COST * entry["cost"] for entry in found]))
        best = max(best, worth)
        if progress:
            progress(best)
        return -worth

    generations = max(budget // (_POPULATION * len(bounds)) - 1, 0)
    result = differential_evolution(
        loss, Bounds(low, high), maxiter=generations, popsize=_POPULATION, rng=seed, tol=0.0, polish=False, x0=start
    )
    return {name: float(f"{value:.3g}") for name, value in zip(bounds, result.x, strict=True)}


def starting_point(controller: str, sensors: Sequence[str]) -> dict[str, float]:
    """The values that the class has for the first of these sensors; empty where it has none."""
    return dict(_tunable(controller).tuned_values.get(sensors[0], {}))


def _tunable(controller: str) -> type[Baseline]:
    able = [name for name, kind in BASELINES.items() if kind.tuned]
    if controller not in able:
        raise ValueError(f"tune: controller {controller!r} has no gains to tune; {closest(controller, able)}")
    return BASELINES[controller]


def keep(record: Path, entry: dict[str, Any]) -> None:
    """Append an entry to the record, in place of an earlier one of the same controller and sensors."""
    entries = json.loads(record.read_text(encoding="utf-8")) if record.exists() else []
    same = (entry["controller"], entry["sensors"])
    entries = [old for old in entries if (old["controller"], old["sensors"]) != same]
    record.write_text(json.dumps([*entries, entry], indent=2) + "\n", encoding="utf-8")


def main() -> None:
    """Parse the command line, search, check on fresh rigs, print and keep."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("controller", help="name of the baseline")
    parser.add_argument("--sensors", nargs="+", choices=list(SENSORS), default=["state"], help="default: state")
    parser.add_argument(
        "--suites",
        nargs="+",
        choices=["default", "wide", "load", "degraded"],
        default=["default", "load"],
        help="default: default load",
    )
    parser.add_argument("--rigs", type=int, default=150, help="rigs of each suite in a try (default: 150)")
    parser.add_argument("--budget", type=int, default=240, help="tries, about (default: 240)")
    parser.add_argument("--seed", type=int, default=0, help="of the search (default: 0)")
    parser.add_argument("--first-seed", type=int, default=TUNING_SEEDS.start, help="of the rigs (default: %(default)s)")
    parser.add_argument(
        "--check", type=int, default=1000, help="fresh rigs of each suite for the check (default: 1000)"
    )
    parser.add_argument("--output", type=Path, default=RECORD, help=f"the record (default: {RECORD.name} beside this)")
    arguments = parser.parse_args()
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    try:
        _tunable(arguments.controller)
        chosen = [tuning_suite(name, arguments.rigs, arguments.first_seed) for name in arguments.suites]
        fresh = [
            tuning_suite(name, arguments.check, arguments.first_seed + arguments.rigs) for name in arguments.suites
        ]
    except ValueError as error:
        parser.error(str(error))
    with Progress(*columns) as bar:
        task = bar.add_task(arguments.controller, total=arguments.budget)

        def show(best: float) -> None:
            bar.update(task, advance=1, description=f"{arguments.controller}: best {best:.4f}")

        values = search(arguments.controller, arguments.sensors, chosen, arguments.budget, arguments.seed, show)
    checked = {
        name: {faced.name: measure(arguments.controller, values, name, faced) for faced in fresh}
        for name in arguments.sensors
    }
    entry = {
        "controller": arguments.controller,
        "sensors": arguments.sensors,
        "suites": arguments.suites,
        "start": starting_point(arguments.controller, arguments.sensors),
        "values": values,
        "checked": checked,
        "rigs": arguments.rigs,
        "fresh_rigs": arguments.check,
        "first_seed": arguments.first_seed,
        "seed": arguments.seed,
        "budget": arguments.budget,
        **{key: value for key, value in provenance().items() if key != "machine"},
    }
    keep(arguments.output, entry)
    Console().print_json(data=entry)


if __name__ == "__main__":
    main()
