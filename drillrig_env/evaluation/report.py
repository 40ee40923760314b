"""The comparison as a table in the terminal, as `results.csv` and as `results.json` with its provenance."""

from __future__ import annotations

import csv
import json
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.evaluation.statistics import Estimate, mean, median, rate

Scores = Mapping[str, npt.NDArray[Any]]

_COLUMNS = (
    ("mitigated", "mitigated", rate, 3),
    ("below ω_c", "mitigated", rate, 3),
    ("above ω_c", "mitigated", rate, 3),
    ("calm", "calm", rate, 3),
    ("to calm", "time_to_calm", median, 1),
    ("cost", "cost", mean, 3),
    ("stuck", "stuck", mean, 3),
    ("peak speed", "peak_speed", median, 2),
    ("peak torque", "peak_torque", median, 2),
    ("travel, rad/s", "travel", median, 1),
)
"""Heading, score, statistic and digits of every column; two columns look at one region only."""

_IN_TERMINAL = 6
"""Columns that the terminal's table shows, so that it fits 80 characters; files have all."""

_REGIONS = {"below ω_c": "below", "above ω_c": "above"}


def estimates(scores: Scores) -> dict[str, Estimate]:
    """The estimate of every column of the table for one policy, by heading."""
    found = {}
    for heading, name, statistic, _ in _COLUMNS:
        region = _REGIONS.get(heading)
        chosen = scores["region"] == region if region else np.ones(len(scores[name]), dtype=bool)
        found[heading] = statistic(scores[name][chosen])
    return found


def markdown_table(results: Mapping[str, Scores], told: Mapping[str, bool]) -> str:
    """The table in Markdown, a row a policy; intervals at 95 % behind the values."""
    headings = [heading for heading, *_ in _COLUMNS]
    lines = ["| policy | " + " | ".join(headings) + " |", "|---" * (len(headings) + 1) + "|"]
    for policy, scores in results.items():
        cells = (f"{value} ({interval})" if interval else value for value, interval in _cells(scores))
        lines.append(f"| {_label(policy, told)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def print_table(title: str, results: Mapping[str, Scores], told: Mapping[str, bool]) -> None:
    """Print the first columns of the table in the terminal; needs `rich`, of the extra `agents`."""
    from rich.console import Console
    from rich.table import Table

    caption = "below: 95 % interval; to calm: median, s; cost: mean"
    if any(told.get(policy) for policy in results):
        caption += "; * told the friction"
    table = Table(title=title, caption=caption, box=None, padding=(0, 1, 0, 0), pad_edge=False, caption_justify="left")
    table.add_column("policy", no_wrap=True)
    for heading, *_ in _COLUMNS[:_IN_TERMINAL]:
        table.add_column(heading, justify="right", no_wrap=True)
    for policy, scores in results.items():
        cells = _cells(scores)[:_IN_TERMINAL]
        table.add_row(_label(policy, told), *("\n".join(cell) for cell in cells))
    console = Console()
    console.width = max(console.width, 80)
    console.print(table)


def write_csv(path: Path, results: Mapping[str, Mapping[str, Scores]]) -> None:
    """One row an episode: suite, policy, rig and scores. `results` is by suite, then by policy."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = None
        for suite, policies in results.items():
            for policy, scores in policies.items():
                if writer is None:
                    writer = csv.writer(file, lineterminator="\n")
                    writer.writerow(["suite", "policy", "episode", *scores])
                for episode, row in enumerate(zip(*(column.tolist() for column in scores.values()), strict=True)):
                    writer.writerow([suite, policy, episode, *(_plain(value) for value in row)])


def write_json(path: Path, config: Mapping[str, Any], results: Mapping[str, Mapping[str, Scores]]) -> None:
    """What made the results, and every estimate of the table with its interval."""
    table = {
        suite: {
            policy: {heading: vars(estimate) for heading, estimate in estimates(scores).items()}
            for policy, scores in policies.items()
        }
        for suite, policies in results.items()
    }
    content = {"config": dict(config), "provenance": provenance(), "estimates": table}
    path.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def provenance() -> dict[str, Any]:
    """Versions, machine and date: what an artefact needs to be made again."""
    packages = ("drillrig", "gymnasium", "numpy", "scipy", "numba", "stable-baselines3", "torch")
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
        "versions": {package: _version(package) for package in packages},
    }


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _cells(scores: Scores) -> list[tuple[str, str]]:
    """Value and interval of every column as text; the interval with a digit less."""
    cells = []
    for estimate, (*_, digits) in zip(estimates(scores).values(), _COLUMNS, strict=True):
        if estimate.count == 0:
            cells.append(("none", ""))
            continue
        fewer = max(digits - 1, 1)
        interval = f"{estimate.low:.{fewer}f}-{estimate.high:.{fewer}f}" if estimate.low != estimate.high else ""
        cells.append((f"{estimate.value:.{digits}f}", interval))
    return cells


def _label(policy: str, told: Mapping[str, bool]) -> str:
    return f"{policy} *" if told.get(policy) else policy


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return f"{value:.6g}"
    return int(value) if isinstance(value, bool) else value
