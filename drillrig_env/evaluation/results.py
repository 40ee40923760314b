"""Results: the scores of all episodes by suite and policy, with all that made them, and their text as rows of CSV.

Numbers are written with six significant digits, and every table is made from the numbers as they were
written, so that a table made from the files is the table of the run. Where and how results are kept on
disk is `drillrig_env.evaluation.store`'s.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.evaluation.large import StoredScores
from drillrig_env.evaluation.suites import SUITES
from drillrig_env.scales import Scales

Scores = Mapping[str, npt.NDArray[Any]]
"""Columns of one policy in one suite by name, an entry an episode: first `seed` and `episode`, then scores."""

_TEXTS = {"seed", "start", "region"}
_FLAGS = {"calm", "mitigated"}
_COUNTS = {"episode", "rig"}

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

    def add_stored(self, suite: str, policy: str, scores: StoredScores) -> None:
        """Take one policy's scores in a large suite, which stay in their file."""
        self.estimates = {}
        self.scores.setdefault(suite, {})[policy] = scores
        self._blocks[suite, policy] = ""

    @property
    def stored(self) -> dict[str, dict[str, StoredScores]]:
        """By suite and policy the scores that stay in files of their own."""
        found: dict[str, dict[str, StoredScores]] = {}
        for suite, policies in self.scores.items():
            for policy, scores in policies.items():
                if isinstance(scores, StoredScores):
                    found.setdefault(suite, {})[policy] = scores
        return found

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
    def scales(self) -> Scales:
        """The scales of the rig that was run."""
        return Scales.of(self.config.get("rig"), self.config.get("largest_reference"))

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
        return {name: TOLD * self.privileged[name] + SOFT * bool(of.get("drive")) for name, of in about.items()}

    @property
    def privileged(self) -> dict[str, bool]:
        """Whether a policy is told, or shown, what the sensors do not show."""
        about = self.config.get("policies", {})
        return {name: bool(of.get("privileged") or of.get("exact")) for name, of in about.items()}

    @property
    def rows(self) -> str:
        """The text of `results.csv`."""
        return self._header + "".join(self._blocks.values())

    @classmethod
    def of_rows(
        cls, rows: str, config: dict[str, Any], provenance: dict[str, Any], estimates: dict[str, Any]
    ) -> Results:
        """The results whose `rows` these are."""
        results = cls(config, provenance, estimates=estimates)
        header, *lines = rows.splitlines(keepends=True) or [""]
        if header and "rig" not in next(csv.reader([header])):  # written before there were fleets
            header, lines = header.replace("\n", ",rig\n"), [line.replace("\n", ",0\n") for line in lines]
        blocks: dict[tuple[str, str], list[str]] = {}
        for line, (suite, policy, *_) in zip(lines, csv.reader(lines), strict=True):
            blocks.setdefault((suite, policy), []).append(line)
        results._take(header, blocks)
        return results

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
    return np.array(values, dtype=np.intp if name in _COUNTS else np.float64)
