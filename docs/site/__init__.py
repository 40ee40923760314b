"""The extension of Sphinx: writes the pages that are made when the site is built, and mends links that lead outside."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

from docs.site import api, outside, records
from docs.site.accessible import mend_pages
from docs.site.public import modules

_API = f"{outside.GENERATED}/api"


def setup(app: Sphinx) -> dict[str, Any]:
    """What Sphinx calls."""
    app.connect("config-inited", lambda app, _config: write_pages(Path(app.srcdir)))
    app.connect("source-read", _mend_links)
    app.connect("build-finished", _mend_pages)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


def made() -> dict[str, str]:
    """Every page that is made, by its name without suffix."""
    found = {name: outside.text_of(file) for name, file in outside.pages().items()}
    found |= {f"{_API}/{module}": api.page(module) for module in modules()}
    found[f"{_API}/index"] = api.index()
    return found | {f"{outside.GENERATED}/{name}": text for name, text in records.pages().items()}


def write_pages(source: Path) -> None:
    """Write all that is made; what has not changed keeps its time, so that Sphinx need not read it again."""
    wanted = {source / f"{name}.md": text for name, text in made().items()}
    for path, text in wanted.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
    for path in (source / outside.GENERATED).rglob("*.md"):
        if path not in wanted:
            path.unlink()


def _mend_pages(app: Sphinx, error: Exception | None) -> None:
    if error is None:
        mend_pages(Path(app.outdir))


def _mend_links(app: Sphinx, name: str, content: list[str]) -> None:
    if not name.startswith(outside.GENERATED) and (page := Path(app.srcdir, f"{name}.md")).exists():
        content[0] = outside.relinked(content[0], page)
