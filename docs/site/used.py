"""Where public names are in use: in examples of docstrings, of pages and of the gallery, all of which the tests run."""

from __future__ import annotations

import ast
import doctest
import inspect
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

from docs.site.outside import GENERATED, ROOT
from docs.site.public import PROJECT, inherited, members_of, modules, names_of, shown_names

_BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
_HEADING = re.compile(r"^# (.+)$", re.MULTILINE)
_MADE = ("generated", "_build")
_SHOWN = 3


class Use(NamedTuple):
    """Code that runs: the page that has it as a link of the site, its title, the code, and the module that it is in."""

    link: str
    title: str
    code: str
    module: str = ""


def own_example(value: Any) -> bool:
    """Whether the docstring of a function or class, or that of one of its methods, has an example."""
    said = [inspect.getdoc(value) or ""]
    if inspect.isclass(value):
        said += [inherited(value, name) for name, _ in members_of(value)]
    return any(">>> " in text or "```python" in text for text in said)


def in_use(value: Any) -> list[str]:
    """Links to the first few pages that use a function or class, those that explain most first."""
    return list(dict.fromkeys(f"[{use.title}]({use.link})" for use in _users().get(_key(value), ())))[:_SHOWN]


def _key(value: Any) -> tuple[str, str]:
    return (str(getattr(value, "__module__", "")), str(getattr(value, "__qualname__", id(value))))


@cache
def _users() -> dict[tuple[str, str], list[Use]]:
    found: dict[tuple[str, str], list[Use]] = {}
    for use in uses():
        for value in named(use.code, use.module):
            found.setdefault(_key(value), []).append(use)
    return found


def uses() -> Iterator[Use]:
    """All code that is shown: of the gallery, of pages, and of docstrings."""
    for script in sorted((ROOT / "examples").glob("*.py")):
        text = script.read_text(encoding="utf-8")
        title = (ast.get_docstring(ast.parse(text)) or script.stem).splitlines()[0]
        yield Use(f"/{GENERATED}/gallery/{script.stem}.rst", title, text)
    for page in sorted((ROOT / "docs").rglob("*.md")):
        place = page.relative_to(ROOT / "docs")
        text = page.read_text(encoding="utf-8")
        if (blocks := _BLOCK.findall(text)) and place.parts[0] not in _MADE and (heading := _HEADING.search(text)):
            yield Use(f"/{place.as_posix()}", heading[1], "\n".join(blocks))
    for module in modules():
        said = [inspect.getdoc(import_module(module)) or ""]
        yield Use(f"/{GENERATED}/api/{module}.md", f"the top of `{module}`", _doctests(said), module)
    for one in shown_names().values():
        if callable(one.value) and (code := _doctests([inspect.getdoc(one.value) or ""])):
            yield Use(f"/{GENERATED}/api/{one.module}.md", f"`{one.name}`", code, one.home)


def _doctests(texts: list[str]) -> str:
    return "".join(example.source for text in texts for example in doctest.DocTestParser().get_examples(text))


def named(code: str, module: str = "") -> list[Any]:
    """The functions and classes that code names, in a `module` or by what it imports, and classes that they return."""
    names: dict[str, Any] = {one.name: one.value for one in names_of(module)} if module else {}
    found: list[Any] = []
    for node in ast.walk(ast.parse(code)):  # imports come first, as they are nearest to the root
        if isinstance(node, ast.Import):
            for one in node.names:
                if one.name.split(".")[0] in PROJECT:
                    import_module(one.name)
                    whole = one.name if one.asname else one.name.split(".")[0]
                    names[one.asname or whole] = import_module(whole)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in PROJECT:
            for one in node.names:
                names[one.asname or one.name] = _member(str(node.module), one.name)
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Name | ast.Attribute) and (value := _value(node, names)) is not None:
            found += [value, *_returned(value)]
    return found


def _returned(value: Any) -> list[type]:
    """The public classes that a function says it returns."""
    said = str(getattr(value, "__annotations__", {}).get("return", ""))
    classes = {one.name: one.value for one in shown_names().values() if inspect.isclass(one.value)}
    return [classes[word] for word in re.findall(r"\w+", said) if word in classes]


def _member(module: str, name: str) -> Any:
    owner = import_module(module)
    return getattr(owner, name) if hasattr(owner, name) else import_module(f"{module}.{name}")


def _value(node: ast.expr, names: dict[str, Any]) -> Any:
    if isinstance(node, ast.Name):
        return names.get(node.id)
    owner = _value(node.value, names) if isinstance(node, ast.Attribute) else None
    return getattr(owner, node.attr, None) if isinstance(node, ast.Attribute) and owner is not None else None
