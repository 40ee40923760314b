"""How well a fit knows its parameters: from how much its windows disagree, which asks nothing of residuals within one.

At the best parameters the pulls of all windows add up to nothing; how far they lie apart tells the spread (the sandwich
of Huber, 1967, with windows as clusters: Liang & Zeger, 1986). Residuals of a window may hang together as they like, as
those of a model that is not quite the rig do, while errors of least squares count every sample as news. A window that
tells much by itself pulls the fit to it and disagrees too little, which is made up for (Bell & McCaffrey, 2002: CR2).
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

_LEAST_REST = 1e-6
"""Least share of what is known that is taken to come from other windows."""

_KNOWN, _LOOSE = 0.5, 10.0
"""A parameter whose deviation is below this share of what it was beforehand is determined by the records, if it still
is where nothing but what was weighed is known so many times worse: else many that the records tell the ratios of only
would be known by where the fit began."""


@dataclass(frozen=True, eq=False)
class Spread:
    """What is known of the logarithms of the parameters: their covariance, as of a normal distribution.

    It is wider than the sandwich's by what so few windows leave uncertain of that, and nowhere below that of least
    squares. `determined` tells which the records know better than was known beforehand.
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
    score, curvature = by_window(best)
    n = len(score)
    total = curvature.sum(axis=0) + np.diag(beforehand**-2)
    inverse = np.linalg.inv(total)
    pulls = _pulls(score - score.mean(axis=0), curvature, inverse)
    wider = student.ppf(0.95, n - 1) / norm.ppf(0.95)
    apart = n / (n - 1) * np.diag(pulls.T @ pulls) + np.diag(inverse @ np.diag(beforehand**-2) @ inverse)
    inflated = wider * np.sqrt(np.maximum(1.0, apart / np.diag(inverse)))  # never below errors of least squares
    covariance = inverse * np.outer(inflated, inflated)
    seen = np.sqrt(np.diag(covariance)) < _KNOWN * beforehand
    determined = np.logical_and(seen, tells(curvature.sum(axis=0), beforehand))
    return Spread(covariance, determined, n)


def by_window(best: Best) -> tuple[FloatArray, FloatArray]:
    """How each of n windows pulls at the parameters, shape (n, names), and what it tells of them, (n, names, names)."""
    scores, curvatures = [], []
    for J, r in zip(best.derivatives, best.residuals, strict=True):
        weight = weights_of(r)
        scores.append(np.einsum("nij,ni->nj", J, weight * r))
        curvatures.append(np.einsum("nij,ni,nik->njk", J, weight, J))
    return np.concatenate(scores), np.concatenate(curvatures)


def tells(curvature: FloatArray, beforehand: FloatArray) -> FloatArray:
    """Whether least squares with such a curvature (names, names) determine each parameter; truth values (names,).

    `beforehand` are the standard deviations of the logarithms before.
    """
    loose = np.where(beforehand < WIDE, beforehand, _LOOSE * beforehand)
    known, alone = (np.sqrt(np.diag(np.linalg.inv(curvature + np.diag(one**-2)))) for one in (beforehand, loose))
    return np.asarray((known < _KNOWN * beforehand) & (alone < _KNOWN * beforehand))


def _pulls(scores: FloatArray, curvatures: FloatArray, inverse: FloatArray) -> FloatArray:
    """How far each of n windows draws the parameters, shape (n, names), made up for what it drew the fit to itself."""
    root = np.linalg.cholesky(inverse)
    shares, axes = np.linalg.eigh(root.T @ curvatures @ root)  # of all that is known, what a window tells by itself
    along = np.einsum("nji,nj->ni", axes, scores @ root) / np.sqrt(np.maximum(1.0 - shares, _LEAST_REST))
    return np.asarray(np.einsum("nij,nj->ni", axes, along) @ root.T)
