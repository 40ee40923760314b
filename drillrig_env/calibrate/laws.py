"""Which law of friction a rig's records speak for: each is fitted, and judged in windows that no fit has seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import t as student

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.calibration import STARTS, Calibration, calibrate
from drillrig_env.calibrate.fit import soft
from drillrig_env.calibrate.followed import NotFollowedError
from drillrig_env.calibrate.projection import FREE, Problem
from drillrig_env.calibrate.records import Record
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.friction.contact import LAWS
from drillrig_env.rig import Rig, RigLike

AUTO = "auto"
"""In place of a law's name: choose it."""

_OTHERS = 4
"""Starts of all laws but the first, at its best parameters and around them."""

_VISCOUS = 0.02
"""Viscous loss of the bit that a fit begins with, as a share of the string's impedance: below what a record shows."""

_LEAST_HELD = 2
"""Windows under load that must be held out, to tell how far the laws' scores scatter."""

_SPEEDS = np.geomspace(1e-3, 1e3, 4001)
"""Speeds in units of 1 / v_b at which a law is looked at for where half of its fall is done."""


@dataclass(frozen=True, eq=False)
class LawScore:
    """How well a law follows the records: mean squares of what it leaves over, soft, in units of the noise.

    Where only noise is left they are about 1. `behind` is by how much the law is worse than the best one in windows
    held out, in mean, and `within` how far that would scatter in 95 of 100 cases if it were none.
    """

    law: str
    fitted: float
    held_out: float
    behind: float
    within: float

    @property
    def told_apart(self) -> bool:
        """Whether the law is worse than the best one by more than chance has it."""
        return self.behind > self.within


def with_viscous_part(rig: RigLike) -> Rig:
    """A rig whose bit loses a little to what is around it (C_1), where it loses nothing, so that a fit looks for it."""
    rig = Rig.of(rig)
    return rig if rig.C_1 > 0.0 else replace(rig, C_1=_VISCOUS * rig.impedance)


def choose_law(
    records: Sequence[Record],
    rig: RigLike = None,
    friction: FrictionLike = None,
    *,
    starts: int = STARTS,
    told: Callable[[int, float], None] | None = None,
    **options: Any,
) -> Calibration:
    """Fit each law of friction, with a viscous part (C_1) unless that is fixed, and take the best in windows held out.

    `records`, `rig` and `friction` are as for `calibrate`.

    The law of `friction` is fitted from `starts` starts, and the others from its best parameters and around them, the
    speed over which friction falls being the same. `told` hears of the starts of all of them. `options` and what is
    raised are those of `calibrate`; and `ValueError` where fewer than 2 windows under load are held out.
    The result has a score for each law in `laws`, the best first.
    """
    friction = Friction.of(friction).single()
    if "C_1" not in (options.get("fix") or {}):
        rig = with_viscous_part(rig)
    done = 0

    def heard(count: int, cost: float) -> None:
        if told is not None:
            told(done + count, cost)

    found: list[Calibration] = []
    for law in _laws(friction):
        count = min(starts, _OTHERS) if found else starts
        begin = found[0].best.logs if found else None
        try:
            fitted = calibrate(records, rig, _alike(friction, law), starts=count, begin=begin, told=heard, **options)
        except NotFollowedError:
            if not found:
                raise
            done += count
            continue  # a law that is nowhere near the records is none to choose
        found.append(fitted)
        done += fitted.best.starts
        _check_held(fitted)
        if fitted.best.stopped:
            break
    noise = [np.min(each, axis=0) for each in zip(*(one.best.problem.noise for one in found), strict=True)]
    costs = [_held_costs(one, noise) for one in found]
    order = sorted(range(len(found)), key=lambda k: float(np.mean(costs[k])))
    best = order[0]
    scores = []
    for k in order:
        behind = costs[k] - costs[best]
        scatter = float(student.ppf(0.95, len(behind) - 1) * behind.std(ddof=1) / np.sqrt(len(behind)))
        own = _squares(found[k].best.residuals, found[k].best.problem.noise, noise)
        scores.append(LawScore(str(found[k].friction.law), own, float(costs[k].mean()), float(behind.mean()), scatter))
    ended = replace(found[best].best, starts=done, stopped=found[-1].best.stopped)
    return replace(found[best], best=ended, laws=tuple(scores))


