"""Least squares from many starts: the parameters of a rig and its friction that fit all records best."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.circuit import circuit_of
from drillrig_env.calibrate.kept import Ended
from drillrig_env.calibrate.projection import FREE, Problem
from drillrig_env.calibrate.search import Search
from drillrig_env.stepper.finite import NotFiniteError

FARTHEST = np.log(30.0)
"""How far a parameter may go from where the fit begins, as a logarithm."""

_INSIDE = 0.999 * FARTHEST
"""A start on a bound would stay there."""

_SPREAD = np.log(1.6)
"""How far the starts lie apart."""

_FIRST, _LAST, _KEPT = 10, 60, 4
"""Most steps from each start, and of the last fits, from so many that did best."""

_TOLERANCE = 1e-6

_ROUNDS, _STEADY = 5, 0.01
"""Last fits of the best parameters, at most, and by what share the noise that they leave may still change."""

_SOFT = 3.0
"""Residuals beyond so many deviations of the noise count less than their squares (soft-L1)."""


@dataclass(frozen=True, eq=False)
class Best:
    """The best parameters found: `logs` (names,), the `problem` with the noise as it came out, and how others did."""

    problem: Problem
    logs: FloatArray
    cost: float  # half the sum of squares in units of the noise, soft as it is
    costs: FloatArray  # of all starts, ascending, in units of the noise with which they were compared
    residuals: list[FloatArray]
    derivatives: list[FloatArray]
    starts: int = 1  # that were done
    stopped: bool = False  # by Ctrl-C before all were


def fit(
    problem: Problem,
    starts: int,
    seed: int,
    told: Callable[[int, float], None] | None = None,
    search: Search | None = None,
    begin: FloatArray | None = None,
) -> Best:
    """Fit from `starts` starts, the first at the unknowns' own values or at `begin`, the others drawn around by `seed`.

    Without `begin` the second has the motor's circuit and speed loop as the records tell them, where they do.
    `told` hears after each start how many are done and the best cost so far. Noise is what was measured of it at first;
    for the last fits, what the best of the first leaves over, where that is more; and the best of them is fitted until
    the noise that it is fitted with is what it leaves. `NotFiniteError` where the model runs
    away from every start. Ctrl-C ends the starts, and the last fit goes on with the best so far; another one ends that.
    `search` has the engine that does it and keeps what is done; by default it is this process, and nothing is kept.
    """
    search, measured = search or Search(), problem.noise
    drawn = np.random.default_rng(seed).uniform(-_SPREAD, _SPREAD, (starts, len(problem.unknowns.names)))
    narrow = np.minimum(1.0, 3.0 * problem.unknowns.deviations / _SPREAD)
    drawn[0] = 0.0
    places = drawn * narrow if begin is None else np.clip(begin + drawn * narrow, -_INSIDE, _INSIDE)
    circuit = circuit_of(problem.windows, problem.unknowns) if begin is None and starts > 1 else None
    if circuit is not None:
        places[1] = circuit
    done: list[tuple[int, Ended]] = []
    stopped = False
    try:
        for one in search.each(_ended, problem, _FIRST, list(places)):
            done.append(one)
            if told is not None:
                told(len(done), min(ended.cost for _, ended in done))
    except KeyboardInterrupt:
        stopped = True
        if all(ended.failure for _, ended in done):
            raise
    found = [ended for _, ended in sorted(done, key=lambda one: (one[1].cost, one[0])) if not ended.failure]
    if not found:
        raise NotFiniteError(done[-1][1].failure)
    problem.begin(found[0].logs)
    problem.noise = _noise_left(problem, measured, problem.residuals(found[0].logs))
    kept = 1 if stopped else _KEPT
    last = sorted(search.each(_ended, problem, _LAST, [one.logs for one in found[:kept]]), key=lambda one: one[0])
    failures = [one.failure for _, one in last]
    if all(failures):
        raise NotFiniteError(failures[0])
    best = min((one for _, one in last), key=lambda one: one.cost)
    costs = np.array(sorted(one.cost for one in (*(one for _, one in last), *found[kept:])))
    for _ in range(0 if stopped else _ROUNDS):
        problem.begin(best.logs)
        residuals = problem.residuals(best.logs)
        noise = _noise_left(problem, measured, residuals)
        if all(np.allclose(new, old, rtol=_STEADY) for new, old in zip(noise, problem.noise, strict=True)):
            break
        problem.noise = noise
        ((_, best),) = search.each(_ended, problem, _LAST, [best.logs])
        if best.failure:
            raise NotFiniteError(best.failure)
    else:
        problem.begin(best.logs)
        residuals = problem.residuals(best.logs)
    return Best(problem, best.logs, best.cost, costs, residuals, problem.derivatives(best.logs), len(done), stopped)


def _ended(problem: Problem, steps: int, logs: FloatArray) -> Ended:
    """Where one fit from one start ends, of at most so many steps."""
    try:
        result = _solve(problem, logs, steps)
    except NotFiniteError as error:
        return Ended(np.inf, np.empty(0), str(error))
    return Ended(float(result.cost), np.asarray(result.x))


def _solve(problem: Problem, logs: FloatArray, steps: int) -> OptimizeResult:
    """One fit from one start, of at most so many steps.

    Each step begins with the windows' starts at the best parameters so far: those of a step that was too far may lie in
    another cycle, from where no shorter step finds back.
    """
    problem.begin(logs)
    known = 1.0 / problem.unknowns.deviations
    least, kept = np.inf, problem.starts

    def residuals(x: FloatArray) -> FloatArray:
        nonlocal least, kept
        problem.starts = list(kept)
        try:
            found = np.concatenate([*(one.ravel() for one in problem.residuals(x)), known * x])
        except NotFiniteError:
            return np.full(size, _HOPELESS)
        cost = float(np.sum(np.sqrt(1.0 + (found / _SOFT) ** 2)))
        if cost < least:
            least, kept = cost, list(problem.starts)
        return found

    def derivatives(x: FloatArray) -> FloatArray:
        problem.starts = list(kept)
        problem.residuals(x)
        return np.concatenate([*(one.reshape(-1, len(x)) for one in problem.derivatives(x)), np.diag(known)])

    size = sum(one.size for one in problem.residuals(logs)) + len(logs)
    return least_squares(
        residuals,
        logs,
        derivatives,
        bounds=(-FARTHEST, FARTHEST),
        x_scale=0.1,
        loss="soft_l1",
        f_scale=_SOFT,
        ftol=_TOLERANCE,
        xtol=_TOLERANCE,
        max_nfev=steps,
    )


def soft(residuals: FloatArray) -> FloatArray:
    """The soft squares of residuals, of whose sum the cost is half: their squares where they are small."""
    return np.asarray(2.0 * _SOFT**2 * (np.sqrt(1.0 + (residuals / _SOFT) ** 2) - 1.0))


def weights_of(residuals: FloatArray) -> FloatArray:
    """How much each residual counts in the soft sum of squares, beside its square: 1 for a small one."""
    return np.asarray(1.0 / np.sqrt(1.0 + (residuals / _SOFT) ** 2))


_HOPELESS = 1e3
"""The residual of parameters with which the model runs away."""


def _noise_left(problem: Problem, measured: Sequence[FloatArray], residuals: Sequence[FloatArray]) -> list[FloatArray]:
    """The noise by channel: what residuals leave over, where it is more than what was measured of it."""
    found = []
    for windows, least, noise, left in zip(problem.windows, measured, problem.noise, residuals, strict=True):
        table = left[:, :-FREE].reshape(-1, len(windows.names))
        held = np.isfinite(windows.data).reshape(-1, len(windows.names))
        spread = [1.4826 * np.median(np.abs(table[held[:, i], i])) for i in range(table.shape[1])]
        found.append(np.maximum(least, noise * np.array(spread)))
    return found
