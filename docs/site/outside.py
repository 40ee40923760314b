"""Pages that lie outside `docs` and belong to the site: the cards of the agents, the changes, how to contribute."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
GENERATED = "generated"

_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]*)(#[^)\s]*)?\)")


def pages() -> dict[str, Path]:
    """The name of each such page in the site, without suffix, and its file."""
    cards = {f"{GENERATED}/agents/{card.parent.name}": card for card in sorted(ROOT.glob("agents/trained/*/README.md"))}
    others = {"changes": "CHANGELOG.md", "contributing": "CONTRIBUTING.md"}
    return cards | {f"{GENERATED}/{name}": ROOT / file for name, file in others.items()}


def text_of(file: Path) -> str:
    """The text of a page outside, with its links as the site has them."""
    return relinked(file.read_text(encoding="utf-8"), file)


def relinked(text: str, file: Path) -> str:
    """The text of a page of the repository with links that hold in the site.

    Those to pages of the site lead there, wherever the page itself is; those to folders and to files outside `docs`
    become the words alone, as they lead nowhere without the repository.
    """
    places = {path: name for name, path in pages().items()}

    def led(found: re.Match[str]) -> str:
        mark, words, target, anchor = found[1], found[2], found[3], found[4] or ""
        if not target or ":" in target:
            return found[0]
        path = (file.parent / target).resolve()
        if path in places:
            return f"{mark}[{words}](/{places[path]}.md{anchor})"
        if path.parent == ROOT / "examples":
            return f"[{words}](/{GENERATED}/gallery/{path.stem}.rst)"
        if path == ROOT / "README.md":
            return f"{mark}[{words}](/index.md)"
        if path.is_dir() or not path.is_relative_to(ROOT / "docs"):
            return words if path.exists() else found[0]
        return f"{mark}[{words}](/{path.relative_to(ROOT / 'docs').as_posix()}{anchor})"

    parts = re.split(r"(```.*?```)", text, flags=re.DOTALL)
    return "".join(part if part.startswith("```") else _LINK.sub(led, part) for part in parts)
