"""Python files of the user's own, as modules."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType


def load_module(file: Path) -> ModuleType:
    """A Python file as a module, which may import from its own folder; `ValueError` for what is none."""
    place = file.resolve()
    name = f"{file.stem}_{hashlib.sha256(str(place).encode()).hexdigest()[:8]}"  # hides no other module
    spec = importlib.util.spec_from_file_location(name, place)
    if spec is None or spec.loader is None:
        raise ValueError(f"{file} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    sys.path.insert(0, str(place.parent))
    try:
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(place.parent))
    return module
