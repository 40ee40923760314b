"""Stability analysis: seconds for critical speed, fold, diagram and map, and AUTO-07p's Hopf point and fold.

    python -m benchmarks.stability
    python -m benchmarks.stability --repeats 9 --map 100 --json results/stability.json

Everything but the map runs on one core; compilation, gfortran's too, is not counted. "A new rig"
includes what is found once a rig: its critical slope and its family of slipping orbits.

AUTO-07p continues the same model in Fortran (`benchmarks/auto.py`): its Hopf point, and the fold of the orbit p2.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.auto import FRICTION, HINT, LAWS, ONE_CORE, RIG, auto, is_installed
from benchmarks.measure import in_new_process, kept, median_seconds, note, print_table, write_json
from drillrig_env import Friction, Rig
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.flags import of_kind
from drillrig_env.jit.threads import available_threads
from drillrig_env.stability import bifurcation_diagram, critical_speed, fold_speed, hopf_and_fold_curves
from drillrig_env.stability.bifurcation import slipping_branch
from drillrig_env.stability.vibration_map import region_map, simulated_map

P2_POINTS = 31  # as many orbits as AUTO computes from the Hopf point to the fold
BRANCH = f"Hopf point, p2 with {P2_POINTS} orbits and fold, a new rig"
CLEAR = 0.03  # share of a border's speed within which a point of the map is not judged
REPEATS, QUICK_REPEATS = 5, 1
SIZE, QUICK_SIZE = 200, 40  # points along either side of the map


def analyses() -> dict[str, Callable[[], object]]:
    """The project's analyses by name."""
    draws = np.random.default_rng(0).uniform(size=(3, 1000))
    frictions = Friction(4.0 + 36.0 * draws[0], mu_s=0.4 + 0.2 * draws[1], v_b=0.7 + 0.6 * draws[2])
    forces = np.linspace(1.0, 40.0, 200)
    number = count(1)

    def new_rig() -> Rig:
        return Rig(J_1=RIG.J_1 * (1.0 + 1e-9 * next(number)))

    def branch_of_new_rig() -> object:
        rig = new_rig()
        return critical_speed(rig, FRICTION), fold_speed(rig, FRICTION), slipping_branch(rig, FRICTION, P2_POINTS)

    return {
        "critical speed": lambda: critical_speed(RIG, FRICTION),
        "critical speed, a new rig": lambda: critical_speed(new_rig(), FRICTION),
        "fold": lambda: fold_speed(RIG, FRICTION),
        "fold, a new rig": lambda: fold_speed(new_rig(), FRICTION),
        "fold of 1,000 frictions": lambda: fold_speed(RIG, frictions),
        "critical speed and fold over 200 normal forces": lambda: hopf_and_fold_curves(RIG, FRICTION, forces),
        BRANCH: branch_of_new_rig,
        "bifurcation diagram, 120 + 120 orbits": lambda: bifurcation_diagram(RIG, FRICTION, points=120),
    }


def analysis_seconds(name: str, repeats: int) -> float:
    """Median seconds of one analysis."""
    return median_seconds(analyses()[name], repeats)


def map_figures(size: int) -> dict[str, float]:
    """Seconds of the simulated map, and the share of its points away from the curves that agrees with them.

    The map has `size` points along either side; all cores work on it.
    """
    speeds, forces = np.linspace(0.8, 6.0, size), np.linspace(4.0, 40.0, size)
    simulated_map(RIG, FRICTION, speeds[:1], forces[:1])
    begin = time.perf_counter()
    found = simulated_map(RIG, FRICTION, speeds, forces)
    seconds = time.perf_counter() - begin
    curves = hopf_and_fold_curves(RIG, FRICTION, forces)
    borders = np.stack([curves["critical_speed"], curves["fold_speed"]])[:, :, None]
    clear = np.abs(speeds / borders - 1.0).min(axis=0) > CLEAR
    agrees = found.region == region_map(RIG, FRICTION, speeds, forces).region
    judged, agree = int(clear.sum()), float(agrees[clear].mean())
    return {"seconds": seconds, "points": size**2, "cores": available_threads(), "judged": judged, "agree": agree}


