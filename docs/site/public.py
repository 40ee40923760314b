"""What is public: the modules that the reference shows, and the names, arguments and sentences of each."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator
from enum import Enum
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

from sphinx.pycode import ModuleAnalyzer

PAGES: dict[str, tuple[str, ...]] = {
    "The rig, its friction and its runs": ("drillrig_env", "drillrig_env.model", "drillrig_env.reference"),
    "What the equations promise": ("drillrig_env.stability", "drillrig_env.verdict", "drillrig_env.indicators"),
    "The environments": ("drillrig_env.env.single", "drillrig_env.env.vector", "drillrig_env.env.sb3",
                         "drillrig_env.env.sensors", "drillrig_env.scales", "drillrig_env.lumps", "drillrig_env.seeds"),
    "Policies": ("baselines", "baselines.counted", "drillrig_env.policy"),
    "Comparing them": ("drillrig_env.evaluation.suites", "drillrig_env.evaluation.runner",
                       "drillrig_env.evaluation.scores", "drillrig_env.evaluation.statistics"),
    "Records, and hardware": ("drillrig_env.calibrate", "drillrig_env.calibrate.records", "drillrig_env.deploy",
                              "drillrig_env.twin.dry_run"),
    "The chapter": ("drillrig_env.validation", "drillrig_env.plots.figures"),
}  # fmt: skip
"""The modules of the reference, under headings."""

PROJECT = ("drillrig_env", "baselines")


class Name(NamedTuple):
    """A public name: the module that shows it, its own name, and what it is."""

    module: str
    name: str
    value: Any

    @property
    def full(self) -> str:
        """By which it is imported."""
        return f"{self.module}.{self.name}"

    @property
    def home(self) -> str:
        """The module that defines it."""
        return str(getattr(self.value, "__module__", None) or self.module)


class Member(NamedTuple):
    """A public function, class or method with its label, such as "Rig.of", and all that is said of its arguments."""

    label: str
    value: Any
    said: str


def modules() -> list[str]:
    """Every module of the reference."""
    return [module for group in PAGES.values() for module in group]


@cache
def names_of(module: str) -> tuple[Name, ...]:
    """The public names of a module: those of its `__all__`, or those that it defines without an underscore."""
    loaded = import_module(module)
    listed = getattr(loaded, "__all__", None)
    if listed is None:
        listed = [name for name, value in vars(loaded).items() if is_own(module, name, value)]
    found = [Name(module, name, getattr(loaded, name)) for name in listed]
    return tuple(one for one in found if not inspect.ismodule(one.value))


def is_own(module: str, name: str, value: Any) -> bool:
    """Whether a module defines a name for others: a function, a class, or a constant with a sentence below it."""
    if name.startswith("_") or name == "main":
        return False
    if inspect.isfunction(value) or inspect.isclass(value):
        return value.__module__ == module
    return bool(sentence_below(module, name))


@cache
def sentence_below(module: str, name: str) -> str:
    """The text below an assignment, "" where there is none; of a class's field where the name has a dot."""
    owner, _, field = name.rpartition(".")
    return "\n".join(ModuleAnalyzer.for_module(module).find_attr_docs().get((owner, field), [])).strip()


@cache
def shown_names() -> dict[str, Name]:
    """Every public name once, by its name where it is shown: at home if home is shown, or else where it comes first."""
    found: dict[str, Name] = {}
    seen: set[tuple[str, str]] = set()
    for module in modules():
        for one in names_of(module):
            key = (one.home, getattr(one.value, "__qualname__", one.full))
            if key not in seen and (one.home == module or one.home not in modules()):
                seen.add(key)
                found[one.full] = one
    return found


def is_error(value: Any) -> bool:
    """Whether something is a class of exceptions."""
    return inspect.isclass(value) and issubclass(value, BaseException)


def members_of(owner: type) -> Iterator[tuple[str, Any]]:
    """Public methods and properties of a class, its own and those of bases in the project that are not shown."""
    shown = {one.value for one in shown_names().values() if inspect.isclass(one.value)}
    found = set()
    for base in owner.__mro__:
        if base.__module__.split(".")[0] not in PROJECT or (base is not owner and base in shown):
            continue
        for name, value in vars(base).items():
            if name.startswith("_") or name in found:
                continue
            if inspect.isfunction(value) or isinstance(value, classmethod | staticmethod | property):
                found.add(name)
                yield name, value


def inherited(owner: type, name: str) -> str:
    """What a class, or the first of its bases, says of a method."""
    return next((text for base in owner.__mro__ if (text := inspect.getdoc(vars(base).get(name)) or "")), "")


def said_of(owner: type, name: str) -> str:
    """All that a class and its bases say of a method."""
    return "\n".join(inspect.getdoc(vars(base).get(name)) or "" for base in owner.__mro__ if name in vars(base))


def documented() -> Iterator[Member]:
    """Every public function, class and method."""
    for one in shown_names().values():
        if inspect.isclass(one.value):
            bases = [base for base in one.value.__mro__ if base.__module__.split(".")[0] in PROJECT]
            said = "\n".join([inspect.getdoc(base) or "" for base in bases] + [fields_said(base) for base in bases])
            yield Member(one.full, one.value, said)
            for name, value in members_of(one.value):
                if not isinstance(value, property):
                    yield Member(f"{one.full}.{name}", getattr(one.value, name), said_of(one.value, name))
        elif callable(one.value):
            yield Member(one.full, inspect.unwrap(one.value), inspect.getdoc(one.value) or "")


def fields_said(record: type) -> str:
    """The names of those fields of a record that are documented where they stand."""
    if not dataclasses.is_dataclass(record):
        return ""
    said = [item.name for item in dataclasses.fields(record) if item.metadata.get("meaning")]
    below = [item.name for item in dataclasses.fields(record) if field_below(record, item.name)]
    return "\n".join(said + below)


def field_below(owner: type, name: str) -> str:
    """The text below a field, or the comment behind it, in the class that defines it."""
    for base in owner.__mro__:
        if base.__module__.split(".")[0] in PROJECT and (
            text := sentence_below(base.__module__, f"{base.__qualname__}.{name}")
        ):
            return text
    return ""


def arguments_of(value: Any) -> list[str]:
    """The names of the arguments of a function or class, as one gives them; what nobody makes has none."""
    if inspect.isclass(value) and (issubclass(value, BaseException | Enum) or getattr(value, "_is_protocol", False)):
        return []
    return [name for name in inspect.signature(value).parameters if name not in ("self", "cls") and name[0] != "_"]
