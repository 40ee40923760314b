"""What limits a policy where nobody knows the rig: its shares with noise, delay and the unknown rig taken away.

    python -m agents.limits ppo_unknown                 # by name or run folder; some ten minutes on one core
    python -m agents.limits runs/ppo_asymmetric_1 --rigs 32

Beside it stand laws, some told the rig, and the ceiling, which is told everything. All face the episodes of the suite
`unknown`: as they are; with exact measurements; with measurements at once; with both; and the nominal rig in place of
the fleet, as it is and with both. Shares are given in all and by hardness. The table goes into the page of findings.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from agents.policy.run_folder import find_run, load_policy
from agents.unknown import BESIDE
from drillrig_env import markdown
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.env.task import Task
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import Suite, suite
from drillrig_env.evaluation.tables import HARDNESS, MAIN, Column
from drillrig_env.files import check_writable_file, json_text, write_text
from drillrig_env.flags import of_kind
from drillrig_env.policy import context_of, make_policy
from drillrig_env.progress import Progress
from drillrig_env.scales import SLEW_LIMIT

COMMAND = "python -m agents.limits"
FILE = Path("agents") / "limits.json"
SUITE, RIGS = "unknown", 256

COLUMNS = (MAIN.columns[0], *HARDNESS.columns)
"""What is told of each: all episodes, then those by hardness."""


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Run all of them and write the file."""
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument("agent", help="a shipped agent's name, or the folder of a run")
    parser.add_argument("--rigs", type=of_kind(COUNT), default=RIGS, help=f"of the fleet (default: {RIGS})")
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the documentation (default: docs)")
    chosen = parser.parse_args(arguments)
    path = chosen.docs / FILE
    check_writable_file(path)
    line = shlex.join([*COMMAND.split(), *(sys.argv[1:] if arguments is None else arguments)])
    try:
        found = limits(chosen.agent, chosen.rigs)
    except ValueError as error:
        parser.error(error)
    content = {"command": line, "provenance": provenance(), "rigs": chosen.rigs, "conditions": found}
    write_text(path, json_text(content, indent=1))
    print(table(content))
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


def limits(name: str, rigs: int = RIGS) -> dict[str, dict[str, dict[str, dict[str, float | None]]]]:
    """Estimates by condition, policy and column; `name` is an agent's name or run folder, `rigs` the fleet's size.

    `ValueError` where there is no such agent.
    """
    agent = load_policy(find_run(name)).at_slew_limit(SLEW_LIMIT)
    found: dict[str, dict[str, dict[str, dict[str, float | None]]]] = {}
    asked = conditions(rigs)
    with Progress("what limits", parts=len(asked)) as progress:
        for condition, one in asked.items():
            task = Task.of(sensors="surface", scenario=one.scenario, **one.env)
            found[condition] = {}
            for number, policy in enumerate((name, *BESIDE), 1):
                made = agent if policy == name else make_policy(policy, **context_of(task))
                scores = score(run(made, one, sensors="surface"))
                about = {**scores, "seed": np.full(len(scores["mitigated"]), "")}
                words = f"`{Path(name).name}`" if policy == name else BESIDE[policy]
                found[condition][words] = {column.heading: _entry(column, about) for column in COLUMNS}
                progress.show(condition, number, len(BESIDE) + 1)
    return found


def _entry(column: Column, scores: Mapping[str, Any]) -> dict[str, float | None]:
    if not column.chosen(scores).any():
        return {"value": None, "low": None, "high": None}
    estimate = column.estimate(scores)
    return {"value": estimate.value, "low": estimate.low, "high": estimate.high}


def table(content: Mapping[str, Any]) -> str:
    """A Markdown table: a row a policy, a column a condition."""
    by_condition = content["conditions"]
    policies = next(iter(by_condition.values()))
    first = COLUMNS[0].heading
    rows = [[words, *(f"{one[words][first]['value']:.3f}" for one in by_condition.values())] for words in policies]
    return markdown.table(["mitigated", *by_condition], rows)


if __name__ == "__main__":
    raise SystemExit(main())
