"""The page: all checks as Markdown tables, and the list of what cannot be checked."""

from __future__ import annotations

from functools import cache

from drillrig_env import markdown
from drillrig_env.validation import diagrams, equations, local_stability, low_end, time_responses
from drillrig_env.validation.check import Check
from drillrig_env.validation.out_of_reach import OUT_OF_REACH

COMMAND = "python -m drillrig_env.validation --output docs/validation.md"

_TOPICS = {
    "Equations and parameters (section 4.1)": equations.checks,
    "Runs in time (sections 4.2, 4.3)": time_responses.checks,
    "Standstill and H1 (sections 4.4.1, 4.4.3)": low_end.checks,
    "Local stability (section 4.4.2)": local_stability.checks,
    "Bifurcation diagrams (section 4.4.3)": diagrams.checks,
}


@cache
def all_checks() -> dict[str, tuple[Check, ...]]:
    """Every check by topic; computed once, in some seconds."""
    return {topic: tuple(checks()) for topic, checks in _TOPICS.items()}


def page() -> str:
    """The whole page as Markdown. Numbers are rounded so that it is the same on every machine."""
    topics = all_checks()
    every = [check for checks in topics.values() for check in checks]
    differ = [check for check in every if not check.agrees]
    parts = [
        "# Validation: the chapter's numbers and statements beside the model's",
        f"Written by `{COMMAND}`; do not edit. A test compares it with what the code gives.",
        f"{len(every)} checks: {len(every) - len(differ)} agree, {len(differ)} differ. Speeds are those of the string; "
        "a difference is computed less printed, with what is allowed in brackets. What was chosen where the chapter "
        "is silent is in [model.md](model.md).",
        "Those that differ:",
        "\n".join(f"- {check.where}: {check.statement}." for check in differ),
    ]
    for topic, checks in topics.items():
        parts += [f"## {topic}", markdown.table(_HEADER, [_cells(check) for check in checks], len(_HEADER))]
    parts += ["## What cannot be checked", markdown.table(("where", "what", "why"), OUT_OF_REACH, 3)]
    return "\n\n".join(parts) + "\n"


_HEADER = ("where", "the chapter says", "printed", "computed", "difference", "verdict")


def _cells(check: Check) -> tuple[str, ...]:
    difference = ""
    if check.difference is not None:
        difference = f"{check.difference:+.2g} ({check.tolerance:g})"
    return (check.where, check.statement, check.printed, check.computed, difference, check.verdict)
