"""What records can tell of a rig before any fit, and what to fix, weigh or record for them to tell more."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.calibration import BY_RECORDS, NOT_BY_RECORDS, windows_of
from drillrig_env.calibrate.projection import Problem
from drillrig_env.calibrate.records import Record
from drillrig_env.calibrate.spread import tells
from drillrig_env.calibrate.unknowns import OF_FRICTION, WIDE, Unknowns
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.markdown import listed
from drillrig_env.rig import Rig, RigLike

_WEIGHED = 0.02
"""How well what is weighed is known, a relative standard deviation."""

_BEST_WEIGHED = ("J_1", "J_2", "J_3", "K_T", "R", "k_2", "k_1")
"""What is measured by itself most easily comes first."""

_OF_TORQUES = ("J_1", "J_2", "J_3", "k_1", "k_2", "d_1", "d_2", "K_T", "T_f", "C_m", "mu_k", "mu_s - mu_k")
_OF_THE_MOTOR = ("L", "R", "K_T", "K_E", "C_m", "T_f", "k_p", "k_i")

HEADINGS = ["parameter", "relative standard deviation", "told"]


@dataclass(frozen=True, eq=False)
class Look:
    """What records can tell: the curvature of the sum of squares at the rig that the fit would begin with."""

    names: tuple[str, ...]
    curvature: FloatArray  # (names, names), by the logarithms of the parameters
    beforehand: FloatArray  # (names,): standard deviations of the logarithms
    signals: frozenset[str]  # what any record has
    loaded: bool  # whether any record has a normal force above 0

    @property
    def deviations(self) -> FloatArray:
        """Relative standard deviations, shape (names,); of what nothing tells, the 1.1 that it had beforehand."""
        return np.asarray(np.sqrt(np.diag(np.linalg.inv(self.curvature + np.diag(self.beforehand**-2)))))

    @property
    def told(self) -> tuple[str, ...]:
        """The parameters that the records can determine."""
        return self._told(self.beforehand)

    def rows(self) -> list[list[str]]:
        """A row of text for each parameter, under `HEADINGS`."""
        told = self.told
        return [
            [name, f"{100.0 * size:.1f} %", BY_RECORDS if name in told else NOT_BY_RECORDS]
            for name, size in zip(self.names, self.deviations, strict=True)
        ]

    def advice(self) -> list[str]:
        """Which parameter to fix or weigh, and what else to record, a sentence each; one where nothing is missing."""
        beforehand, told, found = self.beforehand.copy(), set(self.told), []
        unseen = [name for name in ("current", "voltage") if name not in self.signals]
        motor = set(_OF_THE_MOTOR) if unseen else set[str]()
        while best := self._best_weighed(beforehand, told, motor):
            name, more = best
            beforehand[self.names.index(name)] = _WEIGHED
            found.append(_weigh(name, self._in_order(more), self.signals))
            told |= {name, *more}
        left = set(self.names) - told
        if some := self._in_order(left & motor):
            found.append(f"Log {listed(unseen)} for {listed(some)}, or fix what is known of these")
            left -= motor
        if not self.loaded and (some := self._in_order(left & set(OF_FRICTION))):
            found.append(f"No record has a load, and nothing tells {listed(some)}: add a record under load")
            left -= set(OF_FRICTION)
        if some := self._in_order(left):
            lead = "Even so these records" if found else "These records"
            found.append(f"{lead} hardly tell {listed(some)}: fix or weigh that, or add records of another kind")
        return found or ["These records can tell every parameter that is looked for"]

    def _told(self, beforehand: FloatArray) -> tuple[str, ...]:
        return tuple(name for name, yes in zip(self.names, tells(self.curvature, beforehand), strict=True) if yes)

    def _best_weighed(self, beforehand: FloatArray, told: set[str], but: set[str]) -> tuple[str, set[str]] | None:
        """What to weigh, `but` some, for the records to tell most others, and which; None where nothing helps."""
        open_ones = [name for name in self.names if beforehand[self.names.index(name)] >= WIDE and name not in but]
        best: tuple[str, set[str]] | None = None
        for name in sorted(open_ones, key=_order):
            weighed = beforehand.copy()
            weighed[self.names.index(name)] = _WEIGHED
            more = set(self._told(weighed)) - told - {name} - but
            if more and (best is None or len(more) > len(best[1])):
                best = name, more
        return best

    def _in_order(self, some: Iterable[str]) -> list[str]:
        return [name for name in self.names if name in set(some)]


def look(
    records: Sequence[Record],
    rig: RigLike = None,
    friction: FrictionLike = None,
    *,
    fix: Mapping[str, float | None] | None = None,
    weigh: Mapping[str, float] | None = None,
    window: float | None = None,
) -> Look:
    """What records can tell before any fit.

    It is the Fisher information at `rig` and `friction`, with the noise that the records show, over all windows; `fix`,
    `weigh` and `window` are those of `calibrate`. Raises as that does, but one window is enough.
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    unknowns = Unknowns.of(rig, friction, fix, weigh)
    windows = windows_of(records, rig, window)
    problem = Problem(windows, unknowns, [one.noise for one in windows])
    logs = np.zeros(len(unknowns.names))
    problem.begin(logs)
    problem.residuals(logs)
    curvature = sum((np.einsum("nij,nik->jk", J, J) for J in problem.derivatives(logs)), np.zeros((len(logs),) * 2))
    signals = frozenset(name for one in windows for name in one.names)
    loaded = any(bool(np.any(one.forces > 0.0)) for one in windows)
    return Look(unknowns.names, curvature, unknowns.deviations, signals, loaded)


def _order(name: str) -> int:
    return _BEST_WEIGHED.index(name) if name in _BEST_WEIGHED else len(_BEST_WEIGHED)


def _weigh(name: str, more: Sequence[str], signals: frozenset[str]) -> str:
    """A sentence of what weighing a parameter would tell."""
    scale = sum(one in _OF_TORQUES for one in more) >= 3
    lead = "One common scale of all torques is open: fix" if scale else "Fix"
    other = ", or log the torque into the string" if scale and "torque_into_string" not in signals else ""
    within = f"--weigh {name}={_WEIGHED:g} where it is known to {100.0 * _WEIGHED:g} %"
    return f"{lead} or weigh {name} (--fix {name}=VALUE, {within}){other}; then these records tell {listed(more)} too"
