"""The page's files: read once when the server starts, and served by name from memory, so that no path is ever asked."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from drillrig_env.command_line import Failed

WEB = Path(__file__).with_name("web")
PARTS = WEB / "parts"
"""Where the build puts what others have written; not in the repository."""

_KINDS = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}

NEEDED = ("uPlot.js", "uPlot.css")
"""The parts without which there is no page."""


@dataclass(frozen=True)
class PageFile:
    """A file of the page: its content, and its kind as a browser is told."""

    content: bytes
    kind: str


def page_files(web: Path = WEB) -> dict[str, PageFile]:
    """Every file of the page, by the path at which it is served. `Failed` where a part is missing, with the command."""
    for part in NEEDED:
        if not (web / PARTS.name / part).is_file():
            raise Failed(
                f"the page lacks its part {part}, which plots the lines; in a clone of DrillRig: `make room` brings it"
            )
    found = {
        f"/{path.relative_to(web).as_posix()}": PageFile(path.read_bytes(), _KINDS[path.suffix])
        for path in sorted(web.rglob("*"))
        if path.suffix in _KINDS and path.is_file() and not path.name.endswith(".d.ts")
    }
    return {"/": found["/index.html"], **found}
