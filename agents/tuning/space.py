"""What is looked through for each hyperparameter, as `search` in the file of hyperparameters says beside its values.

    search:
      gamma: {low: 0.98, high: 0.999}
      learning_rate: {low: 1.0e-4, high: 1.0e-3, log: true, as: "lin_{:.3g}"}
      n_steps: {choices: [64, 128, 256]}

A range is of whole numbers where both ends are. `log` is for what counts by its ratio, and `as` the text that a number
stands in. A hyperparameter within another is named with a dot: `imitation.rounds`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from agents.training.hyperparameters import (
    HYPERPARAMETER_FILES,
    SEARCH,
    hyperparameters,
    own_file,
    read_tables,
    search_of,
)
from drillrig_env.parameters import refuse

_KEYS = ("low", "high", "log", "as", "choices")


@dataclass(frozen=True)
class Dimension:
    """What is looked through for one hyperparameter: `choices`, or what lies between `low` and `high`."""

    name: str
    choices: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 0.0
    log: bool = False
    text: str = ""

    @classmethod
    def of(cls, name: str, given: Any) -> Dimension:
        """As the file has it. `ValueError` for what is no range and no choices."""
        if not isinstance(given, Mapping) or not set(given) <= set(_KEYS):
            raise refuse("search", name, given, "", "choices, or low and high, with log and as")
        if "choices" in given:
            choices = given["choices"]
            if len(given) > 1 or not isinstance(choices, list) or len(choices) < 2:
                raise refuse("search", name, given, "", "choices: a list of two or more, alone")
            return cls(name, choices=tuple(choices))
        try:
            low, high = _number(given["low"]), _number(given["high"])
        except (KeyError, ValueError, TypeError):
            raise refuse("search", name, given, "", "numbers low and high") from None
        log, text = given.get("log", False), given.get("as", "")
        if not low < high or (log and low <= 0.0):
            raise refuse("search", name, given, "", "low < high, and low > 0 with log")
        try:
            text.format(low)
        except (AttributeError, ValueError, IndexError, KeyError):
            raise refuse(
                "search", name, given, "", 'as: a text with a place for the number, such as "lin_{:.3g}"'
            ) from None
        return cls(name, low=low, high=high, log=bool(log), text=text)

    @property
    def distribution(self) -> Any:
        """What Optuna draws from."""
        from optuna import distributions

        if self.choices:
            return distributions.CategoricalDistribution(self.choices)
        if isinstance(self.low, int) and isinstance(self.high, int):
            return distributions.IntDistribution(self.low, self.high, log=self.log)
        return distributions.FloatDistribution(self.low, self.high, log=self.log)

    def value(self, drawn: Any) -> Any:
        """The hyperparameter for what was drawn; a number with three digits."""
        if self.text:
            return self.text.format(drawn)
        return float(f"{drawn:.3g}") if isinstance(drawn, float) and not self.choices else drawn

    def drawn(self, value: Any) -> Any:
        """What would have to be drawn for a hyperparameter of this `value`; None where it cannot be drawn."""
        if self.choices:
            return value if value in self.choices else None
        try:
            before, _, rest = self.text.partition("{")
            number = float(str(value).removeprefix(before).removesuffix(rest.partition("}")[2]))
        except ValueError:
            return None
        whole = isinstance(self.low, int) and isinstance(self.high, int)
        found = int(number) if whole else number
        return found if self.low <= number <= self.high and found == number else None


@dataclass(frozen=True)
class Space:
    """All that is looked through, and the hyperparameters around it."""

    dimensions: tuple[Dimension, ...]
    table: Mapping[str, Any]  # as the file has them

    @classmethod
    def of(cls, algorithm: str, env_id: str, file: Path | None = None) -> Space:
        """As a file has it, by default the algorithm's own. `ValueError` where it has none, or what is not allowed."""
        table, search = search_of(algorithm, env_id, file)
        if not isinstance(search, Mapping) or not search:
            raise ValueError(
                f"{file or own_file(algorithm)} says for {env_id} nowhere what to look through; "
                f"allowed: ranges under `search`{_with_search(algorithm, env_id)}"
            )
        found = cls(tuple(Dimension.of(str(name), given) for name, given in search.items()), table)
        for dimension in found.dimensions:
            ends = dimension.choices or (dimension.low, dimension.high)
            for end in ends:  # each must be a hyperparameter, and allowed
                hyperparameters(algorithm, env_id, found.changes({dimension.name: end}), table=table)
            own = found.value(dimension.name)
            if own is not None and dimension.drawn(own) is None:  # the first try is to be what the file has
                raise refuse("search", dimension.name, own, "", f"the file's own value among {ends}")
        return found

    def distributions(self) -> dict[str, Any]:
        """What Optuna draws from, by name."""
        return {one.name: one.distribution for one in self.dimensions}

    def own(self) -> dict[str, Any]:
        """What would have to be drawn for the file's own hyperparameters, of those that can be drawn."""
        drawn = {one.name: one.drawn(self.value(one.name)) for one in self.dimensions}
        return {name: value for name, value in drawn.items() if value is not None}

    def value(self, name: str) -> Any:
        """The file's own value of a hyperparameter; None where the file has none."""
        outer, dot, inner = name.partition(".")
        value = self.table.get(outer)
        return (value or {}).get(inner) if dot else value

    def changes(self, drawn: Mapping[str, Any]) -> dict[str, Any]:
        """What was drawn as changes to hyperparameters, by the names that are looked through."""
        return {one.name: one.value(drawn[one.name]) for one in self.dimensions if one.name in drawn}


def _with_search(algorithm: str, env_id: str) -> str:
    """Which files of this project have what to look through, in words; empty where none has."""
    files = sorted(HYPERPARAMETER_FILES.rglob(own_file(algorithm).name))
    with_it = [str(file) for file in files if read_tables(file).get(env_id, {}).get(SEARCH)]
    return f", as in {', '.join(with_it)} (--conf-file)" if with_it else ""


def seed_of(drawn: Mapping[str, Any], first: int) -> int:
    """The training seed of a try: from `first` on, by what was drawn, so that it is the same wherever it is done."""
    text = json.dumps(dict(drawn), sort_keys=True)
    return first + int(hashlib.sha256(text.encode()).hexdigest()[:4], 16) % 1000


def _number(value: Any) -> float:
    """A number. `TypeError` for what is none."""
    if type(value) not in (int, float):
        raise TypeError
    number: float = value
    return number
