"""What the benchmarks share: medians of repeated timings, the machine's name, a table and a JSON file."""

from __future__ import annotations

import json
import platform
import statistics
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from drillrig_env.evaluation.provenance import provenance


def median_seconds(work: Callable[[], object], repeats: int) -> float:
    """Median wall time of `work` over `repeats` runs after one that is not counted."""
    work()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def machine() -> str:
    """The processor's name, as far as the system tells it."""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def print_table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a Markdown table."""
    print("| " + " | ".join(headings) + " |")
    print("|" + "---|" * len(headings))
    for row in rows:
        print("| " + " | ".join(row) + " |")


def write_json(path: Path, results: dict[str, Any]) -> None:
    """Write results beside machine, versions and date."""
    path.parent.mkdir(parents=True, exist_ok=True)
    content = {"machine": machine(), "provenance": provenance(), "results": results}
    path.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    print(f"\n{machine()}; written to {path}")
