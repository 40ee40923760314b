"""The list of contents of a long page: a link to each of its parts, before the first of them."""

from __future__ import annotations

import re

_FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
_PART = re.compile(r"^(##|###) (.+)$", re.MULTILINE)
_LEAST = 2  # parts of a part that are worth a link each


def with_contents(text: str) -> str:
    r"""A page with the list of its parts before the first of them; what is short within a part stands behind its link.

    >>> print(with_contents("# Page\n\nWhat it says.\n\n## One `a`\n\n## Two: `python -m b`"))
    # Page
    <BLANKLINE>
    What it says.
    <BLANKLINE>
    - [One `a`](#one-a)
    - [Two](#two-python--m-b)
    <BLANKLINE>
    ## One `a`
    <BLANKLINE>
    ## Two: `python -m b`
    """
    lines: list[tuple[str, list[str]]] = []
    for mark, heading in _PART.findall(_FENCED.sub("", text)):
        link = f"[{_label(mark, heading)}](#{anchor(heading)})"
        if mark == "##":
            lines.append((link, []))
        elif lines:
            lines[-1][1].append(link)
    listed = "\n".join(f"- {link}" + (f": {', '.join(parts)}" if len(parts) >= _LEAST else "") for link, parts in lines)
    if not lines:
        return text
    place = text.index("\n## ") + 1
    return f"{text[:place]}{listed}\n\n{text[place:]}"


def anchor(heading: str) -> str:
    """By what code hosts, and the site, know a heading: small letters, no punctuation, hyphens for spaces."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def _label(mark: str, heading: str) -> str:
    """A heading in a list: without the command behind it; of a suite its name alone."""
    named = re.search(r"suite (`[^`]+`)", heading) if mark == "###" else None
    return named[1] if named else re.sub(r"^.*?: (?=who|where)|: `python .*$", "", heading)
