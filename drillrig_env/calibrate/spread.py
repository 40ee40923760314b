"""How well a fit knows its parameters: from how much its windows disagree, which asks nothing of residuals within one.

At the best parameters the pulls of all windows add up to nothing; how far they lie apart tells the spread (the sandwich
of Huber, 1967, with windows as clusters: Liang & Zeger, 1986). Residuals of a window may hang together as they like, as
those of a model that is not quite the rig do, while errors of least squares would count every sample as news.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.fit import Best, weights_of
from drillrig_env.calibrate.unknowns import WIDE

LEAST_WINDOWS = 4
"""So many windows must be there, or how far they disagree cannot be told."""

_FEW, _FEWEST = 2, 20
"""With fewer windows than so many times the parameters, or than so many, deviations are at least those of least
squares, wider by what so few windows leave uncertain."""

_KNOWN, _LOOSE = 0.5, 10.0
"""A parameter whose deviation is below this share of what it was beforehand is determined by the records, if it still
is where nothing but what was weighed is known so many times worse: else many that the records tell the ratios of only
would be known by where the fit began."""


@dataclass(frozen=True, eq=False)
class Spread:
    """What is known of the logarithms of the parameters: their covariance, as of a normal distribution.

    It is wider than the sandwich's by what so few windows leave uncertain of that. `determined` tells which the
    records know better than was known beforehand.
    """

    covariance: FloatArray  # (names, names)
    determined: FloatArray  # (names,), of truth values
    windows: int

    @property
    def deviations(self) -> FloatArray:
        """Standard deviations, shape (names,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def interval(self, share: float = 0.9) -> FloatArray:
        """Half the width of the interval that holds a logarithm with such a probability; shape (names,)."""
        return np.asarray(norm.ppf(0.5 + share / 2.0) * self.deviations)

    def draws(self, count: int, seed: int) -> FloatArray:
        """Joint draws of the logarithms less the best ones, shape (count, names)."""
        values, vectors = np.linalg.eigh(self.covariance)
        normal = np.random.default_rng(seed).standard_normal((count, len(values)))
        return np.asarray(normal * np.sqrt(np.maximum(values, 0.0)) @ vectors.T)


def spread_of(best: Best) -> Spread:
    """The spread of the parameters of a fit to at least `LEAST_WINDOWS` windows."""
    beforehand = best.problem.unknowns.deviations
    scores, curvatures = [], []
    for J, r in zip(best.derivatives, best.residuals, strict=True):
        weight = weights_of(r)
        scores.append(np.einsum("nij,ni->nj", J, weight * r))
        curvatures.append(np.einsum("nij,ni,nik->njk", J, weight, J))
    score, curvature = np.concatenate(scores), np.concatenate(curvatures)
    n = len(score)
    total = curvature.sum(axis=0) + np.diag(beforehand**-2)
    pulls = np.linalg.solve(total, (score - score.mean(axis=0)).T).T
    wider = student.ppf(0.95, n - 1) / norm.ppf(0.95)
    covariance = n / (n - 1) * wider**2 * pulls.T @ pulls
    inverse = np.linalg.inv(total)
    covariance = covariance + inverse @ np.diag(beforehand**-2) @ inverse  # what was known beforehand is news too
    if n < max(_FEW * len(total), _FEWEST):  # so few cannot tell how far they disagree
        inflated = np.maximum(wider, np.sqrt(np.diag(covariance) / np.diag(inverse)))
        covariance = inverse * np.outer(inflated, inflated)
    known = np.sqrt(np.diag(inverse))
    seen = np.maximum(known, np.sqrt(np.diag(covariance))) < _KNOWN * beforehand
    loose = np.where(beforehand < WIDE, beforehand, _LOOSE * beforehand)
    alone = np.sqrt(np.diag(np.linalg.inv(curvature.sum(axis=0) + np.diag(loose**-2))))
    determined = np.logical_and(seen, alone < _KNOWN * beforehand)
    return Spread(_with_beforehand(covariance, seen, beforehand), determined, n)


def _with_beforehand(covariance: FloatArray, seen: FloatArray, beforehand: FloatArray) -> FloatArray:
    """A covariance in which what the records do not tell is as uncertain as it was."""
    found = covariance.copy()
    for k in np.flatnonzero(np.logical_not(seen)):
        found[k, :] = found[:, k] = 0.0
        found[k, k] = beforehand[k] ** 2
    return found
