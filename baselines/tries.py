"""What a search has tried, kept in a file, so that a search that is stopped goes on to the same end.

A search with a fixed seed asks for the same tries in the same order. When it goes on, tries that the file holds are
answered from it, bit for bit, and only those after them are run.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from drillrig_env.files import read_json, write_text

_REMEDY = "remove it to begin again"


class Tries:
    """Tries (values, worth) of a search with these `settings`; in memory alone where `path` is None.

    With `resume` those in the file come first. Raises `ValueError` where the file is damaged or of other settings,
    and where it is there and `resume` is not asked for, since it would be lost.
    """

    def __init__(
        self, path: Path | None = None, settings: Mapping[str, Any] | None = None, resume: bool = False
    ) -> None:
        self.path, self.settings = path, json.loads(json.dumps(dict(settings or {})))
        self._kept: list[tuple[list[float], float]] = []
        self._next = 0
        if path is None:
            return
        if path.exists() and not resume:
            raise ValueError(f"{path} holds a search that was stopped; go on with --resume, or {_REMEDY}")
        if resume:
            self._read(path)

    def __len__(self) -> int:
        return len(self._kept)

    def worth(self, values: Sequence[float], run: Callable[[], float]) -> float:
        """The worth of the next try: as it is kept, or else as `run` finds it, which is then kept."""
        given = [float(value) for value in values]
        if self._next == len(self._kept):
            self._kept.append((given, run()))
            self._write()
        kept, worth = self._kept[self._next]
        if kept != given:
            raise ValueError(f"{self.path} is of another version: try {self._next + 1} differs; {_REMEDY}")
        self._next += 1
        return worth

    def forget(self) -> None:
        """Remove the file: the search is at its end."""
        if self.path is not None:
            self.path.unlink(missing_ok=True)

    def _read(self, path: Path) -> None:
        if not path.is_file():
            raise ValueError(f"there is no search to go on with: {path} is missing")
        content = read_json(path, _REMEDY)
        settings = content.get("settings")
        if not isinstance(settings, dict) or not isinstance(content.get("tries"), list):
            raise ValueError(f"{path} is damaged: it lacks settings or tries; {_REMEDY}")
        for name, value in self.settings.items():
            if settings.get(name) != value:
                raise ValueError(f"{path} is of a search with {name} = {settings.get(name)}, not {value}; {_REMEDY}")
        self._kept = [(list(values), float(worth)) for values, worth in content["tries"]]

    def _write(self) -> None:
        if self.path is not None:
            write_text(self.path, json.dumps({"settings": self.settings, "tries": self._kept}) + "\n")
