"""Choose the median seed of a training and put it into the package, with what all seeds scored.

    python train.py ppo --seeds 5 --run-folder runs/ppo
    python -m agents.shipping.ship runs/ppo --name ppo
    python -m agents.shipping.ship runs/ppo --name ppo --results results/ppo   # keep all episodes; goes on after Ctrl-C

All seeds face all suites. The median seed is that of median mitigated share in the suite `default`, or in that of the
rigs of its environment (`home_suite`), lower costs counting as better among equals (of an even number of
seeds, the worse of the middle two). Its config, model and evaluations go into agents/trained/NAME, beside the card
(`agents.shipping.card`), `seeds.json`, which holds every seed's scores, learning curve and training time, how long the
shipped one holds what it reached (`agents.endurance`) and what action 0 does in its place
(`agents.shipping.action_zero`), and `failures.csv` (`agents.shipping.failures`).
"""

from __future__ import annotations

import re
import shlex
import shutil
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import drillrig_env
from agents.endurance import ENDURING, endurance
from agents.policy.run_folder import (
    CONFIG,
    EVALUATIONS,
    MODEL,
    SEEDS,
    TRAINED,
    is_finished,
    is_run,
    load_policy,
    read_config,
)
from agents.shipping.action_zero import in_its_place
from agents.shipping.card import tables_of_card, write_card
from agents.shipping.failures import FILE as FAILURES
from agents.shipping.failures import failures_of
from agents.shipping.home import suites_of
from agents.training.progress import read_progress
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.evaluation.beginning import begin
from drillrig_env.evaluation.contest import config_of, run_contest
from drillrig_env.evaluation.contestants import contestant_of
from drillrig_env.evaluation.findings import where_each_fails
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.results import Results, Scores
from drillrig_env.evaluation.suites import SUITES, home_suite, suite
from drillrig_env.evaluation.tables import MAIN, OTHERS, all_estimates, estimates
from drillrig_env.files import check_writable, json_text, owned, read_arrays, write_text, written_folders
from drillrig_env.flags import of_kind
from drillrig_env.parameters import refuse
from drillrig_env.policy import find_policy
from drillrig_env.policy.finding import installed_names
from drillrig_env.progress import Progress

COMMAND = "python -m agents.shipping.ship"
_WAYS_OUT = "--results names another folder; where this one is removed, the evaluation begins again"

_FAILURES = 10  # times as many rigs as a suite has, that the shipped seed's failures are looked for in

