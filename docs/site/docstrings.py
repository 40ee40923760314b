"""Docstrings as Markdown for the reference: examples fenced, headings as paragraphs, names as links."""

from __future__ import annotations

import re
from collections.abc import Container

_HEADING = re.compile(r"^#+ (.*)$")
_CODE = re.compile(r"(`+)(.+?)\1")


def as_markdown(text: str, known: Container[str] = (), module: str = "") -> str:
    """A docstring, without its indentation, as Markdown that may stand within a directive of Sphinx.

    What doctest would run, `>>> ...` and the lines of output behind it, becomes a block of code; a heading a paragraph
    in bold. A name in code becomes a link where it, or `module`'s name of it, is in `known`.
    """
    lines: list[str] = []
    example = False
    for line in text.splitlines():
        if example and not line.strip():
            lines.append("```")
            example = False
        if not example and line.startswith(">>> "):
            lines.append("```pycon")
            example = True
        if example or line.startswith("    "):
            lines.append(line)
        elif heading := _HEADING.match(line):
            lines.append(f"**{heading[1]}**")
        else:
            lines.append(_CODE.sub(lambda found: _linked(found, known, module), line))
    if example:
        lines.append("```")
    return "\n".join(lines)


def _linked(found: re.Match[str], known: Container[str], module: str) -> str:
    name = found[2]
    for full in (name, f"{module}.{name}", f"drillrig_env.{name}", f"drillrig_env.stability.{name}"):
        if full in known:
            return f"{{py:obj}}`{name} <{full}>`"
    return found[0]
