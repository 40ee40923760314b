"""The tables of a comparison as numbers: every column's estimate for a policy, over rigs or training seeds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.evaluation.scores import HARDNESS_EDGES
from drillrig_env.evaluation.statistics import Estimate, difference, mean, median, over_rigs, over_seeds, rate

Scores = Mapping[str, npt.NDArray[Any]]

_PLAIN: dict[Callable[..., Estimate], Callable[..., Any]] = {rate: np.mean, mean: np.mean, median: np.median}
"""What each statistic is without an interval, as one training seed contributes it."""


@dataclass(frozen=True)
class Column:
    """A column of a table: the statistic of a score over all rigs, or those of a region or of a bin of hardness."""

    heading: str
    score: str
    statistic: Callable[..., Estimate] = rate
    digits: int = 3
    region: str | None = None
    hardness: tuple[float, float] | None = None

    def chosen(self, scores: Scores) -> npt.NDArray[np.bool_]:
        """Which episodes count for this column."""
        chosen = np.ones(len(scores[self.score]), dtype=np.bool_)
        if self.region is not None:
            chosen &= scores["region"] == self.region
        if self.hardness is not None:
            low, high = self.hardness
            chosen &= (scores["hardness"] >= low) & (scores["hardness"] < high)
        return chosen

    def estimate(self, scores: Scores) -> Estimate:
        """The column's entry for one policy: over rigs, or over training seeds where there are several."""
        chosen = self.chosen(scores)
        values, seeds = scores[self.score][chosen], scores["seed"][chosen]
        names = np.unique(seeds)
        if len(names) < 2 and _of_fleet(scores):
            return over_rigs(values, scores["rig"][chosen], self.statistic)
        if len(names) < 2:
            return self.statistic(values)
        plain = _PLAIN[self.statistic]
        return over_seeds([float(plain(values[seeds == name])) for name in names], len(values))


@dataclass(frozen=True)
class Table:
    """Columns that are shown together, and what a reader must know of them."""

    columns: tuple[Column, ...]
    caption: str
    signed: bool = False  # whether numbers show their sign, as differences do

    @property
    def headings(self) -> list[str]:
        """The headings of its columns."""
        return [column.heading for column in self.columns]


MAIN = Table(
    (
        Column("mitigated", "mitigated"),
        Column("below ω_c", "mitigated", region="below"),
        Column("bistable", "mitigated", region="bistable"),
        Column("above", "mitigated", region="above"),
        Column("calm", "calm"),
        Column("to calm", "time_to_calm", median, 1),
    ),
    "mitigated: calm and within 5 % of the target, also below ω_c, from ω_c to the fold (bistable) and above the "
    "fold; calm: at any speed; to calm: median, s",
)
"""The headline."""

OTHERS = Table(
    (
        Column("cost", "cost", mean),
        Column("stuck", "stuck", mean),
        Column("SSI", "ssi", median),
        Column("peak ω", "peak_speed", median, 2),
        Column("peak T", "peak_torque", median, 2),
        Column("travel", "travel", median, 1),
    ),
    "cost: mean of - reward; stuck: mean share of the time; the others are medians: stick-slip index, peak bit speed "
    "over the target, peak string torque over its steady value, travel of the speed reference in rad/s",
)
"""The scores that the headline leaves out."""


def _bin(low: float, high: float) -> str:
    """The heading of a bin of hardness; the last one has no upper edge."""
    return f"q {low:g}-{high:g}" if np.isfinite(high) else f"q ≥ {low:g}"


HARDNESS = Table(
    tuple(Column(_bin(low, high), "mitigated", hardness=(low, high)) for low, high in pairwise(HARDNESS_EDGES)),
    "mitigated by the rig's hardness q, the fall of its friction at the target over what the bare drive can bear; "
    "q < 1 is above ω_c",
)
"""Mitigated over bins of the hardness q."""

DIFFERENCES = Table(
    (
        Column("mitigated", "mitigated"),
        Column("calm", "calm"),
        Column("to calm", "time_to_calm", mean, 1),
        Column("cost", "cost", mean),
    ),
    "means of the differences on the same rigs; to calm: s",
    signed=True,
)
"""Scores whose paired differences are reported."""

TABLES = {"main": MAIN, "hardness": HARDNESS, "others": OTHERS}
"""The tables that have a row a policy, by name."""

Row = dict[str, Estimate]


def estimates(scores: Scores, columns: tuple[Column, ...] = MAIN.columns) -> Row:
    """The estimate of every column for one policy, by heading."""
    return {column.heading: column.estimate(scores) for column in columns}


def differences(scores: Scores, reference: Scores) -> Row:
    """Paired differences of one policy from a reference on the same rigs, for each of DIFFERENCES.

    Over rigs, those of a fleet with all of their episodes; where the policy has several training seeds, over seeds
    (interquartile mean of each seed's mean difference). A reference with several seeds counts as their mean on each
    rig.
    """
    row = {}
    for column in DIFFERENCES.columns:
        theirs = by_rig(reference, column.score).mean(axis=0)
        ours = by_rig(scores, column.score)
        if len(ours) == 1 and _of_fleet(scores):
            row[column.heading] = over_rigs(ours[0] - theirs, scores["rig"], mean)
        elif len(ours) == 1:
            row[column.heading] = difference(ours[0], theirs)
        else:
            row[column.heading] = over_seeds((ours - theirs).mean(axis=1), ours.size)
    return row


def _of_fleet(scores: Scores) -> bool:
    """Whether episodes differ in their rigs."""
    return "rig" in scores and bool(scores["rig"].any())


def best_first(results: Mapping[str, Scores]) -> list[str]:
    """Policies by the share of rigs that they mitigate; among equals the one that is calm more often comes first."""
    return sorted(results, key=lambda name: (-results[name]["mitigated"].mean(), -results[name]["calm"].mean(), name))


def by_rig(scores: Scores, name: str) -> npt.NDArray[np.float64]:
    """A score as an array of shape (training seeds, rigs)."""
    seeds = scores["seed"]
    values = [scores[name][seeds == seed] for seed in dict.fromkeys(seeds.tolist())]
    return np.asarray(values, dtype=float)


def all_estimates(results: Mapping[str, Mapping[str, Scores]], reference: str) -> dict[str, Any]:
    """Every estimate by suite, policy, table and heading, as `results.json` holds them.

    Beside TABLES there is "differences" from the reference policy, and for the suite `degraded`, whose rigs
    are those of `default`, the "loss": each policy's differences from itself in `default`.
    """
    found: dict[str, Any] = {}
    for suite, policies in results.items():
        for policy, scores in policies.items():
            rows = {name: estimates(scores, table.columns) for name, table in TABLES.items()}
            if reference in policies and policy != reference:
                rows["differences"] = differences(scores, policies[reference])
            if suite == "degraded" and policy in results.get("default", {}):
                rows["loss"] = differences(scores, results["default"][policy])
            found.setdefault(suite, {})[policy] = {
                name: {heading: vars(estimate) for heading, estimate in row.items()} for name, row in rows.items()
            }
    return found


def stored_row(stored: Mapping[str, Mapping[str, float | None]]) -> Row:
    """A row of estimates as `results.json` holds it."""
    return {
        heading: Estimate(_number(one["value"]), _number(one["low"]), _number(one["high"]), int(one["count"] or 0))
        for heading, one in stored.items()
    }


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)
