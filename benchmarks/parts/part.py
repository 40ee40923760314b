"""What the page shows of one benchmark, and how it writes tables and numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from drillrig_env.plots.style import Picture

OWN = "DrillRig"
"""How names of the project's own lines and rows begin."""

RIG, CARTPOLE = "DrillRig-v0", "CartPole-v1"

Results = Mapping[str, Any]
"""The results in a benchmark's JSON file."""


@dataclass(frozen=True)
class Part:
    """One benchmark on the page; `name` is that of its command and its JSON file.

    `result` gives what the top of the page says, pairs of what was measured and what came out, and `tables`
    blocks of Markdown. `plot` draws from results and words on where they were measured; `seen` says what the picture
    shows.
    """

    name: str
    heading: str
    about: str
    result: Callable[[Results], list[tuple[str, str]]]
    tables: Callable[[Results], list[str]]
    plot: Callable[[Results, str], Picture] | None = None
    seen: str = ""

    @property
    def command(self) -> str:
        """What measures it."""
        return f"python -m benchmarks.{self.name}"


def times(ratio: float) -> str:
    """A ratio as a reader wants it: 12,345 times, 123 times, 12 times, 1.2 times."""
    return f"{ratio:,.0f}" if ratio >= 9.95 else f"{ratio:.1f}" if ratio >= 0.095 else f"{ratio:.2g}"


def amount(value: float | None) -> str:
    """A number with three digits: 28.1 M, 242 k, 953."""
    if value is None:
        return "-"
    for unit, size in (("M", 1e6), ("k", 1e3)):
        if value >= 0.9995 * size:
            return f"{value / size:#.3g}".rstrip(".") + f" {unit}"
    return f"{value:.3g}"


def duration(seconds: float) -> str:
    """A time with its unit, two digits or whole seconds."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= 0.995 * size:
            value = seconds / size
            return f"{value:.0f} {unit}" if value >= 9.95 else f"{value:.1f} {unit}"
    return f"{seconds / 1e-9:.0f} ns"


def digits(value: float) -> str:
    """Three digits of a number, or all of its whole ones."""
    return f"{value:,.0f}" if value >= 99.95 else f"{value:.3g}"


def power(value: float) -> str:
    """An error or a tolerance: 1e-6."""
    return f"{value:.0e}".replace("e-0", "e-")
