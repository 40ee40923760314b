"""What limits a policy where nobody knows the rig: its shares with noise, delay and the unknown rig taken away.

    python -m agents.limits ppo_unknown                 # by name or run folder; half an hour on one core
    python -m agents.limits ppo_unknown runs/unknown/memory_0 runs/unknown/nominal_0
    python -m agents.limits runs/ppo_asymmetric_1 --rigs 32 --docs /tmp/docs

Beside them stand laws, some told the rig, and the ceiling, which is told everything. All face the episodes of the suite
`unknown`: as they are; with exact measurements; with measurements at once; with both; and the nominal rig in place of
the fleet, as it is and with both. Shares are given in all and by hardness. The tables go into docs/agents.md.

The file is written after each of these, and what it holds of the same agents and laws is not run again: one that was
stopped goes on when the command is given again. Other agents in it stay, also those of a command that runs beside this
one, but for a shipped one that has been trained again. `--overwrite` begins anew, as do rigs of another number.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from agents.policy.run_folder import MODEL, TRAINED, find_run, load_policy
from agents.unknown import BESIDE
from drillrig_env import markdown
from drillrig_env.allowed import Allowed
from drillrig_env.command_line import Parser, command
from drillrig_env.env.task import Task
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.evaluation.report import markdown_table
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.statistics import Estimate
from drillrig_env.evaluation.suites import LARGEST_FLEET, Suite, suite
from drillrig_env.evaluation.tables import HARDNESS, MAIN, estimates, stored_row
from drillrig_env.files import check_writable_file, digest, json_text, owned, read_json, write_text
from drillrig_env.flags import of_kind
from drillrig_env.policy import context_of, make_policy
from drillrig_env.progress import Progress
from drillrig_env.scales import SLEW_LIMIT

COMMAND = "python -m agents.limits"
FILE = Path("agents") / "limits.json"
SUITE, RIGS = "unknown", LARGEST_FLEET

_SIZE = Allowed(1, LARGEST_FLEET, whole=True)
_WAIT = 60.0  # s, for another process that writes
_ANEW = "begin anew with --overwrite"

_BY_HARDNESS = ("as it is", "exact, at once")

COLUMNS = (MAIN.columns[0], *HARDNESS.columns)
"""What is told of each: all episodes, then those by hardness."""

_ESTIMATE = tuple(item.name for item in fields(Estimate))


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Run all of them and write the file."""
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument("agents", nargs="+", help="names of shipped agents, or folders of runs")
    parser.add_argument("--rigs", type=of_kind(_SIZE), default=RIGS, help=f"rigs of the fleet (default: {RIGS})")
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the documentation (default: docs)")
    parser.add_argument("--overwrite", action="store_true", help="begin anew, whatever the file holds")
    chosen = parser.parse_args(arguments)
    path = chosen.docs / FILE
    line = shlex.join([*COMMAND.split(), *(sys.argv[1:] if arguments is None else arguments)])
    check_writable_file(path)
    try:
        models = _models(chosen.agents)
        before = _Before({}, {}) if chosen.overwrite else _before(path, chosen.rigs, models)
        anew = chosen.overwrite
        for found in limits(chosen.agents, chosen.rigs, before.conditions):
            with owned(path.parent, _WAIT):
                now = _Before({}, {}) if anew else _before(path, chosen.rigs, models)
                made = {"command": line, "provenance": provenance(), "rigs": chosen.rigs}
                content = {**made, "models": {**now.models, **models}, "conditions": _together(now.conditions, found)}
                write_text(path, json_text(content, indent=1))
            anew = False
        print(table(_read(path, _ANEW)))
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


Found: TypeAlias = dict[str, dict[str, dict[str, dict[str, Any]]]]
"""Estimates by condition, policy and column."""


def limits(names: Sequence[str], rigs: int = RIGS, kept: Mapping[str, Any] | None = None) -> Iterator[Found]:
    """What is found so far, after each condition, for agents by name or run folder; `rigs` is the fleet's size.

    What is `kept` from before is not run again. `ValueError` where there is no such agent.
    """
    agents = {words_of(name): load_policy(find_run(name)).at_slew_limit(SLEW_LIMIT) for name in names}
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


def words_of(name: str) -> str:
    """What tables call an agent, by its name or run folder."""
    return f"`{Path(name).name}`"


def _digest(name: str) -> str:
    """What tells an agent from one that was trained again. `ValueError` where there is none."""
    model = find_run(name) / MODEL
    if not model.is_file():
        raise ValueError(f"{model.parent}: the run has no {MODEL}; it may have been stopped before the first save")
    return digest(model)[:16]


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


