"""docs/performance.md and its pictures, from what the benchmarks have left.

The JSON files lie beside the page in performance/, its pictures in images/performance/. A benchmark that is not
in the folder keeps what was taken in before; one that has never run is named with its command. What a person says
about a part is quoted from performance/notes.md, where a heading such as `## solvers` begins each part's words.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.measure import note
from benchmarks.parts import PARTS, Part
from docs.make.contents import with_contents
from drillrig_env import markdown
from drillrig_env.evaluation.pictures import draw
from drillrig_env.evaluation.provenance import in_words

COMMAND = "python -m docs.make performance"
_STORE = "performance"
NOT_UNDERSTOOD = (AttributeError, IndexError, KeyError, TypeError, ValueError)
"""What comes of a file that another version of a benchmark has written, or of one that was stopped very early."""

_INTRODUCTION = f"""# Performance

Everything here was measured by commands of this repository, each with all its peers in one run; times are medians.
Machines differ: quote the ratios. This page and its pictures come from the stored figures with `{COMMAND}`.
"""


def take_in(folder: Path, docs: Path) -> None:
    """Copy the benchmarks' files to where the page finds them; one that cannot be read stays out."""
    store = docs / _STORE
    store.mkdir(parents=True, exist_ok=True)
    if folder.resolve() == store.resolve():
        return
    for part in PARTS:
        source = folder / f"{part.name}.json"
        if read(source) is not None:
            shutil.copyfile(source, store / source.name)
        else:
            note(f"{source} is not there or cannot be read; {part.command} writes it")


def read(path: Path) -> dict[str, Any] | None:
    """What a benchmark wrote; None where there is nothing that can be read."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return content if isinstance(content, dict) and {"results", "provenance"} <= content.keys() else None


def page(docs: Path) -> str:
    """The page as Markdown."""
    store = docs / _STORE
    found = {part.name: content for part in PARTS if (content := read(store / f"{part.name}.json")) is not None}
    words = notes(store / "notes.md")
    result = [line for part in PARTS for line in _result(part, found)]
    parts = [_INTRODUCTION, *([markdown.table(["what", "result"], result, words=2) + "\n"] if result else [])]
    if "result" in words:
        parts.append(f"{words['result']}\n")
    parts += [_section(part, found.get(part.name), words.get(part.name, ""), docs) for part in PARTS]
    return with_contents("\n".join([*parts, _made(found)]))


def notes(path: Path) -> dict[str, str]:
    """A person's words by the name of the part that they are about; none where there is no such file."""
    if not path.is_file():
        return {}
    pieces = re.split(r"^## (.+)$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    return {name.strip(): words.strip() for name, words in zip(pieces[::2], pieces[1::2], strict=True)}


def _result(part: Part, found: Mapping[str, Any]) -> list[tuple[str, str]]:
    try:
        return part.result(found[part.name]["results"]) if part.name in found else []
    except NOT_UNDERSTOOD:
        return []


def _section(part: Part, content: Mapping[str, Any] | None, words: str, docs: Path) -> str:
    """One part: how it was measured, tables, picture, and what a person says about it."""
    head = f"## {part.heading}: `{part.command}`\n"
    if content is None:
        return f"{head}\nNot measured yet: run `{part.command}`, then `{COMMAND}`.\n"
    results = content["results"]
    try:
        tables = part.tables(results)
    except NOT_UNDERSTOOD:
        return f"{head}\nThe stored figures are those of another version: run `{part.command}`, then `{COMMAND}`.\n"
    blocks = [part.about, *(["*A first look, with --quick.*"] if results.get("quick") else []), *tables]
    picture = _picture_of(part, docs)
    if picture.is_file():
        blocks.append(f"![{part.seen}]({picture.relative_to(docs).as_posix()})")
    if results.get("left_out"):
        blocks.append("\n".join(f"- {hint}." for hint in results["left_out"]))
    return "\n\n".join([head.strip(), *blocks, *([words] if words else [])]) + "\n"


def _picture_of(part: Part, docs: Path) -> Path:
    return docs / "images" / _STORE / f"{part.name}.png"


def draw_pictures(docs: Path) -> list[Path]:
    """Draw a picture of each part that has one, and list them; the old one of a part that cannot be drawn goes."""
    paths = []
    for part in PARTS:
        content = read(docs / _STORE / f"{part.name}.json")
        picture = _picture_of(part, docs)
        if part.plot is None:
            continue
        try:
            if content is None:
                raise ValueError(f"{part.name} has not been measured")
            words = f"{machine_of(content)}, {content['provenance']['date']}.".replace(
                " core", "\N{NO-BREAK SPACE}core"
            )
            paths += draw(partial(part.plot, content["results"], words), picture.parent, part.name)
        except NOT_UNDERSTOOD as error:
            note(f"no picture of {part.name}: {error}")
            picture.unlink(missing_ok=True)
    return paths


def machine_of(content: Mapping[str, Any]) -> str:
    """System, processor and cores on which a benchmark ran."""
    return str(content["provenance"]["machine"])


def _made(found: Mapping[str, Any]) -> str:
    """Command, date, machine and versions of every part."""
    lines = ["## How it was made\n"]
    for part in PARTS:
        if part.name in found:
            beside = found[part.name]["results"].get("versions")
            lines.append(f"- `{part.command}`: {in_words(found[part.name]['provenance'], beside)}.")
    return "\n".join(lines if len(lines) > 1 else [*lines, "Nothing has been measured yet."]) + "\n"