def measure(repeats: int, size: int) -> Iterator[tuple[str, str, Any]]:
    """Table, row and figures of one measurement after another."""
    os.environ.update(ONE_CORE)  # for the linear algebra of the processes to come
    seconds = {}
    for name in analyses():
        seconds[name] = in_new_process(analysis_seconds, name, repeats)
        yield "seconds", name, seconds[name]
    yield "hopf_to_fold", "DrillRig, (4-9), a new rig", own_hopf_to_fold(seconds[BRANCH])
    if is_installed():
        for name, law in LAWS.items():
            yield "hopf_to_fold", f"AUTO-07p, {name}", auto(law, repeats)
    else:
        note(HINT)
    for key, value in map_figures(size).items():
        yield "map", key, value
    note(f"{size} x {size} map")


def own_hopf_to_fold(seconds: float) -> dict[str, Any]:
    """What the project finds from the Hopf point to the fold."""
    found = {"hopf": critical_speed(RIG, FRICTION), "fold": fold_speed(RIG, FRICTION)}
    return {**found, "seconds": seconds, "remark": f"{P2_POINTS} orbits"}


def tabulate(results: dict[str, dict[str, Any]]) -> None:
    """Print all tables, as far as they have been measured."""
    print_table(["DrillRig, 10 N", "seconds"], [[name, f"{value:.2g}"] for name, value in results["seconds"].items()])
    print()
    columns = {"hopf": ".8f", "fold": ".6f", "seconds": ".2g"}
    print_table(
        ["Hopf point to fold, 10 N", "Hopf point, rad/s", "fold, rad/s", "seconds", "remark"],
        [
            [name, *(format(r[key], digits) if key in r else "-" for key, digits in columns.items()), r["remark"]]
            for name, r in results["hopf_to_fold"].items()
        ],
    )
    if vibration := results["map"]:
        print(f"\n{told(vibration)}")


def told(vibration: dict[str, Any]) -> str:
    """The map's figures in a sentence."""
    side = round(vibration["points"] ** 0.5)
    return (
        f"{side} x {side} map by simulation from both starts, all {vibration['cores']} cores: "
        f"{vibration['seconds']:.1f} s; {100 * vibration['agree']:.2f} % of the {vibration['judged']:,} points "
        f"more than {100 * CLEAR:.0f} % from the curves agree with them"
    )


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, write the figures after each of them, and print the tables."""
    parser = Parser(prog="python -m benchmarks.stability", description=__doc__)
    add = parser.add_argument
    add(
        "--repeats",
        type=of_kind(COUNT),
        help=f"timings, whose median counts (default: {REPEATS}; quick: {QUICK_REPEATS})",
    )
    add(
        "--map", type=of_kind(COUNT), help=f"points along either side of the map (default: {SIZE}; quick: {QUICK_SIZE})"
    )
    add("--quick", action="store_true", help="a first look: every analysis once, a small map")
    add("--json", type=Path, default=Path("results/benchmarks/stability.json"), help="where to write the figures")
    chosen = parser.parse_args(arguments)
    repeats = chosen.repeats or (QUICK_REPEATS if chosen.quick else REPEATS)
    size = chosen.map or (QUICK_SIZE if chosen.quick else SIZE)
    results: dict[str, dict[str, Any]] = {"seconds": {}, "hopf_to_fold": {}, "map": {}}

    def tell() -> None:
        tabulate(results)
        write_json(chosen.json, results)

    with kept(chosen.json, tell):
        for table, name, figures in measure(repeats, size):
            results[table][name] = figures
            if table != "map":
                note(name)
            write_json(chosen.json, results, announce=False)


if __name__ == "__main__":
    raise SystemExit(main())
