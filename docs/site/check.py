"""Check the pages of the built site: every link inside leads somewhere, nothing is fetched, pictures have a text.

python -m docs.site.check docs/_build/html
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from drillrig_env.command_line import Failed, Parser, command

_FETCHED = {("script", "src"), ("img", "src"), ("link", "href"), ("iframe", "src"), ("source", "src")}


class Page(HTMLParser):
    """A page of the site: anchors, links, what it fetches, and pictures without a text."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.silent: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take note of a tag's attributes."""
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        self.fetched += [given[name] for kind, name in _FETCHED if kind == tag and name in given]
        if tag == "img" and "alt" not in given:
            self.silent.append(given.get("src", ""))


def faults(site: Path) -> Iterator[str]:
    """A sentence for each fault of the site in a folder."""
    pages = {path.resolve(): Page(path) for path in sorted(site.rglob("*.html"))}
    for path, page in pages.items():
        where = path.relative_to(site.resolve())
        for target in page.fetched:
            if urlsplit(target).scheme not in ("", "data") or target.startswith("//"):
                yield f"{where} fetches {target}"
            elif not target.startswith("data:") and not _file(path, target).exists():
                yield f"{where} wants {target}, which is not there"
        for target in page.links:
            parts = urlsplit(target)
            if parts.scheme or target.startswith("//"):
                continue
            file = _file(path, target)
            if not file.exists():
                yield f"{where} links to {target}, which is not there"
            elif parts.fragment and file in pages and unquote(parts.fragment) not in pages[file].anchors:
                yield f"{where} links to {target}, and there is no such place on that page"
        for source in page.silent:
            yield f"{where} has a picture without a text: {source}"


def _file(page: Path, target: str) -> Path:
    """The file that a link of a page leads to."""
    path = unquote(urlsplit(target).path)
    return (page.parent / path).resolve() if path else page


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Check a site; fail with a line for each fault."""
    parser = Parser(prog="python -m docs.site.check", description=__doc__)
    parser.add_argument("site", type=Path, help="the folder of the built pages")
    site = parser.parse_args(arguments).site
    if not (site / "index.html").is_file():
        parser.error(f"{site} has no index.html")
    if found := sorted(set(faults(site))):
        raise Failed("\n".join([*found, f"{len(found)} faults"]))


if __name__ == "__main__":
    raise SystemExit(main())