@dataclass(frozen=True)
class _Before:
    """What a file holds that is still so: models of agents and estimates, by what tables call them."""

    models: dict[str, str]
    conditions: Found


def _before(path: Path, rigs: int, models: Mapping[str, str]) -> _Before:
    """What the file holds of these models, of the laws, and of other agents; nothing where there is none.

    What was found of another model of these names is left out, as is a shipped agent that has another model by now.
    `ValueError` where the file is damaged, or of other rigs.
    """
    if not path.is_file():
        return _Before({}, {})
    content = _read(path, _ANEW)
    if content["rigs"] != rigs:
        raise ValueError(
            f"{path} is of {content['rigs']} rigs, not of {rigs}; name another folder with --docs, or {_ANEW}"
        )
    now = {**{words: _shipped(words) for words in content["models"]}, **models}
    same = {words: model for words, model in content["models"].items() if now[words] in (model, None)}
    known = {*same, *BESIDE.values()}
    conditions = content["conditions"].items()
    return _Before(
        same, {name: {words: row for words, row in rows.items() if words in known} for name, rows in conditions}
    )


def _shipped(words: str) -> str | None:
    """The digest of the agent that ships by this name; None where none does."""
    model = TRAINED / words.strip("`") / MODEL
    return digest(model)[:16] if model.is_file() else None


def _together(before: Found, found: Found) -> Found:
    """Both, what was found now in place of what was before; the laws come last."""
    both: Found = {}
    for condition in [*found, *(name for name in before if name not in found)]:
        rows = {**before.get(condition, {}), **found.get(condition, {})}
        laws = [words for words in BESIDE.values() if words in rows]
        both[condition] = {words: rows[words] for words in [*(one for one in rows if one not in laws), *laws]}
    return both


def table(content: Mapping[str, Any]) -> str:
    """A Markdown table: a row a policy that has faced all conditions so far, a column a condition."""
    by_condition = content["conditions"]
    first = COLUMNS[0].heading
    rows = [
        [words, *(f"{one[words][first]['value']:.3f}" for one in by_condition.values())]
        for words in _in_all(by_condition)
    ]
    return markdown.table(["mitigated", *by_condition], rows)


def _in_all(by_condition: Found) -> list[str]:
    """The policies that every condition has: one that was added and stopped has only some yet."""
    several = list(by_condition.values())
    return [words for words in several[0] if all(words in one for one in several)]


def read_limits(docs: Path) -> dict[str, Any] | None:
    """What the command has found; None where it has not run. `ValueError` where the file is damaged."""
    path = docs / FILE
    return _read(path, f"make it again with: {COMMAND} ppo_unknown --overwrite") if path.is_file() else None


def _read(path: Path, remedy: str) -> dict[str, Any]:
    """What the file holds. `ValueError` with `remedy`, what to do, where it is damaged."""
    content = read_json(path, remedy)
    if fault := _fault(content):
        raise ValueError(f"{path} is damaged: {fault}; {remedy}")
    return content


def _fault(content: Mapping[str, Any]) -> str:
    """What a file's content lacks, in words; empty where nothing."""
    for name, kind in {"command": str, "provenance": dict, "models": dict, "conditions": dict}.items():
        if not isinstance(content.get(name), kind):
            return f"it does not tell {name}"
    if type(content.get("rigs")) is not int or not _SIZE.holds(content["rigs"]):
        return f"rigs = {content.get('rigs')!r}; allowed: {_SIZE}"
    if not {"date", "machine"} <= set(content["provenance"]):
        return "provenance does not tell date and machine"
    if not content["conditions"]:
        return "it has no condition"
    for condition, rows in content["conditions"].items():
        if not isinstance(rows, dict) or not all(_is_row(row) for row in rows.values()):
            return f"what it has of {condition!r} is no estimates by policy"
    return ""


def _is_row(row: Any) -> bool:
    """Whether this has an estimate for each column, and a share in all."""
    if not isinstance(row, dict) or {column.heading for column in COLUMNS} != set(row):
        return False
    for estimate in row.values():
        if not isinstance(estimate, dict) or not set(_ESTIMATE) <= set(estimate):
            return False
        if not all(estimate[name] is None or isinstance(estimate[name], float | int) for name in _ESTIMATE):
            return False
    return row[COLUMNS[0].heading]["value"] is not None


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
            rows = {words: stored_row(found[condition][words]) for words in _in_all(found)}
            parts += [f"\nBy hardness q, {condition}:\n", markdown_table(HARDNESS, rows, {}, "mitigated")]
    return "\n".join([*parts, "", f"*{markdown.sentence(HARDNESS.caption)}*\n"])


if __name__ == "__main__":
    raise SystemExit(main())
