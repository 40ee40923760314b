"""Python files of the user's own, as modules."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from drillrig_env.parameters import closest

T = TypeVar("T")

_OF_THE_USER: list[str] = []


def of_the_user() -> tuple[str, ...]:
    """The names of the modules that files of the user's own have become: no other process has them."""
    return tuple(_OF_THE_USER)


def load_module(file: Path) -> ModuleType:
    """A Python file as a module, which may import from its own folder; `ValueError` for what is none."""
    place = file.resolve()
    name = f"{file.stem}_{hashlib.sha256(str(place).encode()).hexdigest()[:8]}"  # hides no other module
    spec = importlib.util.spec_from_file_location(name, place)
    if spec is None or spec.loader is None:
        raise ValueError(f"{file} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    if name not in _OF_THE_USER:
        _OF_THE_USER.append(name)
    sys.path.insert(0, str(place.parent))
    try:
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(place.parent))
    return module


def is_place(given: Any) -> bool:
    """Whether something is a text such as "file.py:name"."""
    return isinstance(given, str) and given.rpartition(":")[0].endswith(".py")


def found_in(source: str, kind: type[T], what: str) -> T:
    """The one of a `kind` that a Python file holds under a name: "file.py:name".

    It is the same one for as long as the file is the same. `what` says in words what it is. Raises `ValueError` where
    there is none.
    """
    file, _, name = source.rpartition(":")
    if not Path(file).is_file():
        raise ValueError(f"{what} {source!r} is not known: there is no file {file}")
    module = _unchanged(Path(file).resolve(), Path(file).read_bytes())
    found = {key: value for key, value in vars(module).items() if isinstance(value, kind)}
    if name not in found:
        hint = closest(name, found)
        raise ValueError(f"{what} {source!r} is not known: {file} has no {kind.__name__} {name!r}; {hint}")
    return found[name]


@cache
def _unchanged(file: Path, _text: bytes) -> ModuleType:
    return load_module(file)
