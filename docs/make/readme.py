"""The table of README.md and the site's first page: the stored results' headline, each policy with what it does."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from docs.make.results import stored_results
from drillrig_env import markdown
from drillrig_env.evaluation.provenance import when_and_where
from drillrig_env.evaluation.report import cell
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.tables import MAIN, Column, stored_row

COMMAND = "python -m docs.make readme"
_PLACE = re.compile(r"(?<=<!-- scores -->\n).*?(?=<!-- end of scores -->)", re.DOTALL)
_ENV = "DrillRig-v0"

_POLICIES = {
    "constant": "nothing: the reference stays at the target (action 0)",
    "jump_ease_estimated": "jumps past the fold, then eases back down",
    "z_torque": "the torque law of the industry",
    "lqg": "state feedback from a filter, designed on the model",
    "ppo": "learnt: imitates `lqg`, then goes on by trial",
    "ppo_robust": "learnt with noise and delay",
    "soft_torque": "softens the drive's own gains, where that is allowed",
}
"""What each policy of the table does."""

_COLUMNS = {
    "mitigated": ("default", "mitigated"),
    "below ω_c": ("default", "below ω_c"),
    "late and noisy": ("degraded", "mitigated"),
    "time to calm, s": ("default", "to calm"),
}
"""The columns: a suite and a column of its headline."""


def texts(docs: Path) -> dict[Path, str]:
    """Both pages with the table that the stored results give. `ValueError` where one has no place for it."""
    found = {}
    for path in (docs.parent / "README.md", docs / "index.md"):
        text = path.read_text(encoding="utf-8")
        if not _PLACE.search(text):
            raise ValueError(f"{path} has no place for its table: <!-- scores --> and <!-- end of scores -->")
        found[path] = _PLACE.sub(lambda _: f"\n{scores(stored_results(docs)[_ENV])}\n\n", text)
    return found


def scores(results: Results) -> str:
    """The table in Markdown, with what its numbers are and where they come from."""
    rows = [[f"`{policy}`", words, *_cells(results.estimates, policy)] for policy, words in _POLICIES.items()]
    headings = ["policy", "what it does", *_COLUMNS]
    made = when_and_where(results.provenance)
    about = f"{results.config['suites']['default']['rigs']:,} random rigs in developed stick-slip, the same for all"
    return f"{markdown.table(headings, rows, words=2)}\n\n*{about}; 95 % intervals in brackets; {made}.*"


def _cells(estimates: Mapping[str, Any], policy: str) -> list[str]:
    columns: dict[str, Column] = {column.heading: column for column in MAIN.columns}
    found = []
    for suite, heading in _COLUMNS.values():
        row = stored_row(estimates[suite][policy]["main"])
        value, interval = cell(row[heading], columns[heading].digits)
        found.append(f"{value} ({interval.replace('-', ' to ')})" if interval else value)
    return found
