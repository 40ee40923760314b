"""The reference of the code: a page a public module, written from signatures, docstrings and documented fields."""

from __future__ import annotations

import dataclasses
import inspect
import re
import sys
from importlib import import_module
from typing import Any

from docs.site.docstrings import as_markdown
from docs.site.public import (
    PAGES,
    PROJECT,
    Name,
    field_below,
    inherited,
    is_error,
    members_of,
    names_of,
    sentence_below,
    shown_names,
)
from docs.site.used import in_use, own_example
from drillrig_env.markdown import table
from drillrig_env.parameters import field_rows

_LONG = 40  # characters of a default that a signature shows
_PLAIN = re.compile(r"[\w.\"'()\[\]{}:, +*/-]+")


def index() -> str:
    """The page that lists the pages of the reference, with the first sentence of each module."""
    parts = ["# The code, name by name", _ABOUT]
    for heading, modules in PAGES.items():
        rows = [(f"[`{module}`]({module}.md)", first_sentence(module)) for module in modules]
        parts += [f"## {heading}", table(("Module", "What is in it"), rows, words=2)]
    listed = "\n".join(module for modules in PAGES.values() for module in modules)
    return "\n\n".join([*parts, f"```{{toctree}}\n:hidden:\n\n{listed}\n```"]) + "\n"


_ABOUT = """\
Every public name of `drillrig_env` and `baselines`: what it is given, with shape and unit, what it returns, and what it
raises. The pages are made from the code, and a test fails for an argument that is not named there. Where a name
is imported from is the title of its page."""


def first_sentence(module: str) -> str:
    """What a module says of itself first."""
    text = " ".join((inspect.getdoc(import_module(module)) or "").split("\n\n")[0].split())
    return text.split(": ", 1)[-1] if text.startswith("DrillRig: ") else text


def page(module: str) -> str:
    """The page of a module."""
    own = [one for one in shown_names().values() if one.module == module]
    elsewhere = [one for one in names_of(module) if one not in own]
    about = as_markdown(inspect.getdoc(import_module(module)) or "", known(), module)
    parts = [f"# `{module}`", about, f"```{{py:module}} {module}\n```"]
    parts += [_entry(one) for one in own]
    if elsewhere:
        links = ", ".join(f"{{py:obj}}`{one.name} <{_shown_as(one)}>`" for one in elsewhere)
        parts.append(f"The same as elsewhere: {links}.")
    return "\n\n".join(parts) + "\n"


def known() -> set[str]:
    """All that the reference has an entry for."""
    found = set(shown_names())
    for one in shown_names().values():
        if inspect.isclass(one.value):
            found |= {f"{one.full}.{name}" for name, _ in members_of(one.value)}
    return found


def _shown_as(one: Name) -> str:
    key = (one.home, getattr(one.value, "__qualname__", one.full))
    for full, other in shown_names().items():
        if key == (other.home, getattr(other.value, "__qualname__", other.full)):
            return full
    raise LookupError(one.full)


def _entry(one: Name) -> str:
    if inspect.isclass(one.value):
        return _class(one)
    if callable(one.value) and not isinstance(one.value, type):
        function = inspect.unwrap(one.value)
        if inspect.isfunction(function):
            text = as_markdown(inspect.getdoc(one.value) or "", known(), one.module) + _where_used(one)
            return _directive("function", signature(one.name, function), text, _canonical(one))
    return _directive("data", one.name, as_markdown(_of_data(one), known(), one.module))


def _where_used(one: Name) -> str:
    """Where a name is in use that has no example of its own."""
    links = [] if own_example(one.value) else in_use(one.value)
    return f"\n\nIn use: {', '.join(links)}." if links else ""


def _of_data(one: Name) -> str:
    """What stands below a constant, wherever in the project it is defined."""
    ours = [name for name in sys.modules if name.split(".")[0] in PROJECT]
    for module in (one.module, *ours):
        same = vars(sys.modules[module]).get(one.name) is one.value
        if same and (text := sentence_below(module, one.name)):
            return text
    raise LookupError(f"{one.full} has no sentence below it")


def _class(one: Name) -> str:
    owner = one.value
    text = as_markdown(inspect.getdoc(owner) or "", known(), one.module)
    parts = [text]
    parts.append(_fields(owner, one.module))
    for name, value in members_of(owner):
        said = as_markdown(inherited(owner, name), known(), one.module)
        if isinstance(value, property):
            kind = value.fget.__annotations__.get("return", "") if value.fget else ""
            parts.append(_directive("property", name, said, f":type: {kind}" if kind else ""))
        else:
            options = next((f":{k.__name__}:" for k in (classmethod, staticmethod) if isinstance(value, k)), "")
            parts.append(_directive("method", signature(name, getattr(owner, name)), said, options))
    kind = "exception" if is_error(owner) else "class"
    shown = one.name if is_error(owner) else signature(one.name, owner, returns=False)
    content = "\n\n".join(part for part in parts if part) + _where_used(one)
    return _directive(kind, shown, content, _canonical(one))


def _fields(record: type, module: str) -> str:
    """A table of the fields of a record, of those that are documented where they stand."""
    if not dataclasses.is_dataclass(record):
        return ""
    items = dataclasses.fields(record)
    if all(item.metadata.get("meaning") for item in items):
        rows = [(f"`{row[0]}`", *row[1:]) for row in field_rows(record)]
        return table(("Field", "Default", "Unit", "Allowed", "Meaning"), rows, words=5)
    said = [
        (f"`{item.name}`", as_markdown(field_below(record, item.name), known(), module))
        for item in items
        if field_below(record, item.name)
    ]
    return table(("Field", "Meaning"), said, words=2) if said else ""


def signature(name: str, value: Any, returns: bool = True) -> str:
    """A signature with its annotations as they are written, and defaults as far as they can be shown."""
    given = inspect.signature(value)
    parts, keyword_only = [], False
    for one in given.parameters.values():
        if one.name in ("self", "cls"):
            continue
        if one.kind is one.KEYWORD_ONLY and not keyword_only:
            parts.append("*")
        keyword_only |= one.kind in (one.KEYWORD_ONLY, one.VAR_POSITIONAL)
        parts.append(_argument(one))
    back = given.return_annotation
    arrow = f" -> {_written(back)}" if returns and back is not inspect.Signature.empty else ""
    return f"{name}({', '.join(parts)}){arrow}"


def _argument(one: inspect.Parameter) -> str:
    stars: dict[Any, str] = {one.VAR_POSITIONAL: "*", one.VAR_KEYWORD: "**"}
    text = stars.get(one.kind, "") + one.name
    if one.annotation is not one.empty:
        text += f": {_written(one.annotation)}"
    if one.default is not one.empty:
        default = repr(one.default)
        text += f" = {default if _PLAIN.fullmatch(default) and len(default) <= _LONG else '...'}"
    return text


def _written(annotation: Any) -> str:
    return annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)


def _canonical(one: Name) -> str:
    full = f"{one.home}.{getattr(one.value, '__qualname__', one.name)}"
    return "" if full == one.full else f":canonical: {full}"


def _directive(kind: str, argument: str, content: str, options: str = "") -> str:
    """A directive of Sphinx's, fenced with more ticks than are within."""
    ticks = "`" * (1 + max((len(run) for run in re.findall(r"^`{3,}", content, re.MULTILINE)), default=2))
    return "\n".join([f"{ticks}{{py:{kind}}} {argument}", *([options] if options else []), "", content, ticks])
