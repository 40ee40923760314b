"""docs/validation.md: every number and statement of the source chapter that the model can be held to.

With equation or figure, the printed and the computed value, and a verdict; then what cannot be checked, and why.
"""

from __future__ import annotations

from drillrig_env import markdown
from drillrig_env.validation import OUT_OF_REACH, Check, all_checks

COMMAND = "python -m docs.make validation"


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
