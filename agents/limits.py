"""What limits a policy where nobody knows the rig: its shares with noise, delay and the unknown rig taken away.

    python -m agents.limits ppo_unknown                 # by name or run folder; half an hour on one core
    python -m agents.limits ppo_unknown runs/unknown/memory_0 runs/unknown/nominal_0
    python -m agents.limits runs/ppo_asymmetric_1 --rigs 32 --docs /tmp/docs

Beside them stand laws, some told the rig, and the ceiling, which is told everything. All face the episodes of the suite
`unknown`: as they are; with exact measurements; with measurements at once; with both; and the nominal rig in place of
the fleet, as it is and with both. Shares in all are printed; the file keeps them by hardness too, with intervals, and
`python -m docs.make agents` makes the tables of docs/agents.md from it.

The file is written after each of these, and what it holds of the same agents and laws is not run again: one that was
stopped goes on when the command is given again. Other agents in it stay, also those of a command that runs beside this
one, but for a shipped one that has been trained again. `--overwrite` begins anew, as another number of rigs has to.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from agents.limits_kept import (
    COLUMNS,
    COMMAND,
    FILE,
    SIZE,
    SUITE,
    Before,
    Found,
    digest_of,
    kept_before,
    table,
    together,
)
from agents.policy.agent import Agent
from agents.policy.finding import at_slew_limit
from agents.policy.run_folder import MODEL, find_run, load_policy
from agents.unknown import BESIDE
from drillrig_env.command_line import Parser, command
from drillrig_env.env.task import Task
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import LARGEST_FLEET, Suite, suite
from drillrig_env.evaluation.tables import estimates
from drillrig_env.files import check_writable_file, json_text, owned, write_text
from drillrig_env.flags import of_kind
from drillrig_env.parameters import refuse
from drillrig_env.policy import context_of, make_policy
from drillrig_env.progress import Progress

RIGS = LARGEST_FLEET
_WAIT = 60.0  # s, for another process that writes


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Run all of them and write the file."""
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument("agents", nargs="+", help="names of shipped agents, or folders of runs")
    parser.add_argument("--rigs", type=of_kind(SIZE), default=RIGS, help=f"rigs of the fleet (default: {RIGS})")
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the documentation (default: docs)")
    parser.add_argument("--overwrite", action="store_true", help="begin anew, whatever the file holds")
    chosen = parser.parse_args(arguments)
    path = chosen.docs / FILE
    line = shlex.join([*COMMAND.split(), *(sys.argv[1:] if arguments is None else arguments)])
    check_writable_file(path)
    try:
        models = _models(chosen.agents)
        before = Before({}, {}) if chosen.overwrite else kept_before(path, chosen.rigs, models)
        anew = chosen.overwrite
        for found in limits(chosen.agents, chosen.rigs, before.conditions):
            with owned(path.parent, _WAIT):
                now = Before({}, {}) if anew else kept_before(path, chosen.rigs, models)
                made = {"command": line, "provenance": provenance(), "rigs": chosen.rigs}
                content = {**made, "models": {**now.models, **models}, "conditions": together(now.conditions, found)}
                write_text(path, json_text(content, indent=1))
            anew = False
        print(table(content))
    except ValueError as error:
        parser.error(error)
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


def limits(names: Sequence[str], rigs: int = RIGS, kept: Mapping[str, Any] | None = None) -> Iterator[Found]:
    """What is found so far, after each condition, for agents by name or run folder; `rigs` is the fleet's size.

    What is `kept` from before is not run again. `ValueError` where there is no such agent.
    """
    agents = {words_of(name): _agent(name) for name in names}
    policies: dict[str, Any] = {**agents, **{words: name for name, words in BESIDE.items()}}
    asked = conditions(rigs)
    before = (kept or {}).items()
    found: Found = {name: {words: row for words, row in rows.items() if words in policies} for name, rows in before}
    with Progress("what limits", parts=len(asked)) as progress:
        for condition, one in asked.items():
            task = Task.of(sensors="surface", scenario=one.scenario, **one.env)
            known = context_of(task)
            if task.delays == (0, 0):  # and that is known
                known["sensors"] = replace(task.sensors, delay=0)
            rows, known_already = {}, found.get(condition, {})
            for number, (words, policy) in enumerate(policies.items(), 1):
                if words in known_already:
                    rows[words] = known_already[words]
                else:
                    made = make_policy(policy, **known) if isinstance(policy, str) else policy
                    scores = score(run(made, one, sensors="surface"))
                    about = {**scores, "seed": np.full(len(scores["mitigated"]), "")}
                    rows[words] = {name: vars(estimate) for name, estimate in estimates(about, COLUMNS).items()}
                progress.show(condition, number, len(policies))
            found[condition] = rows
            yield found


def _agent(name: str) -> Agent:
    """The agent of a name or run folder, for the rig of the suite. `ValueError` where its drive is another."""
    agent = load_policy(find_run(name))
    if agent.drive is not None:
        raise refuse(COMMAND, "agent", name, "", "one on the rig's own drive, as those are that it stands beside")
    return at_slew_limit(agent)


def words_of(name: str) -> str:
    """What tables call an agent, by its name or run folder."""
    return f"`{Path(name).name}`"


def _digest(name: str) -> str:
    """The digest of an agent's model. `ValueError` where it has none."""
    model = find_run(name) / MODEL
    if not model.is_file():
        raise ValueError(f"{model.parent}: the run has no {MODEL}; it may have been stopped before the first save")
    return digest_of(model)


def _models(names: Sequence[str]) -> dict[str, str]:
    """The digest of each agent's model, by what tables call it. `ValueError` where they call two things the same."""
    runs: dict[str, Path] = {}
    for name in names:
        words, run = words_of(name), find_run(name)
        if words in BESIDE.values():
            raise ValueError(f"{name}: tables call a law {words}; name its folder otherwise")
        if runs.setdefault(words, run).resolve() != run.resolve():
            raise ValueError(f"tables would call both {runs[words]} and {run} {words}; name their folders otherwise")
    return {words_of(name): _digest(name) for name in names}


if __name__ == "__main__":
    raise SystemExit(main())
