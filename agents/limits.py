"""What limits a policy where nobody knows the rig: its shares with noise, delay and the unknown rig taken away.

    python -m agents.limits ppo_unknown                 # by name or run folder; half an hour on one core
    python -m agents.limits ppo_unknown runs/unknown/memory_0 runs/unknown/nominal_0
    python -m agents.limits runs/ppo_asymmetric_1 --rigs 32 --docs /tmp/docs

Beside them stand laws, some told the rig, and the ceiling, which is told everything. All face the episodes of the suite
`unknown`: as they are; with exact measurements; with measurements at once; with both; and the nominal rig in place of
the fleet, as it is and with both. Shares are given in all and by hardness. The tables go into docs/agents.md.

The file is written after each of these, and what it holds of the same agents and laws is not run again: one that was
stopped goes on when the command is given again. `--overwrite` begins anew.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from agents.policy.run_folder import MODEL, find_run, load_policy
from agents.unknown import BESIDE
from drillrig_env import markdown
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.env.task import Task
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.report import markdown_table
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import Suite, suite
from drillrig_env.evaluation.tables import HARDNESS, MAIN, estimates, stored_row
from drillrig_env.files import check_writable_file, digest, json_text, read_json, write_text
from drillrig_env.flags import of_kind
from drillrig_env.policy import context_of, make_policy
from drillrig_env.progress import Progress
from drillrig_env.scales import SLEW_LIMIT

COMMAND = "python -m agents.limits"
FILE = Path("agents") / "limits.json"
SUITE, RIGS = "unknown", 256

_BY_HARDNESS = ("as it is", "exact, at once")

COLUMNS = (MAIN.columns[0], *HARDNESS.columns)
"""What is told of each: all episodes, then those by hardness."""


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Run all of them and write the file."""
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument("agents", nargs="+", help="names of shipped agents, or folders of runs")
    parser.add_argument("--rigs", type=of_kind(COUNT), default=RIGS, help=f"of the fleet (default: {RIGS})")
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the documentation (default: docs)")
    parser.add_argument("--overwrite", action="store_true", help="begin anew, whatever the file holds")
    chosen = parser.parse_args(arguments)
    path = chosen.docs / FILE
    line = shlex.join([*COMMAND.split(), *(sys.argv[1:] if arguments is None else arguments)])
    try:
        check_writable_file(path)
        models = {words_of(name): _digest(name) for name in chosen.agents}
        kept = {} if chosen.overwrite or not path.is_file() else _kept(path, chosen.rigs, models)
        for found in limits(chosen.agents, chosen.rigs, kept):
            made = {"command": line, "provenance": provenance(), "rigs": chosen.rigs, "models": models}
            write_text(path, json_text({**made, "conditions": found}, indent=1))
    except (ValueError, OSError) as error:
        parser.error(error)
    print(table(read_json(path, "")))
    print(path.resolve())


def conditions(rigs: int) -> dict[str, Suite]:
    """The suite with what may limit a policy taken away, by what a table calls it; `rigs` is the size of the fleet."""
    drawn = suite(SUITE, rigs)
    sticking = {name: value for name, value in drawn.groups[0][1].items() if name != "rig"}
    spread = suite("default", 1).scenario.spread
    nominal = replace(
        drawn, scenario=replace(drawn.scenario, rigs=None, spread=spread), groups=((drawn.rigs, sticking),)
    )

    def seen(one: Suite, noise: float, at_once: bool) -> Suite:
        return replace(one, env={**one.env, "noise": noise, **({"delay": 0} if at_once else {})})

    return {
        "as it is": drawn,
        "exact": seen(drawn, 0.0, False),
        "at once": seen(drawn, 1.0, True),
        "exact, at once": seen(drawn, 0.0, True),
        "nominal rig": nominal,
        "nominal rig, exact, at once": seen(nominal, 0.0, True),
    }


Found = dict[str, dict[str, dict[str, dict[str, Any]]]]
"""Estimates by condition, policy and column."""


