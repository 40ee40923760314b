"""Write the pages that are made from committed results, or only check them.

    python -m docs.make                          # every page, with its pictures
    python -m docs.make results agents           # some of them
    python -m docs.make --check                  # write nothing; is every page what its results give?
    python -m docs.make results --take-in results/state results/surface
    python -m docs.make performance --take-in results/benchmarks

A page says only what stored results hold. `--take-in` puts new ones in their place first: folders of eval.py, or the
folder of the benchmarks. What a person has found is quoted from findings.md and notes.md beside the results.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from docs.make.page import PAGES
from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.files import check_writable, write_text
from drillrig_env.markdown import listed
from drillrig_env.parameters import closest


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Take results in, if folders are named, draw the pictures and write the pages; or only check them."""
    about = "\n".join(f"  {name:<12} {page.about}" for name, page in PAGES.items())
    parser = Parser(prog="python -m docs.make", description=f"{__doc__}\npages:\n{about}\n")
    add = parser.add_argument
    add("pages", nargs="*", metavar="PAGE", help=f"{', '.join(PAGES)} (default: all)")
    add("--check", action="store_true", help="write nothing; fail where a page is out of date")
    add("--no-pictures", action="store_true", help="write the text alone")
    add("--take-in", nargs="+", type=Path, metavar="DIR", default=[], help="results to put in their place first")
    add("--docs", type=Path, default=Path("docs"), help="folder of the documentation (default: docs)")
    chosen = parser.parse_args(arguments)
    for name in chosen.pages:
        if name not in PAGES:
            parser.error(f"page {name!r} is not known; {closest(name, PAGES)}")
    names = chosen.pages or list(PAGES)
    if chosen.check and chosen.take_in:
        parser.error("--take-in writes, --check does not; give one of them")
    if chosen.take_in and sum(PAGES[name].take_in is not None for name in names) != 1:
        allowed = listed((name for name, page in PAGES.items() if page.take_in), "or")
        parser.error(f"--take-in is for {allowed}, one of them")
    try:
        if chosen.check:
            check(names, chosen.docs)
        else:
            write(names, chosen.docs, chosen.take_in, pictures=not chosen.no_pictures)
    except ValueError as error:
        parser.error(error)


def check(names: Sequence[str], docs: Path) -> None:
    """Raise `Failed` naming the pages that are not what their results give."""
    late = [name for name in names if any(not _is(path, text) for path, text in PAGES[name].texts(docs).items())]
    if late:
        raise Failed(f"out of date: {', '.join(late)}; run: python -m docs.make {' '.join(late)}")


def write(names: Sequence[str], docs: Path, taken_in: Sequence[Path] = (), pictures: bool = True) -> None:
    """Write pages, after taking in the results of some folders, and draw their `pictures`."""
    check_writable(docs)
    for name in names:
        page = PAGES[name]
        for folder in taken_in:
            if page.take_in is not None:
                page.take_in(folder, docs)
        if pictures and page.draw is not None:
            page.draw(docs)  # first: a page shows the pictures that there are
        for path, text in page.texts(docs).items():
            write_text(path, text)
            print(path.resolve())


def _is(path: Path, text: str) -> bool:
    return path.is_file() and path.read_text(encoding="utf-8") == text


if __name__ == "__main__":
    raise SystemExit(main())
