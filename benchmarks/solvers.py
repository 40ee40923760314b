"""One rig in stick-slip (20 N, 2 rad/s): error and seconds of the project and of every solver that a user could pick.

    python -m benchmarks.solvers
    python -m benchmarks.solvers --quick
    python -m benchmarks.solvers --only numbalsoda --only DrillRig --repeats 9

All solve the same 50 s, sampled every 0.1 s, in one process on one core. The error is the largest of the bit
speed over the first 20 s, against Radau with the kinks split by events (rtol 1e-11). Each solver has several
tolerances, for a line in a plot of error against seconds, and the form that was found to serve it best:
`benchmarks/peers` has a file for each library that says which. What a solver compiles before it runs is
timed apart; for the project that is its first call after an installation, in a process of its own. The
solvers are timed in turns, one timing each, so that what else the machine does for a while spoils no comparison.

A ratio of speeds compares one setting of the project with the fastest setting of the peers named whose
measured error is below the same limit.
"""

from __future__ import annotations

import statistics
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.case import ONE_RIG, START, largest_errors, sample_times
from benchmarks.measure import kept, note, print_table, seconds_of, timing, use_one_core, write_json
from benchmarks.peers import PEERS
from benchmarks.peers.peer import Peer, Run, Setting, asked_for, left_out
from benchmarks.peers.project import DEFAULT, LIBRARY, LOOSE, compile_seconds
from benchmarks.peers.scipy_solvers import CHAPTER
from drillrig_env import simulate
from drillrig_env.allowed import COUNT
from drillrig_env.arrays import FloatArray
from drillrig_env.command_line import Parser, command
from drillrig_env.flags import of_kind

DURATION, JUDGED = 50.0, 20.0  # s
Result = dict[str, Any]
COMPARISONS: dict[str, tuple[Setting, float, dict[str, str]]] = {
    "VODE in the chapter's form, error <= 1e-6": (DEFAULT, 1e-6, {"solver": CHAPTER.name}),
    "the fastest SciPy solver, error <= 1e-6": (DEFAULT, 1e-6, {"library": "SciPy"}),
    "numbalsoda's LSODA, error <= 1e-6": (DEFAULT, 1e-6, {"solver": "numbalsoda LSODA"}),
    "the fastest peer, error <= 1e-6": (DEFAULT, 1e-6, {}),
    "the fastest peer, error <= 1e-3": (LOOSE, 1e-3, {}),
}
"""The project's setting, the error (rad/s) within which the peers' fastest counts, and which peers."""


def prepared(peer: Peer, setting: Setting, reference: FloatArray) -> tuple[Result, Run | None]:
    """A solver at one setting with its error and compile time, and its warm run; none, with the reason, if it fails."""
    import_module(peer.package.module)
    result = peer.described(setting)
    runs: list[Run] = []
    try:
        compile_time = seconds_of(lambda: runs.append(peer.prepare(setting, sample_times(DURATION))))
        error = float(largest_errors(runs[0](), reference))
    except Exception as failure:  # whatever a solver raises where it gives up
        return {**result, "failure": f"{type(failure).__name__}: {failure}"}, None
    return {**result, "error_rad_s": error, "compile_s": compile_time, "timings_s": []}, runs[0]


def time_once(result: Result, run: Run) -> None:
    """Time a solver once more, and renew what follows from the median."""
    result["timings_s"].append(timing(run))
    result["seconds_for_50_s"] = statistics.median(result["timings_s"])
    result["simulated_s_per_s"] = DURATION / result["seconds_for_50_s"]


def fastest(results: list[Result], limit: float, solver: str = "", library: str = "") -> Result | None:
    """The fastest result of a peer with an error below `limit` (rad/s), of one solver or library if named."""
    good = [
        result
        for result in results
        if "simulated_s_per_s" in result
        and result["library"] != LIBRARY.name
        and result["error_rad_s"] <= limit
        and solver in result["solver"]
        and library in result["library"]
    ]
    return max(good, key=lambda result: float(result["simulated_s_per_s"]), default=None)


def ratios(results: list[Result]) -> dict[str, Result]:
    """How many times faster the project is, by what it is compared with."""
    found = {}
    for name, (setting, limit, peers) in COMPARISONS.items():
        rival = fastest(results, limit, **peers)
        for own in results:
            if rival and own["library"] == LIBRARY.name and own["rtol"] == setting.rtol and "simulated_s_per_s" in own:
                found[name] = {
                    "ratio": own["simulated_s_per_s"] / rival["simulated_s_per_s"],
                    "project_setting": own["setting"],
                    "project_error_rad_s": own["error_rad_s"],
                    "peer": rival["solver"],
                    "peer_setting": rival["setting"],
                    "peer_error_rad_s": rival["error_rad_s"],
                }
    return found


