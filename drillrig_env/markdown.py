"""How pages and terminals are given tables and lists: the one way of the whole project."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence


def table(headings: Sequence[str], rows: Iterable[Sequence[object]], words: int | Collection[str] = 1) -> str:
    """A table in Markdown, with a row for each of `rows`, whose entries are written as text.

    `words` are the columns of words, which are set to the left: how many come first, or their headings. All
    others are set to the right, as numbers are. Bars and line ends within an entry do not end it.

    >>> print(table(["policy", "mitigated"], [["constant", 0.36]]))
    | policy | mitigated |
    |---|---:|
    | constant | 0.36 |
    """
    left = headings[:words] if isinstance(words, int) else words
    rule = "".join("|---" if heading in left else "|---:" for heading in headings) + "|"
    cells = ([" ".join(str(entry).split()).replace("|", "\\|") for entry in row] for row in rows)
    return "\n".join([_line(headings), rule, *map(_line, cells)])


def listed(parts: Iterable[object], last: str = "and") -> str:
    """Words or numbers as a sentence lists them: "a, b and c".

    >>> listed([300, 1000, 2000], "or")
    '300, 1000 or 2000'
    """
    *others, end = [str(part) for part in parts]
    return f"{', '.join(others)} {last} {end}" if others else end


def sentence(text: str) -> str:
    """A caption as a sentence: its first letter large, a full stop behind it.

    >>> sentence("to calm: median, s")
    'To calm: median, s.'
    """
    return f"{text[0].upper()}{text[1:]}."


def _line(entries: Iterable[str]) -> str:
    return "|" + "".join(f" {entry} |" if entry else " |" for entry in entries)
