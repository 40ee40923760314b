"""Joint draws of the parameters by Markov chains (emcee), where they are too uncertain for a normal distribution.

The density is that of the fit: its soft cost, with the start of each window at its best, and what was known beforehand.
Residuals of a window hang together, and the cost counts every sample as news: it is divided by how many times larger
the variances are that the windows' disagreement gives than those of least squares, in mean over the directions of
what is determined ("tempering": Pauli, Racugno & Ventura, 2011). Where directions differ in that, draws are a little
too wide in some and too narrow in others.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.calibration import DRAWS, Calibration
from drillrig_env.calibrate.fit import FARTHEST, Best, soft
from drillrig_env.calibrate.spread import Spread, by_window
from drillrig_env.engine import Engine, used
from drillrig_env.extras import missing
from drillrig_env.parameters import COUNT, checked
from drillrig_env.stepper.finite import NotFiniteError

STEPS = 4000
"""Most steps of each walker."""

_TIMES = 50.0
"""Autocorrelation times that a chain is to be long, by the advice of emcee's authors."""

_LOOK = 250
"""Steps from one look at the autocorrelation time to the next."""

_BURNT = 0.25
"""Share of the steps that is thrown away: the walkers begin close to the best fit."""

_NEAR = 0.1
"""How far off it they begin, in standard deviations."""

_OFF = 1.0
"""By how much the logarithm of the density may be off at a draw where starts are found anew."""

_FALLS = 3.0
"""From how many times the usual fall of the density on a normal distribution's draws are not the posterior's."""

_STAY = "the draws stay those of a normal distribution"


@dataclass(frozen=True)
class Sampling:
    """How a posterior was sampled; `converged` where chains are 50 autocorrelation times long, and the density holds.

    `time` is the longest autocorrelation time of a parameter, in steps; `temper` what the cost is divided by; `off` by
    how much the density's logarithm is off at the draws in the median, for want of finding each start anew.
    """

    walkers: int
    steps: int
    time: float
    acceptance: float
    temper: float
    off: float

    @property
    def converged(self) -> bool:
        """Whether the draws are those of the posterior, as far as can be told."""
        return self.steps >= _TIMES * self.time and self.off <= _OFF

    def __str__(self) -> str:
        how = f"{self.walkers} walkers of {self.steps} steps, autocorrelation time {self.time:.0f}"
        if self.converged:
            return f"joint draws by emcee: {how}, cost divided by {self.temper:.2f}"
        if self.off > _OFF:
            return f"emcee: the density is off by {self.off:.2g} at its draws; {_STAY}"
        enough = f"allowed: {_TIMES:g} times it; give --posterior-steps {2 * self.steps} or more, or other records"
        return f"emcee has not converged: {how}; {enough}; {_STAY}"


class Density:
    """The logarithm of the posterior density, less that at the best parameters, for many evaluations.

    Starts of windows move with the parameters as they do at the best ones, and what else they can do is projected out
    of the residuals: one run of the windows an evaluation.
    """

    def __init__(self, best: Best, temper: float) -> None:
        problem = best.problem
        self.best, self.problem, self.temper = best, problem, temper
        problem.begin(best.logs)
        self._residuals = problem.residuals(best.logs)
        self._starts = [one.copy() for one in problem.starts]
        self._tangents = problem.tangents(best.logs)
        self._least = self._cost(best.logs)

    def __call__(self, logs: FloatArray) -> float:
        """The density at some logarithms, shape (names,); minus infinity beyond what a fit may find."""
        if np.max(np.abs(logs)) > FARTHEST:
            return -np.inf
        try:
            cost = self._cost(logs)
        except (NotFiniteError, ValueError):  # no rig at all
            return -np.inf
        return self._beside(logs, cost - self._least)

    def anew(self, logs: FloatArray) -> float:
        """The same with the starts found anew, which takes ten times as long."""
        self.problem.starts = self._moved(logs)
        cost = sum(0.5 * float(np.sum(soft(one))) for one in self.problem.residuals(logs))
        return self._beside(logs, cost - sum(0.5 * float(np.sum(soft(one))) for one in self._residuals))

    def _beside(self, logs: FloatArray, cost: float) -> float:
        known = self.problem.unknowns.deviations
        prior = 0.5 * float(np.sum((logs / known) ** 2) - np.sum((self.best.logs / known) ** 2))
        return -cost / self.temper - prior

    def _moved(self, logs: FloatArray) -> list[FloatArray]:
        away = logs - self.best.logs
        return [start + moves @ away for start, (moves, _) in zip(self._starts, self._tangents, strict=True)]

    def _cost(self, logs: FloatArray) -> float:
        total = 0.0
        found = self.problem.residuals_from(logs, self._moved(logs))
        for left, (_, basis) in zip(found, self._tangents, strict=True):
            free = np.einsum("nij,nj->ni", basis, np.einsum("nij,ni->nj", basis, left))
            total += 0.5 * float(np.sum(soft(left - free)))
        return total