def accuracy() -> float:
    """Largest error of any speed at the default setting over the stored reference runs of the tests, rad/s."""
    from tests.reference import arguments, stored

    return max(
        float(np.abs(simulate(sample_period=0.1, **arguments(*case)).state[:, 2:5] - speeds).max())
        for case, speeds in stored().items()
    )


def report(results: list[Result], found: dict[str, Result]) -> None:
    """Print both tables."""
    print_table(
        ["solver", "setting", "error, rad/s", "seconds for 50 s", "simulated s a second", "compiled in, s"],
        [
            [
                r["solver"],
                r["setting"],
                f"{r['error_rad_s']:.1e}",
                f"{r['seconds_for_50_s']:.2g}",
                f"{r['simulated_s_per_s']:,.0f}",
                f"{r['compile_s']:.1f}",
            ]
            if "seconds_for_50_s" in r
            else [r["solver"], r["setting"], r.get("failure", "not timed"), "-", "-", "-"]
            for r in results
        ],
    )
    if found:
        print()
        print_table(
            ["faster than", "by", "DrillRig", "its error, rad/s", "peer", "its error, rad/s"],
            [
                [
                    name,
                    f"{r['ratio']:,.1f} x",
                    r["project_setting"],
                    f"{r['project_error_rad_s']:.1e}",
                    f"{r['peer']}, {r['peer_setting']}",
                    f"{r['peer_error_rad_s']:.1e}",
                ]
                for name, r in found.items()
            ],
        )


def chosen(only: list[str], quick: bool) -> list[tuple[Peer, Setting]]:
    """Peers that are installed, with the settings that they are given."""
    runs = []
    for peer in asked_for(PEERS, only):
        settings = peer.settings[1 :: max(1, len(peer.settings) // 2)] if quick else peer.settings
        runs += [(peer, setting) for setting in settings or peer.settings]
    return runs


@command
def main() -> None:
    """Measure all solvers and print the tables."""
    parser = Parser(prog="python -m benchmarks.solvers", description=__doc__)
    parser.add_argument(
        "--repeats", type=of_kind(COUNT), default=5, help="timings of which the median counts (default: 5)"
    )
    parser.add_argument("--quick", action="store_true", help="a first look: few settings, 2 repeats, about a minute")
    parser.add_argument("--only", action="append", default=[], metavar="NAME", help="only solvers with NAME in theirs")
    parser.add_argument(
        "--json", type=Path, default=Path("results/benchmarks/solvers.json"), help="where to write the figures"
    )
    arguments = parser.parse_args()
    repeats = 2 if arguments.quick else arguments.repeats
    try:
        wanted = chosen(arguments.only, arguments.quick)
    except ValueError as error:
        parser.error(error)
    use_one_core()
    missing = left_out(PEERS)
    for hint in missing:
        note(hint)
    reference = ONE_RIG.bit_speeds(sample_times(JUDGED))[0]
    results: list[Result] = []
    outcome: Result = {
        "case": {
            "normal_force_N": float(ONE_RIG.normal_force[0]),
            "speed_reference_rad_s": float(ONE_RIG.speed_reference[0]),
            "start": START.tolist(),
            "duration_s": DURATION,
            "error_over_s": JUDGED,
        },
        "quick": arguments.quick,
        "repeats": repeats,
        "left_out": missing,
        "solvers": results,
    }
    runs: list[tuple[Result, Run]] = []

    def tell() -> None:
        report(results, outcome.get("faster_than", {}))
        if "project_first_call_s" in outcome:
            worst = f"{outcome['largest_error_of_stored_runs_rad_s']:.1e} rad/s"
            print(f"\nlargest error of any speed over the 30 stored runs (2 to 40 N, 0.3 to 9 rad/s): {worst}")
            print(f"first call after an installation, which compiles: {outcome['project_first_call_s']:.1f} s")
        write_json(arguments.json, outcome)

    with kept(arguments.json, tell):
        for number, (peer, setting) in enumerate(wanted, 1):
            note(f"[{number}/{len(wanted)}] {peer.name}, {setting.label}: compilation and error")
            result, run = prepared(peer, setting, reference)
            results.append(result)
            runs += [(result, run)] if run else []
            write_json(arguments.json, outcome, announce=False)
        for turn in range(1, repeats + 1):
            note(f"[{turn}/{repeats}] timing of all")
            for result, run in runs:
                time_once(result, run)
            outcome["faster_than"] = ratios(results)
            write_json(arguments.json, outcome, announce=False)
        note("accuracy over the stored runs, and the first call after an installation")
        outcome["largest_error_of_stored_runs_rad_s"] = accuracy()
        outcome["project_first_call_s"] = compile_seconds()


if __name__ == "__main__":
    raise SystemExit(main())
