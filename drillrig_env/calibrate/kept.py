"""Fits from single starts that are done, kept in a file, so that a search that was stopped can go on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.files import json_text, read_json, write_text


@dataclass(frozen=True, eq=False)
class Ended:
    """Where a fit from one start ended: its cost and the logarithms there, or why there are none."""

    cost: float
    logs: FloatArray  # (names,)
    failure: str = ""


class Kept:
    """Fits that are done, by a key of all that decides how they end; each goes to the file as it is `put`.

    The file is whole at any moment. Beside the fits it holds what the search is `of`: plain values by name.
    """

    def __init__(self, path: Path, of: Mapping[str, Any], resume: bool = False, overwrite: bool = False) -> None:
        """Begin with a file that is not there until a fit is done, or `resume` with the fits of one that is there.

        Raises `FileExistsError` for a search that is there and neither resumed nor to `overwrite`, `FileNotFoundError`
        where none is to resume, and `ValueError` for one of something else, or a damaged one.
        """
        self.path = path
        self._of = dict(of)
        self._ended: dict[str, Ended] = {}
        if resume:
            self._read()
        elif path.exists() and not overwrite:
            raise FileExistsError(f"{path} holds a search that was stopped; give --resume to go on, or --overwrite")

    def __len__(self) -> int:
        return len(self._ended)

    def get(self, key: str) -> Ended | None:
        """The fit of this key, where it is done."""
        return self._ended.get(key)

    def put(self, key: str, ended: Ended) -> None:
        """Keep a fit that is done."""
        self._ended[key] = ended
        self._write()

    def remove(self) -> None:
        """Take the file away: the search is at its end."""
        self.path.unlink(missing_ok=True)

    def _write(self) -> None:
        ended = {key: {"cost": one.cost, "logs": one.logs.tolist()} for key, one in self._ended.items()}
        for key, one in self._ended.items():
            if one.failure:
                ended[key] = {"failure": one.failure}
        write_text(self.path, json_text({"of": self._of, "ended": ended}))

    def _read(self) -> None:
        if not self.path.exists():
            raise FileNotFoundError(f"{self.path} is missing: no search was stopped there; leave out --resume")
        found = read_json(self.path, "begin anew with --overwrite")
        try:
            of, ended = found["of"], found["ended"]
            for key, one in ended.items():
                failure = str(one.get("failure", ""))
                cost, logs = (np.inf, []) if failure else (float(one["cost"]), one["logs"])
                self._ended[key] = Ended(cost, np.array(logs, dtype=float), failure)
        except (KeyError, TypeError, AttributeError, ValueError):
            raise ValueError(f"{self.path} is damaged: it is no search; begin anew with --overwrite") from None
        for name, value in self._of.items():
            if of.get(name) != value:
                raise ValueError(
                    f"{self.path} holds a search with {name} = {of.get(name)}, here {value}; give the same to go on, "
                    "or begin anew with --overwrite"
                )
