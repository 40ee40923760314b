"""The pages that are made from committed results: where each stands, what it says, and what is drawn for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from agents.policy.run_folder import TRAINED, shipped
from agents.shipping.card import CARD, card
from docs.make import agents, performance, readme, results, validation


@dataclass(frozen=True)
class Page:
    """A page, or several that are made alike.

    `texts` gives what stands in each file, from the folder of the documentation; `draw` draws the pictures, and
    `take_in` puts the results of a folder where the page finds them, where it has such.
    """

    about: str
    texts: Callable[[Path], Mapping[Path, str]]
    draw: Callable[[Path], object] | None = None
    take_in: Callable[[Path, Path], None] | None = None


def _one(name: str, text: Callable[[Path], str]) -> Callable[[Path], Mapping[Path, str]]:
    return lambda docs: {docs / name: text(docs)}


def _cards(_docs: Path) -> dict[Path, str]:
    return {TRAINED / name / CARD: card(name) for name in shipped()}


PAGES: dict[str, Page] = {
    "readme": Page("the table of README.md and docs/index.md, from docs/results", readme.texts),
    "results": Page(
        "docs/results.md, from docs/results, which takes in what eval.py leaves",
        _one("results.md", results.page),
        results.draw_pictures,
        results.take_in,
    ),
    "agents": Page(
        "docs/agents.md, from agents/trained, docs/agents and docs/results",
        _one("agents.md", agents.page),
        agents.draw_pictures,
    ),
    "cards": Page("the card of every shipped agent, from agents/trained", _cards),
    "performance": Page(
        "docs/performance.md, from docs/performance, which takes in what the benchmarks leave",
        _one("performance.md", performance.page),
        performance.draw_pictures,
        performance.take_in,
    ),
    "validation": Page(
        "docs/validation.md, from the model and the chapter's numbers",
        _one("validation.md", lambda _: validation.page()),
    ),
}
"""Every page by name."""