def limits(names: Sequence[str], rigs: int = RIGS, kept: Mapping[str, Any] | None = None) -> Iterator[Found]:
    """What is found so far, after each condition, for agents by name or run folder; `rigs` is the fleet's size.

    What is `kept` from before is not run again. `ValueError` where there is no such agent.
    """
    agents = {words_of(name): load_policy(find_run(name)).at_slew_limit(SLEW_LIMIT) for name in names}
    asked, found = conditions(rigs), Found(kept or {})
    policies: dict[str, Any] = {**agents, **{words: name for name, words in BESIDE.items()}}
    with Progress("what limits", parts=len(asked)) as progress:
        for condition, one in asked.items():
            task = Task.of(sensors="surface", scenario=one.scenario, **one.env)
            known = context_of(task)
            if task.delays == (0, 0):  # and that is known
                known["sensors"] = replace(task.sensors, delay=0)
            rows, before = {}, found.get(condition, {})
            for number, (words, policy) in enumerate(policies.items(), 1):
                if words in before:
                    rows[words] = before[words]
                else:
                    made = make_policy(policy, **known) if isinstance(policy, str) else policy
                    scores = score(run(made, one, sensors="surface"))
                    about = {**scores, "seed": np.full(len(scores["mitigated"]), "")}
                    rows[words] = {name: vars(estimate) for name, estimate in estimates(about, COLUMNS).items()}
                progress.show(condition, number, len(policies))
            found[condition] = rows
            yield found


def words_of(name: str) -> str:
    """What tables call an agent, by its name or run folder."""
    return f"`{Path(name).name}`"


def _digest(name: str) -> str:
    """What tells an agent from one that was trained again. `ValueError` where there is none."""
    model = find_run(name) / MODEL
    if not model.is_file():
        raise ValueError(f"{model.parent}: the run has no {MODEL}; it may have been stopped before the first save")
    return digest(model)[:16]


def _kept(path: Path, rigs: int, models: Mapping[str, str]) -> dict[str, Any]:
    """What the file holds of as many rigs, of these models as they are, and of the laws."""
    before = read_json(path, "or give --overwrite")
    if before.get("rigs") != rigs:
        return {}
    same = {words for words, model in before.get("models", {}).items() if models.get(words) == model}
    same |= set(BESIDE.values())
    conditions = before["conditions"].items()
    return {condition: {words: row for words, row in rows.items() if words in same} for condition, rows in conditions}


def table(content: Mapping[str, Any]) -> str:
    """A Markdown table: a row a policy, a column a condition."""
    by_condition = content["conditions"]
    policies = next(iter(by_condition.values()))
    first = COLUMNS[0].heading
    rows = [[words, *(f"{one[words][first]['value']:.3f}" for one in by_condition.values())] for words in policies]
    return markdown.table(["mitigated", *by_condition], rows)


def read_limits(docs: Path) -> dict[str, Any] | None:
    """What the command has found; None where it has not run. `ValueError` where the file is damaged."""
    path = docs / FILE
    return read_json(path, f"make it again with: {COMMAND}") if path.is_file() else None


def section(content: Mapping[str, Any] | None) -> str:
    """The section of the page on agents; empty where nothing was found."""
    if content is None:
        return ""
    found = content["conditions"]
    parts = [
        "## What limits where nobody knows the rig\n",
        f"The {content['rigs']} rigs of `{SUITE}`, 16 episodes of each, as they are seen; with exact measurements; "
        "with measurements that are not late; and the nominal rig in all of these episodes in place of the fleet. * is "
        "told what no real rig tells.\n",
        table(content),
    ]
    for condition in _BY_HARDNESS:
        if condition in found:
            rows = {words: stored_row(entries) for words, entries in found[condition].items()}
            parts += [f"\nBy hardness q, {condition}:\n", markdown_table(HARDNESS, rows, {}, "mitigated")]
    return "\n".join([*parts, "", f"*{markdown.sentence(HARDNESS.caption)}*\n"])


if __name__ == "__main__":
    raise SystemExit(main())