def sampled(
    calibration: Calibration,
    steps: int = STEPS,
    told: Callable[[int, float], None] | None = None,
    engine: Engine | str | None = None,
) -> Calibration:
    """The calibration with joint draws by emcee, and with `sampling`, which says whether they have converged.

    `steps` is the most that a walker takes; it ends before where the chains are long enough. Where they are not, or
    Ctrl-C ends them, the draws stay what they were. `told` hears of steps done and the autocorrelation time so far.
    `engine` does the walkers, as that of `calibrate` does the starts, with the same result.
    Raises `ImportError` without emcee.
    """
    emcee = emcee_module()
    steps = checked("sampled", "steps", steps, "", COUNT)
    best = calibration.best
    names = len(best.logs)
    density = Density(best, temper_of(best, calibration.spread))
    walkers = 2 * names + 2
    random = np.random.default_rng([calibration.seed, 1])
    root = np.linalg.cholesky(calibration.spread.covariance)
    places = best.logs + _NEAR * random.standard_normal((walkers, names)) @ root.T
    moves = [(emcee.moves.DEMove(), 0.8), (emcee.moves.DESnookerMove(), 0.2)]
    state = emcee.State(np.clip(places, -FARTHEST, FARTHEST), random_state=_random_state(calibration.seed))
    done, time = 0, np.inf
    with used(engine) as at:
        pool = None if at.here else at
        chains: Any = emcee.EnsembleSampler(walkers, names, density, moves=moves, pool=pool)
        try:
            for _ in chains.sample(state, iterations=steps):
                done += 1
                if done % _LOOK == 0 or done == steps:
                    time = float(np.max(chains.get_autocorr_time(discard=int(_BURNT * done), tol=0)))
                    if told is not None:
                        told(done, time)
                    if done * (1.0 - _BURNT) >= _TIMES * time:
                        break
        except KeyboardInterrupt:
            time = np.inf
    burnt = int(_BURNT * done)
    drawn, off = calibration.draws, 0.0
    if (done - burnt) >= _TIMES * time:
        flat = chains.get_chain(discard=burnt, flat=True)
        drawn = flat[random.choice(len(flat), DRAWS, replace=False)]
        off = float(np.median([abs(density.anew(logs) - density(logs)) for logs in drawn]))
    acceptance = float(np.mean(chains.acceptance_fraction)) if done else 0.0
    sampling = Sampling(walkers, done - burnt, time, acceptance, density.temper, off)
    return replace(calibration, draws=drawn if sampling.converged else calibration.draws, sampling=sampling)


def emcee_module() -> Any:
    """The package emcee; `ImportError` with what to install where it is missing."""
    try:
        import emcee
    except ImportError:
        raise missing("sampling a posterior", "emcee", "posterior") from None
    return emcee


def draw_words(calibration: Calibration) -> list[str]:
    """How the draws were made where by emcee, and a line where those of a normal distribution do not hold."""
    said = [] if calibration.sampling is None else [str(calibration.sampling)]
    if calibration.sampling is not None and calibration.sampling.converged:
        return said
    density = Density(calibration.best, temper_of(calibration.best, calibration.spread))
    fall, usual = -float(np.median([density(logs) for logs in calibration.draws])), 0.5 * len(calibration.best.logs)
    if fall > _FALLS * usual:
        said.append(
            f"the joint draws do not follow the records: the logarithm of their density falls by {fall:.3g} in the "
            f"median, where {usual:g} is usual; --posterior emcee draws from that density, and records of other kinds "
            "tell more"
        )
    return said


def temper_of(best: Best, spread: Spread) -> float:
    """How many times larger the variances of what is determined are than those of least squares, in mean; >= 1."""
    _, curvatures = by_window(best)
    curvature = np.diag(best.problem.unknowns.deviations**-2) + curvatures.sum(axis=0)
    known = np.flatnonzero(spread.determined)
    if not len(known):
        return 1.0
    within = np.ix_(known, known)
    ratios = np.linalg.solve(np.linalg.inv(curvature)[within], spread.covariance[within])
    return max(1.0, float(np.trace(ratios)) / len(known))


def _random_state(seed: int) -> Any:
    return np.random.RandomState(seed % 2**32).get_state()  # what emcee takes
