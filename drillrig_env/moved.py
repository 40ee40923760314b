"""Modules that have moved: their former names work for one version, with a `DeprecationWarning`."""

from __future__ import annotations

import importlib
import sys
import warnings
from collections.abc import Mapping, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import CodeType, ModuleType
from typing import Any


class _FormerName(Loader):
    """Loads the module that a former name stands for now."""

    def __init__(self, former: str, name: str) -> None:
        self.former, self.name = former, name
        self.own_spec: ModuleSpec | None = None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """The module under its name of today."""
        warnings.warn(f"{self.former} is now {self.name}", DeprecationWarning, stacklevel=2)
        module = importlib.import_module(self.name)
        self.own_spec = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Nothing: the module has been executed under its own name. It keeps its own spec."""
        module.__spec__ = self.own_spec
        sys.modules[self.former] = module

    def get_code(self, fullname: str) -> CodeType | None:
        """What `python -m` runs."""
        loader: Any = getattr(find_spec(self.name), "loader", None)
        warnings.warn(f"{self.former} is now {self.name}", DeprecationWarning, stacklevel=2)
        code: CodeType | None = loader.get_code(self.name)
        return code


class _FormerNames(MetaPathFinder):
    """Finds the former names of modules."""

    def __init__(self, moved: Mapping[str, str]) -> None:
        self.moved = moved

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """A spec for a former name, and none for any other."""
        name = self.moved.get(fullname)
        return None if name is None else ModuleSpec(fullname, _FormerName(fullname, name))


def keep_former_names(moved: Mapping[str, str]) -> None:
    """Let modules be imported, unpickled from and run by their former names too; `moved` maps former to new names."""
    sys.meta_path.append(_FormerNames(moved))
