"""Whether records can be of one rig: what each says by itself beside what the others say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.calibration import Calibration
from drillrig_env.calibrate.fit import Best, fit
from drillrig_env.calibrate.projection import Problem
from drillrig_env.calibrate.spread import LEAST_WINDOWS, Spread, by_window, spread_of
from drillrig_env.stepper.finite import NotFiniteError

_CHANCE = 0.01
"""How often records of one rig may be said to disagree, over all records and parameters together."""

_TOLD = 3
"""Parameters of a disagreement that are told, the clearest first."""


@dataclass(frozen=True)
class Disagreement:
    """A parameter that one record has otherwise than the others: 90 % intervals of fits to it and to them alone."""

    source: str
    others: str
    name: str
    alone: tuple[float, float]
    beside: tuple[float, float]

    def __str__(self) -> str:
        alone, beside = (f"{low:.4g} to {high:.4g}" for low, high in (self.alone, self.beside))
        return f"{self.source} says {self.name} = {alone}, {self.others} {beside}"


def disagreements(calibration: Calibration) -> list[Disagreement]:
    """Parameters in which one record disagrees with the others by more than chance; none where all may be of one rig.

    The record that one step of least squares takes furthest from the others is fitted by itself, and so are the
    others, both from the best fit of all on. Only what both determine is compared. Records of fewer windows than
    `LEAST_WINDOWS` are not asked. Two records say nothing of which of them is the odd one.
    """
    best = calibration.best
    numbers = [k for k, one in enumerate(best.problem.windows) if len(one)]
    asked = [k for k in numbers if min(_count(best, [k]), _count(best, _without(numbers, k))) >= LEAST_WINDOWS]
    tests = len(asked) * len(calibration.unknowns.names)
    if not tests:
        return []
    far = float(norm.isf(_CHANCE / tests / 2.0))
    scores = [_apart(_step(_part(best, [k])), _step(_part(best, _without(numbers, k)))).max() for k in asked]
    if max(scores) < far:
        return []
    odd = asked[int(np.argmax(scores))]
    rest = _without(numbers, odd)
    try:
        alone, beside = (_fitted(calibration, part) for part in ([odd], rest))
    except NotFiniteError:  # a record may be too little to fit alone
        return []
    names = calibration.unknowns.names
    apart = _apart((alone[0].logs, alone[1]), (beside[0].logs, beside[1]))
    others = calibration.records[rest[0]].source if len(rest) == 1 else "the others"
    return [
        Disagreement(calibration.records[odd].source, others, names[k], _interval(alone, k), _interval(beside, k))
        for k in np.argsort(-apart)[:_TOLD]
        if apart[k] > far
    ]


def disagreement_words(found: Sequence[Disagreement]) -> list[str]:
    """A line for each, and what they mean; none where there is none."""
    if not found:
        return []
    why = "These records may be of different rigs, or something has changed between them: fit them apart"
    return [*map(str, found), why]


def _without(numbers: list[int], k: int) -> list[int]:
    return [one for one in numbers if one != k]


def _count(best: Best, numbers: list[int]) -> int:
    return sum(len(best.problem.windows[k]) for k in numbers)


def _part(best: Best, numbers: list[int]) -> Best:
    """What a fit has of some of its records."""
    return replace(
        best,
        residuals=[best.residuals[k] for k in numbers],
        derivatives=[best.derivatives[k] for k in numbers],
    )


def _step(part: Best) -> tuple[FloatArray, Spread]:
    """Where one step of least squares takes the parameters of a fit with a part of its records, and how certainly."""
    beforehand = part.problem.unknowns.deviations
    scores, curvatures = by_window(part)
    pull = part.logs / beforehand**2 + scores.sum(axis=0)
    curvature = np.diag(beforehand**-2) + curvatures.sum(axis=0)
    return part.logs - np.linalg.solve(curvature, pull), spread_of(part)


def _apart(one: tuple[FloatArray, Spread], other: tuple[FloatArray, Spread]) -> FloatArray:
    """How far two are apart in each parameter that both determine, in standard deviations of that; (names,)."""
    variance = np.diag(one[1].covariance) + np.diag(other[1].covariance)
    return np.where(
        np.logical_and(one[1].determined, other[1].determined), np.abs(one[0] - other[0]) / np.sqrt(variance), 0.0
    )


def _fitted(calibration: Calibration, numbers: list[int]) -> tuple[Best, Spread]:
    """A fit of some of the records, from the best of all of them on."""
    windows = [calibration.best.problem.windows[k] for k in numbers]
    problem = Problem(windows, calibration.unknowns, [one.noise for one in windows])
    best = fit(problem, 1, calibration.seed, begin=calibration.best.logs)
    return best, spread_of(best)


def _interval(fitted: tuple[Best, Spread], k: int) -> tuple[float, float]:
    best, spread = fitted
    value = list(best.problem.unknowns.values(best.logs).values())[k]
    away = float(np.exp(spread.interval()[k]))
    return value / away, value * away
