"""Results on disk: `results.csv` with a row an episode, and `results.json` with all that made them.

Numbers are written with six significant digits, and every table is made from the numbers as they were
written, so that a table made from the files is the table of the run. Files are replaced whole: a
run that is cut short leaves the last finished policy and suite behind, and never half a file.
"""

from __future__ import annotations

import csv
import io
import json
import lzma
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.evaluation.suites import SUITES
from drillrig_env.files import write_bytes

CSV, JSON = "results.csv", "results.json"
COMPRESSED = ".xz"

Scores = dict[str, npt.NDArray[Any]]
"""Columns of one policy in one suite by name, an entry an episode: first `seed` and `episode`, then scores."""

_TEXTS = {"seed", "start", "region"}
_FLAGS = {"calm", "mitigated"}


TOLD, SOFT = "*", "°"
MARKS = f"{TOLD} told what the sensors do not show; {SOFT} sets the drive's gains as well"
"""What the marks behind a policy's name say."""


def label(policy: str, marks: Mapping[str, str]) -> str:
    """A policy's name with its mark."""
    mark = marks.get(policy, "")
    return f"{policy} {mark}" if mark else policy


@dataclass
class Results:
    """Scores by suite and policy, and what made them.

    `config` tells what was asked for, `provenance` versions, machine and date. `estimates` are the tables
    as numbers (see `drillrig_env.evaluation.tables.all_estimates`), once all has been run.
    """

    config: dict[str, Any] = field(default_factory=dict)
    provenance: dict[str, Any] = field(default_factory=dict)
    scores: dict[str, dict[str, Scores]] = field(default_factory=dict)
    estimates: dict[str, Any] = field(default_factory=dict)
    _blocks: dict[tuple[str, str], str] = field(default_factory=dict, init=False, repr=False)
    _header: str = field(default="", init=False, repr=False)

    def add(self, suite: str, policy: str, scores: Mapping[str, npt.NDArray[Any]]) -> None:
        """Take one policy's scores in one suite, as they read once they have been written."""
        self.estimates = {}
        header, *lines = _write(suite, policy, scores).splitlines(keepends=True)
        if self._header not in ("", header):
            raise ValueError(f"the scores of {policy} in {suite} have other columns than those before: {header}")
        self._take(header, {(suite, policy): lines})

    def has(self, suite: str, policy: str) -> bool:
        """Whether one policy's scores in one suite are there."""
        return (suite, policy) in self._blocks

    def arrange(self, policies: Iterable[str]) -> None:
        """Put suites into their own order and policies into the given one, all others after them."""
        suites = list(SUITES)
        places = {name: place for place, name in enumerate(dict.fromkeys([*policies, *self.policies]))}
        keys = sorted(
            self._blocks,
            key=lambda key: (suites.index(key[0]) if key[0] in suites else len(suites), places[key[1]]),
        )
        self._blocks = {key: self._blocks[key] for key in keys}
        arranged: dict[str, dict[str, Scores]] = {}
        for suite, policy in keys:
            arranged.setdefault(suite, {})[policy] = self.scores[suite][policy]
        self.scores = arranged

    @property
    def policies(self) -> list[str]:
        """Names of all policies, each once."""
        return list(dict.fromkeys(policy for _, policy in self._blocks))

    @property
    def marks(self) -> dict[str, str]:
        """The mark behind a policy's name: TOLD where it is told what the sensors do not show, SOFT where it sets
        the drive's gains.
        """
        about = self.config.get("policies", {})
        return {name: TOLD * bool(of.get("privileged")) + SOFT * bool(of.get("drive")) for name, of in about.items()}

    @property
    def privileged(self) -> dict[str, bool]:
        """Whether a policy is told what the sensors do not show."""
        return {name: bool(about.get("privileged")) for name, about in self.config.get("policies", {}).items()}

    @property
    def rows(self) -> str:
        """The text of `results.csv`."""
        return self._header + "".join(self._blocks.values())

    def save(self, folder: Path, compressed: bool = False) -> None:
        """Write both files into a folder, which is made; `compressed` packs the rows."""
        folder.mkdir(parents=True, exist_ok=True)
        content = {"config": self.config, "provenance": self.provenance, "estimates": self.estimates}
        text = json.dumps(_without_nan(content), indent=2, ensure_ascii=False) + "\n"
        rows = self.rows.encode("utf-8")
        if compressed:
            write_bytes(folder / (CSV + COMPRESSED), lzma.compress(rows, preset=9 | lzma.PRESET_EXTREME))
        else:
            write_bytes(folder / CSV, rows)
        write_bytes(folder / JSON, text.encode("utf-8"))

    def _take(self, header: str, lines: Mapping[tuple[str, str], list[str]]) -> None:
        self._header = header
        names = next(csv.reader([header]))
        for (suite, policy), block in lines.items():
            columns = zip(*csv.reader(block), strict=True)
            self.scores.setdefault(suite, {})[policy] = {
                name: _column(name, values)
                for name, values in zip(names, columns, strict=True)
                if name not in ("suite", "policy")
            }
            self._blocks[suite, policy] = "".join(block)


def read(folder: str | Path) -> Results:
    """The results that a folder holds. `ValueError` where it holds none, or files that are not such results."""
    folder = Path(folder)
    try:
        content = json.loads((folder / JSON).read_text(encoding="utf-8"))
        packed = folder / (CSV + COMPRESSED)
        plain = folder / CSV
        rows = plain.read_bytes() if plain.exists() else lzma.decompress(packed.read_bytes())
        results = Results(content["config"], content["provenance"], estimates=content["estimates"])
    except FileNotFoundError as error:
        raise ValueError(f"{folder} holds no results: {Path(error.filename).name} is missing") from error
    except (json.JSONDecodeError, KeyError, lzma.LZMAError) as error:
        raise ValueError(f"{folder} holds no results that can be read: {error}") from error
    lines = rows.decode("utf-8").splitlines(keepends=True)
    if lines:
        blocks: dict[tuple[str, str], list[str]] = {}
        for line, (suite, policy, *_) in zip(lines[1:], csv.reader(lines[1:]), strict=True):
            blocks.setdefault((suite, policy), []).append(line)
        results._take(lines[0], blocks)
    return results


def _write(suite: str, policy: str, scores: Mapping[str, npt.NDArray[Any]]) -> str:
    """Rows of CSV under a header, numbers with six significant digits."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["suite", "policy", *scores])
    texts = ([_text(value) for value in values.tolist()] for values in scores.values())
    writer.writerows([suite, policy, *row] for row in zip(*texts, strict=True))
    return buffer.getvalue()


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return str(int(value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _column(name: str, values: tuple[str, ...]) -> npt.NDArray[Any]:
    if name in _TEXTS:
        return np.array(values)
    if name in _FLAGS:
        return np.array([value == "1" for value in values])
    return np.array(values, dtype=np.intp if name == "episode" else np.float64)


def _without_nan(value: Any) -> Any:
    """NaN and infinity as null: JSON has neither."""
    if isinstance(value, Mapping):
        return {key: _without_nan(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(inner) for inner in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
