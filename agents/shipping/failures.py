"""List every rig that an agent leaves shaking or off its target, of ten times as many rigs as a suite has.

    python -m agents.shipping.failures ppo      # of the shipped `ppo`; writes its card anew
    python -m agents.shipping.failures          # of all of them

A share of 0.998 stands for two rigs in a thousand, too few to see what they have in common. The rigs are those of the
suite `default` (or of the agent's environment) and the ones that follow them, so that the first thousand are the
suite's own. `failures.csv` in the agent's folder has a row a rig, as `results.csv` does, the hardest first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from agents.policy.run_folder import SEEDS, TRAINED, read_config, seeds_of
from agents.shipping.card import write_card
from agents.shipping.named import add_names_argument
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.evaluation.contest import Contestant
from drillrig_env.evaluation.contestants import contestant_of
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import Suite, home_suite, suite
from drillrig_env.evaluation.tables import HARDNESS, Scores
from drillrig_env.files import check_writable, json_text, write_text
from drillrig_env.flags import of_kind
from drillrig_env.policy import find_policy
from drillrig_env.progress import Progress

COMMAND = "python -m agents.shipping.failures"
FILE = "failures.csv"
RIGS = 10_000

_AT_ONCE = 1000  # rigs that are run side by side


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """List the failures of all shipped agents or of those named."""
    parser = Parser(prog=COMMAND, description=__doc__)
    add_names_argument(parser)
    parser.add_argument("--rigs", type=of_kind(COUNT), default=RIGS, help=f"how many are tried (default: {RIGS})")
    chosen = parser.parse_args(arguments)
    try:
        for name in chosen.names:
            print(write_failures(name, chosen.rigs).resolve())
    except ValueError as error:
        parser.error(error)


def write_failures(name: str, rigs: int = RIGS, trained: Path = TRAINED) -> Path:
    """List a shipped agent's failures among `rigs` rigs, count them in its `seeds.json` and card; returns the list.

    `ValueError` where there is no such agent.
    """
    folder = trained / name
    about = seeds_of(folder)
    check_writable(folder)
    rows, counts = failures_of(folder, name, rigs)
    write_text(folder / FILE, rows)
    write_text(folder / SEEDS, json_text({**about, "failures": counts}, indent=1))
    write_card(name, trained)
    return folder / FILE


def failures_of(folder: Path, name: str, rigs: int = RIGS) -> tuple[str, dict[str, dict[str, int]]]:
    """What `failures` says of the agent in a run folder, which is called `name`, with its progress shown."""
    env_id = read_config(folder)["env_id"]
    contestant = contestant_of(find_policy(str(folder)), env_id, name)
    with Progress("failures", parts=1) as progress:
        return failures(contestant, rigs, partial(progress.show, name), home_suite(env_id))


def failures(
    contestant: Contestant,
    rigs: int = RIGS,
    progress: Callable[[int, int], object] | None = None,
    home: str = "default",
) -> tuple[str, dict[str, dict[str, int]]]:
    """The rigs of `rigs` that the one member of `contestant` does not mitigate, as rows of CSV, the hardest first.

    With it, by bin of hardness, how many `rigs` there are, how many `failed`, and how many of these are `calm` but
    off the target. `progress` is called with the rigs done and how many there are. `home` is the suite; one with
    a fleet has no more episodes than its own.
    """
    ((seed, make),) = contestant.members.items()
    parts: list[dict[str, np.ndarray[Any, Any]]] = []
    for first, drawn in _parts_of(home, rigs):
        scores = score(run(make(drawn), drawn, **contestant.env))
        parts.append({"seed": np.full(drawn.rigs, seed), "episode": first + np.arange(drawn.rigs), **scores})
        if progress:
            progress(first + drawn.rigs, max(rigs, first + drawn.rigs))
    every = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    failed = np.flatnonzero(~every["mitigated"])
    hardest_first = failed[np.argsort(-every["hardness"][failed], kind="stable")]
    results = Results()
    results.add(home, contestant.name, {name: values[hardest_first] for name, values in every.items()})
    return results.rows, _by_hardness(every)


def _parts_of(home: str, rigs: int) -> Iterator[tuple[int, Suite]]:
    """The rigs of a suite and those that follow it, so many at a time, each with the number of its first."""
    if suite(home, 1).scenario.rigs is not None:
        yield 0, suite(home, rigs)
        return
    for first in range(0, rigs, _AT_ONCE):
        drawn = suite(home, min(_AT_ONCE, rigs - first))
        yield first, replace(drawn, first_seed=drawn.first_seed + first)


def _by_hardness(scores: Scores) -> dict[str, dict[str, int]]:
    counts = {}
    for column in HARDNESS.columns:
        chosen = column.chosen(scores)
        failed = chosen & ~scores["mitigated"]
        counts[column.heading] = {
            "rigs": int(chosen.sum()),
            "failed": int(failed.sum()),
            "calm": int((failed & scores["calm"]).sum()),
        }
    return counts


if __name__ == "__main__":
    raise SystemExit(main())
