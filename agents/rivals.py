"""Where a policy from the physics is still better than a shipped agent, from the stored results of `eval.py`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from drillrig_env import markdown
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.statistics import Estimate
from drillrig_env.evaluation.tables import MAIN, OTHERS, Column, Row, stored_row

_COLUMNS = {column.heading: column for column in (*MAIN.columns, *OTHERS.columns)}
_LARGER_IS_BETTER = ("mitigated", "below ω_c", "bistable", "above")
_SMALLER_IS_BETTER = ("to calm", "cost")


def ahead(stored: Mapping[str, Results], agents: Mapping[str, str]) -> str:
    """A section that names every score in which a rival is ahead of an agent; empty without stored results.

    `stored` are results by environment; `agents` are the environments of the agents by name.
    """
    lines = []
    for name, env_id in agents.items():
        if env_id in stored and name in stored[env_id].policies:
            lines += _of(name, env_id, stored[env_id], set(agents))
    if not lines:
        return ""
    return "\n".join(
        [
            "## Where the physics is still better\n",
            "Scores in which a policy from the physics has the better value, the best of those that are told nothing "
            "and the best of those that are told the friction (*). *Clear*: the 95 % intervals do not overlap. The "
            "agent here is the seed that ships; all numbers are in [results](results.md).\n",
            *lines,
        ]
    )


def beside(
    stored: Mapping[str, Results], policies: Iterable[tuple[str, str, str]], suite: str = "default"
) -> dict[str, Row]:
    """Rows of a `suite` by what they are called, from the results by environment of those policies that are there.

    `policies` are names, each with its environment and what it is called.
    """
    rows = {}
    for policy, env_id, words in policies:
        found = stored[env_id].estimates.get(suite, {}) if env_id in stored else {}
        if policy in found:
            rows[words] = _row(found[policy])
    return rows


def _of(name: str, env_id: str, results: Results, agents: set[str]) -> list[str]:
    """The table of one agent, or a sentence where no rival is ahead."""
    rows: list[tuple[str, ...]] = []
    for suite, policies in results.estimates.items():
        if name not in policies:
            continue
        own = _row(policies[name])
        rivals = {policy: _row(tables) for policy, tables in policies.items() if policy not in agents}
        for heading in (*_LARGER_IS_BETTER, *_SMALLER_IS_BETTER):
            for told in (False, True):
                group = {
                    policy: row[heading]
                    for policy, row in rivals.items()
                    if bool(results.privileged.get(policy)) == told and row[heading].count
                }
                row = _compared(suite, _COLUMNS[heading], own[heading], group, "*" if told else "")
                rows += [row] if row else []
    if not rows:
        return [
            f"`{name}` in `{env_id}`: no rival has a better value of mitigated, time to calm or cost in any suite.\n"
        ]
    headings = ("suite", "score", "agent", "rival", "its score", "clear")
    return [f"`{name}` in `{env_id}`:\n", markdown.table(headings, rows, ("suite", "score", "rival", "clear")), ""]


def _compared(suite: str, column: Column, own: Estimate, rivals: Mapping[str, Estimate], star: str) -> tuple[str, ...]:
    """A row of the table if the best rival is ahead, else nothing."""
    if not rivals or not own.count:
        return ()
    sign = 1.0 if column.heading in _LARGER_IS_BETTER else -1.0
    best = max(rivals, key=lambda policy: sign * rivals[policy].value)
    theirs = rivals[best]
    ours_text, theirs_text = (f"{one.value:.{column.digits}f}" for one in (own, theirs))
    if sign * (theirs.value - own.value) <= 0.0 or ours_text == theirs_text:
        return ()
    clear = own.high < theirs.low if sign > 0 else own.low > theirs.high
    return (f"`{suite}`", column.heading, ours_text, f"`{best}`{star}", theirs_text, "yes" if clear else "no")


def _row(tables: Mapping[str, Mapping[str, Mapping[str, float | None]]]) -> Row:
    return stored_row({**tables["main"], **tables["others"]})
