"""When a kernel must be compiled anew: a digest of the text of its file and of all that it imports.

Numba renews a cached kernel when the kernel's own file changes. Kernels here call each other across files and
hold constants of other files, so the stamp covers these too, and nothing else: editing a page or a
picture renews no kernel, nor does a fresh clone with the same text.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).parents[1]
_IMPORT = re.compile(rf"^from ({_PACKAGE.name}[\w.]*) import (\([^)]*\)|[^\n(]+)", re.MULTILINE)
"""How this project imports from itself at the head of a file."""


def stamp_of(file: str) -> str:
    """The digest of a kernel's source `file` and of every file of the package that it stands on."""
    reached: set[Path] = set()
    waiting = [Path(file)]
    while waiting:
        path = waiting.pop()
        if path not in reached:
            reached.add(path)
            waiting += _read(path)[1]
    digest = hashlib.sha256()
    for path in sorted(reached):
        digest.update(_read(path)[0])
    return digest.hexdigest()


@cache
def _read(path: Path) -> tuple[bytes, tuple[Path, ...]]:
    """The text of a file, and the files of the package that it imports."""
    text = path.read_bytes()
    found = []
    for module, names in _IMPORT.findall(text.decode("utf-8")):
        place = _PACKAGE.joinpath(*module.split(".")[1:])
        inside = (place / f"{name}.py" for name in re.findall(r"\w+", names))
        candidates = (place.with_suffix(".py"), place / "__init__.py", *inside)
        found += [candidate for candidate in candidates if candidate.is_file() and candidate.parent != _PACKAGE.parent]
    return text, tuple(found)