LEAST_SEEDS = 5
"""Fewer training seeds say too little about an algorithm."""


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Parse the command line, evaluate the seeds, and ship one."""
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of the seeds, as train.py --seeds leaves it")
    parser.add_argument("--name", required=True, help="what the agent is called")
    parser.add_argument("--rigs", type=of_kind(COUNT), default=1000, help="random rigs of a suite (default: 1000)")
    parser.add_argument("--suite", nargs="+", choices=list(SUITES), help="default: all that its environment has")
    parser.add_argument("--results", type=Path, metavar="DIR", help="folder that keeps the episodes, to go on from")
    chosen = parser.parse_args(arguments)
    made_by = shlex.join([*COMMAND.split(), *(sys.argv[1:] if arguments is None else arguments)])
    try:
        folder = ship(chosen.folder, chosen.name, chosen.rigs, chosen.suite, chosen.results, command=made_by)
    except ValueError as error:
        parser.error(error)
    print(f"seed {read_config(folder)['seed']} is shipped: {folder}")


def ship(
    runs: Path,
    name: str,
    rigs: int = 1000,
    suites: Sequence[str] | None = None,
    results_folder: Path | None = None,
    trained: Path = TRAINED,
    command: str = COMMAND,
) -> Path:
    """Evaluate the seeds in `runs`, copy the median one into `trained`/`name` with its card, and return that folder.

    `suites` are some of those of the agents' environment, all if None; its own is among them in any case. What is
    there by that name stays until all of the new one is. Raises `ValueError` for a name that an agent cannot have, for
    fewer than LEAST_SEEDS seeds, for a training among them that is unfinished or of another rig than the suites, and
    for results of other seeds or rigs in `results_folder`.
    """
    _check_name(name)
    folders = _finished(runs)
    learnt = {seed: _learnt(folder) for seed, folder in folders.items()}
    target = trained / name
    check_writable(target)
    env_id = read_config(next(iter(folders.values())))["env_id"]
    home, known = home_suite(env_id), suites_of(env_id)
    for one in suites or ():
        if one not in known:
            raise refuse("ship", "suite", one, "", ", ".join(known))
    asked = [one for one in known if suites is None or one in suites or one == home]
    results = _evaluate(runs, name, env_id, rigs, asked, results_folder, command)
    results.estimates = all_estimates(results.scores, name)
    scores = results.scores[home][name]
    shipped = median_seed(scores)
    alone = {one: {name: _of_seed(policies[name], shipped)} for one, policies in results.scores.items()}
    agent = load_policy(folders[shipped])
    with Progress("endurance", parts=1) as progress:
        held = endurance(agent, min(rigs, ENDURING), progress=partial(progress.show, name), suite_name=home)
    rows, counts = failures_of(folders[shipped], name, _FAILURES * rigs)
    sizes = {one: results.config["suites"][one]["rigs"] for one in results.scores}
    content = {
        "command": command,
        "provenance": provenance(),
        "rigs": sizes,
        "shipped": int(shipped),
        "seeds": {seed: {**one, "scores": _values(_of_seed(scores, seed))} for seed, one in learnt.items()},
        "pooled": {one: tables_of_card(tables[name], one == home) for one, tables in results.estimates.items()},
        "alone": {one: tables_of_card(tables[name], one == home) for one, tables in all_estimates(alone, name).items()},
        "endurance": held,
        "fails": where_each_fails(results, home)[0].removeprefix(f"`{name}`: "),
        "failures": counts,
        "action_zero": in_its_place(agent.environment, sizes, home),
    }
    with written_folders([target]) as (new,):
        for file in (CONFIG, MODEL, EVALUATIONS):
            shutil.copyfile(folders[shipped] / file, new / file)
        write_text(new / FAILURES, rows)
        write_text(new / SEEDS, json_text(content, indent=1))
    write_card(name, trained)
    return target


def median_seed(scores: Scores) -> str:
    """The seed of median mitigated share; the lower cost decides between equals."""
    ranks = {}
    for seed in np.unique(scores["seed"]).tolist():
        own = _of_seed(scores, seed)
        ranks[seed] = (float(own["mitigated"].mean()), -float(own["cost"].mean()))
    worst_first = sorted(ranks, key=lambda seed: (ranks[seed], int(seed)))
    return str(worst_first[(len(worst_first) - 1) // 2])


def _finished(runs: Path) -> dict[str, Path]:
    """The folders of the seeds by seed. `ValueError` where they are too few, or one is not finished."""
    folders = {str(read_config(path)["seed"]): path for path in sorted(runs.glob("*")) if is_run(path)}
    if len(folders) < LEAST_SEEDS:
        raise ValueError(f"{runs} holds {len(folders)} training seeds; allowed: >= {LEAST_SEEDS}")
    for path in folders.values():
        missing = [file for file in (MODEL, EVALUATIONS) if not (path / file).is_file()]
        if missing or not is_finished(path):
            raise ValueError(f"{path} is not finished; go on with: python train.py --resume {runs}")
        if read_config(path)["env_kwargs"].get("rig") is not None:
            raise ValueError(
                f"{path} has a rig of its own, and the suites are of the laboratory's; it acts and is judged from its "
                f"folder: python eval.py {runs} --rig FILE"
            )
    return {seed: folders[seed] for seed in sorted(folders, key=int)}


def _evaluate(
    runs: Path, name: str, env_id: str, rigs: int, suites: Sequence[str], folder: Path | None, command: str
) -> Results:
    """All seeds in all suites, as `eval.py` does it; what `folder` holds already is not run again."""
    contestant = contestant_of(find_policy(str(runs)), env_id, name)
    chosen = [suite(one, rigs) for one in suites]
    config = config_of(env_id, chosen, [contestant], drillrig_env.__version__, command, name)
    results, histories = Results(config, provenance()), Histories()
    with ExitStack() as stack:
        if folder:
            check_writable(folder)
            stack.enter_context(owned(folder))
            results, histories = begin(folder, config, resume=True, ways_out=_WAYS_OUT)
        for one in chosen:
            with Progress(one.name, 1) as progress:
                failures = run_contest(one, [contestant], results, histories, folder, progress.show)
            if failures:
                raise ValueError(str(failures[0]))
    return results


def _of_seed(scores: Scores, seed: str) -> Scores:
    chosen = scores["seed"] == seed
    return {name: values[chosen] for name, values in scores.items()}


def _learnt(folder: Path) -> dict[str, Any]:
    """One seed's training time, machine and learning curve. `ValueError` where the run's files do not tell them."""
    remedy = "train this seed again"
    saved = read_arrays(folder / EVALUATIONS, remedy)
    try:
        timesteps, mitigated = saved["timesteps"].tolist(), saved["mitigated"].mean(axis=1).tolist()
        machine = read_config(folder)["provenance"]["machine"]
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{folder} does not tell how it was trained ({error}); {remedy}") from error
    return {
        "seconds": read_progress(folder).get("seconds"),
        "machine": machine,
        "timesteps": timesteps,
        "mitigated": [round(share, 4) for share in mitigated],
    }


def _values(scores: Scores) -> dict[str, float | None]:
    """One seed's scores in the suite of its rigs."""
    row = estimates(scores, MAIN.columns + OTHERS.columns)
    return {heading: estimate.value for heading, estimate in row.items()}


def _check_name(name: str) -> None:
    """`ValueError` for a name under which no agent would be found."""
    if not re.fullmatch(r"\w[\w-]*", name, re.ASCII) or name in installed_names():
        raise refuse("ship", "name", name, "", "letters, digits, _ and -, and not the name of a law")


if __name__ == "__main__":
    raise SystemExit(main())
