"""What `python -m agents.limits` has found: its file, with what is still so, and the tables that come of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeAlias

from agents.policy.run_folder import MODEL, TRAINED
from agents.unknown import BESIDE
from drillrig_env import markdown
from drillrig_env.allowed import Allowed
from drillrig_env.evaluation.report import markdown_table
from drillrig_env.evaluation.statistics import Estimate
from drillrig_env.evaluation.suites import LARGEST_FLEET
from drillrig_env.evaluation.tables import HARDNESS, MAIN, stored_row
from drillrig_env.files import digest, read_json

COMMAND = "python -m agents.limits"
FILE = Path("agents") / "limits.json"
SUITE = "unknown"

COLUMNS = (MAIN.columns[0], *HARDNESS.columns)
"""What is told of each: all episodes, then those by hardness."""

SIZE = Allowed(1, LARGEST_FLEET, whole=True)
"""Rigs of the fleet."""

_ANEW = "begin anew with --overwrite"
_BY_HARDNESS = ("as it is", "exact, at once")
_ESTIMATE = tuple(item.name for item in fields(Estimate))

Found: TypeAlias = dict[str, dict[str, dict[str, dict[str, Any]]]]
"""Estimates by condition, policy and column."""


@dataclass(frozen=True)
class Before:
    """What a file holds that is still so: models of agents and estimates, by what tables call them."""

    models: dict[str, str]
    conditions: Found


def kept_before(path: Path, rigs: int, models: Mapping[str, str]) -> Before:
    """What the file holds of these models, of the laws, and of other agents; nothing where there is none.

    What was found of another model of these names is left out, as is a shipped agent that has another model by now.
    `ValueError` where the file is damaged, or of other rigs.
    """
    if not path.is_file():
        return Before({}, {})
    content = read_json(path, _ANEW, _fault)
    if content["rigs"] != rigs:
        raise ValueError(
            f"{path} is of {content['rigs']} rigs, not of {rigs}; name another folder with --docs, or {_ANEW}"
        )
    shipped = {words: TRAINED / words.strip("`") / MODEL for words in content["models"]}
    now = {**{words: digest_of(model) for words, model in shipped.items() if model.is_file()}, **models}
    same = {words: model for words, model in content["models"].items() if now.get(words, model) == model}
    known = {*same, *BESIDE.values()}
    conditions = content["conditions"].items()
    return Before(
        same, {name: {words: row for words, row in rows.items() if words in known} for name, rows in conditions}
    )


def digest_of(model: Path) -> str:
    """What tells an agent from one that was trained again."""
    return digest(model)[:16]


def together(before: Found, found: Found) -> Found:
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
    remedy = f"make it again with: {COMMAND} ppo_unknown --overwrite"
    return read_json(path, remedy, _fault) if path.is_file() else None


def _fault(content: Mapping[str, Any]) -> str:
    """What a file's content lacks, in words; empty where nothing."""
    for name, kind in {"command": str, "provenance": dict, "models": dict, "conditions": dict}.items():
        if not isinstance(content.get(name), kind):
            return f"it does not tell {name}"
    if type(content.get("rigs")) is not int or not SIZE.holds(content["rigs"]):
        return f"rigs = {content.get('rigs')!r}; allowed: {SIZE}"
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
        "told what no real rig tells. [What they are, and what follows](fleets.md#what-limits).\n",
        table(content),
    ]
    for condition in _BY_HARDNESS:
        if condition in found:
            rows = {words: stored_row(found[condition][words]) for words in _in_all(found)}
            parts += [f"\nBy hardness q, {condition}:\n", markdown_table(HARDNESS, rows, {}, "mitigated")]
    return "\n".join([*parts, "", f"*{markdown.sentence(HARDNESS.caption)}*\n"])