def starts_of_all(starts: int, friction: FrictionLike = None) -> int:
    """How many starts `choose_law` has, where the first law has `starts` of them."""
    return starts + (len(_laws(Friction.of(friction))) - 1) * min(starts, _OTHERS)


def law_rows(scores: Sequence[LawScore]) -> list[list[str]]:
    """A row of text for each law, below `LAW_HEADINGS`."""
    return [
        [one.law, f"{one.fitted:.3f}", f"{one.held_out:.3f}", f"{one.behind:.3f} +- {one.within:.3f}" if k else ""]
        for k, one in enumerate(scores)
    ]


LAW_HEADINGS = ["law", "left over, fitted", "left over, held out", "behind the best"]


def law_words(scores: Sequence[LawScore]) -> str:
    """Which law is taken, and from which others the records cannot tell it."""
    best, *others = scores
    alike = [one.law for one in others if not one.told_apart]
    taken = f"law of friction: {best.law}, the best in windows held out"
    if not others:
        return f"law of friction: {best.law}; no other was fitted"
    return f"{taken}, but no better than {' and '.join(alike)} within the noise" if alike else taken


def _laws(friction: Friction) -> list[Any]:
    """The laws to choose from: that of a friction, then all others that have a name."""
    return [friction.law, *(law for law in LAWS if law != friction.law)]


def _alike(friction: Friction, law: Any) -> Friction:
    """A friction of another law that has done half of its fall at the same speed."""
    other = replace(friction, law=law)
    return replace(other, v_b=friction.v_b * _half_fallen(other) / _half_fallen(friction))


def _half_fallen(friction: Friction) -> float:
    """The speed (rad/s) at which half of the fall is done; 1 / v_b where that is never."""
    rig, v_b = Rig(omega_s=1e-9), float(np.max(friction.v_b))
    speeds = _SPEEDS / v_b
    torque = np.asarray(replace(friction, normal_force=1.0).torque(rig, speeds))
    half = rig.r_1 * 0.5 * (np.max(friction.mu_s) + np.max(friction.mu_k))
    below = np.flatnonzero(torque < half)
    return float(speeds[below[0]]) if len(below) else 1.0 / v_b


def _check_held(calibration: Calibration) -> None:
    count = sum(int((one.forces.max(axis=1) > 0.0).sum()) for one in calibration.held if len(one))
    if count < _LEAST_HELD:
        raise ValueError(
            f"calibrate: {count} windows under load are held out, too few to choose a law of friction by; allowed: >= "
            f"{_LEAST_HELD}; longer records under load, shorter windows, a larger share held out, or name the law"
        )


def _held_costs(calibration: Calibration, noise: list[FloatArray]) -> FloatArray:
    """The mean soft square of what is left over in each window under load that was held out."""
    problem = Problem(list(calibration.held), calibration.unknowns, noise)
    problem.begin(calibration.best.logs)
    costs = []
    for windows, left in zip(problem.windows, problem.residuals(calibration.best.logs), strict=True):
        loaded = np.flatnonzero(windows.forces.max(axis=1, initial=0.0) > 0.0)
        costs.append(np.array([_mean_square(left[k], windows.data[k]) for k in loaded]))
    return np.concatenate(costs)


def _mean_square(left: FloatArray, data: FloatArray) -> float:
    held = np.isfinite(data).ravel()
    return float(np.mean(soft(left[: data.size][held])))


def _squares(residuals: list[FloatArray], of: list[FloatArray], noise: list[FloatArray]) -> float:
    """The mean soft square of residuals in units of another noise than theirs."""
    found = []
    for left, own, other in zip(residuals, of, noise, strict=True):
        table = left[:, :-FREE].reshape(-1, len(own)) * (own / other)
        found.append(soft(table[table != 0.0]))
    return float(np.mean(np.concatenate(found)))
