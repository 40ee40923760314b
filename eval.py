"""Compare policies on the same random rigs: a table in the terminal, results.csv and pictures.

python eval.py                                        # the baselines on both suites
python eval.py constant jump_ease runs/ppo_1          # and a trained agent, by its run folder
python eval.py jump_ease --suite default --rigs 200 --output results/quick
"""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

import baselines
from agents.run_folder import is_run, load_policy
from drillrig_env.evaluation.pictures import plot_histories, plot_map
from drillrig_env.evaluation.report import print_table, write_csv, write_json
from drillrig_env.evaluation.runner import Episodes, Policy, run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import SUITES, Suite, suite
from drillrig_env.parameters import closest


def main() -> None:
    """Parse the command line, run every policy over every suite, and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "policies",
        nargs="*",
        default=list(baselines.BASELINES),
        help=f"baselines by name ({', '.join(baselines.BASELINES)}) and trained runs by folder; default: all baselines",
    )
    parser.add_argument("--suite", nargs="+", choices=list(SUITES), default=list(SUITES), help="default: all suites")
    parser.add_argument("--rigs", type=int, default=1000, help="random rigs in the suite `default` (default: 1000)")
    parser.add_argument(
        "--output", type=Path, default=Path("results"), help="folder for the results (default: results)"
    )
    arguments = parser.parse_args()
    try:
        policies = {label(name, arguments.policies): find_policy(name) for name in arguments.policies}
        suites = [suite(name, arguments.rigs) for name in arguments.suite]
    except (ValueError, OSError) as error:
        parser.error(str(error))
    arguments.output.mkdir(parents=True, exist_ok=True)
    told = {name: bool(getattr(policy, "told", ())) for name, policy in policies.items()}
    results: dict[str, dict[str, Any]] = {}
    for chosen in suites:
        runs = run_all(policies, chosen)
        results[chosen.name] = {name: score(episodes) for name, episodes in runs.items()}
        print_table(f"{chosen.name}: {chosen.description} ({chosen.rigs} rigs)", results[chosen.name], told)
        rig = typical_rig(results[chosen.name])
        plot_histories(runs, rig, arguments.output / f"histories_{chosen.name}.png")
        plot_map(results[chosen.name], next(iter(runs.values())).rig, arguments.output / f"map_{chosen.name}.png")
    write_csv(arguments.output / "results.csv", results)
    config = {"policies": arguments.policies, "suites": arguments.suite, "rigs": arguments.rigs}
    write_json(arguments.output / "results.json", config, results)
    print(f"results.csv, results.json and pictures: {arguments.output.resolve()}")


def label(name: str, others: list[str]) -> str:
    """The name in the table: the last part of a run's path, or all of it where two end alike."""
    last = Path(name).name
    return last if [Path(other).name for other in others].count(last) == 1 else name


def find_policy(name: str) -> Policy:
    """A baseline by name or a trained run by its folder. `ValueError` where it is neither."""
    if name in baselines.BASELINES:
        return baselines.make(name)
    if is_run(name):
        return load_policy(name)
    raise ValueError(
        f"policy {name!r} is neither a baseline nor the folder of a run; {closest(name, baselines.BASELINES)}"
    )


def run_all(policies: dict[str, Policy], chosen: Suite) -> dict[str, Episodes]:
    """Every policy over a suite, with a progress bar."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns) as progress:
        runs = {}
        for name, policy in policies.items():
            task = progress.add_task(f"{chosen.name}: {name}")
            runs[name] = run(policy, chosen, progress=partial(_show, progress, task))
    return runs


def _show(progress: Progress, task: TaskID, done: int, of: int) -> None:
    progress.update(task, completed=done, total=of)


def typical_rig(results: dict[str, Any]) -> int:
    """The rig to picture: one just above its critical speed on which the policies differ, if there is one."""
    scores = next(iter(results.values()))
    outcomes = np.stack([policy["mitigated"] for policy in results.values()])
    differ = outcomes.any(axis=0) & ~outcomes.all(axis=0)
    distance = np.abs(scores["speed_target"] / np.maximum(scores["critical_speed"], 1e-9) - 1.15)
    return int(np.argmin(np.where(differ, distance, distance + 1e6)))


if __name__ == "__main__":
    main()
