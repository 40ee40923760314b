"""Residuals of windows whose starts are free, and their derivatives with the starts projected out.

Each window has seven numbers of its own, the state it begins in, which nobody is interested in. For given parameters
they are those that fit best, found window by window; what is left is a problem in the parameters alone, whose
derivative is that of the residuals with what the starts could do taken out: variable projection (Golub & Pereyra, 1973;
Kaufman, 1975).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.following import starts_of
from drillrig_env.calibrate.unknowns import Unknowns
from drillrig_env.calibrate.windows import Windows
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.stepper.along import advance_along
from drillrig_env.stepper.finite import NotFiniteError
from drillrig_env.stepper.times import step_of
from drillrig_env.stepper.units import units_of

_ROUNDS = 8
"""Most Gauss-Newton steps for the starts at given parameters."""

_ENOUGH = 1e-6
"""A step that takes less than this share off the sum of squares is the last one."""

_STEP = 1e-5
"""Of differences: of a logarithm, and of a state in its scale."""


@dataclass(eq=False)
class Problem:
    """Residuals of several records for the parameters of one rig; `starts` are kept from one call to the next."""

    windows: list[Windows]
    unknowns: Unknowns
    noise: list[FloatArray]  # (channels,) of each record: what a residual is counted in
    starts: list[FloatArray] = field(default_factory=list)  # (n, 7) of each record

    def __post_init__(self) -> None:
        self.loose = units_of(self.unknowns.rig).states
        """How far the starts may reasonably lie from where the model, led along the record, has them; shape (7,)."""

    def begin(self, logs: FloatArray) -> None:
        """Find where every window begins anew, for the parameters at some logarithms."""
        rig, friction = self.unknowns.at(logs)
        self.starts = [_led(one, rig, friction) for one in self.windows]
        self.expected = [starts.copy() for starts in self.starts]

    def residuals(self, logs: FloatArray) -> list[FloatArray]:
        """Residuals of each record at the best starts, shape (n, m * channels + 7): those of the data, and of starts.

        In units of the noise; 0 where nothing was measured.
        """
        rig, friction = self.unknowns.at(logs)
        return [self._best(i, rig, friction) for i in range(len(self.windows))]

    def derivatives(self, logs: FloatArray) -> list[FloatArray]:
        """Derivatives of the residuals by the logarithms, the starts projected out; (n, m * channels + 7, names)."""
        rig, friction = self.unknowns.at(logs)
        found = []
        for i in range(len(self.windows)):
            here = self._data_residuals(i, rig, friction, self.starts[i])
            by_start = self._by_start(i, rig, friction, here)
            by_log = np.zeros((*by_start.shape[:2], len(logs)))
            for k in range(len(logs)):
                moved = logs.copy()
                moved[k] += _STEP
                there = self._data_residuals(i, *self.unknowns.at(moved), self.starts[i])
                by_log[:, : here.shape[1], k] = (there - here) / _STEP
            basis, _ = np.linalg.qr(by_start)
            found.append(by_log - basis @ (basis.transpose(0, 2, 1) @ by_log))
        return found

    def _best(self, i: int, rig: Rig, friction: Friction) -> FloatArray:
        """Find the best starts of a record, and its residuals there."""
        starts, here = self.starts[i], self._full(i, rig, friction, self.starts[i])
        cost = np.sum(here**2, axis=1)
        for _ in range(_ROUNDS):
            by_start = self._by_start(i, rig, friction, here[:, :-7], starts)
            step = -np.stack([np.linalg.lstsq(J, r, rcond=None)[0] for J, r in zip(by_start, here, strict=True)])
            tried = starts + step * self.loose
            there = self._full(i, rig, friction, tried)
            new = np.sum(there**2, axis=1)
            better = new < cost
            gained = float(np.sum(cost[better] - new[better])) / max(float(cost.sum()), 1e-300)
            starts = np.where(better[:, None], tried, starts)
            here = np.where(better[:, None], there, here)
            cost = np.where(better, new, cost)
            if gained < _ENOUGH:
                break
        self.starts[i] = starts
        return here

    def _full(self, i: int, rig: Rig, friction: Friction, starts: FloatArray) -> FloatArray:
        """Residuals of the data, and of the starts."""
        data = self._data_residuals(i, rig, friction, starts)
        return np.concatenate([data, (starts - self.expected[i]) / self.loose], axis=1)

    def _data_residuals(self, i: int, rig: Rig, friction: Friction, starts: FloatArray) -> FloatArray:
        windows = self.windows[i]
        shown = windows.shown(rig, run_windows(windows, rig, friction, starts))
        residuals = (shown - windows.data) / self.noise[i]
        return np.where(np.isfinite(windows.data), residuals, 0.0).reshape(len(windows), -1)

    def _by_start(
        self, i: int, rig: Rig, friction: Friction, here: FloatArray, starts: FloatArray | None = None
    ) -> FloatArray:
        """Derivatives of the residuals by the starts, in their scales; (n, m * channels + 7, 7)."""
        starts = self.starts[i] if starts is None else starts
        n, size = here.shape
        moved = np.repeat(starts[None], 7, axis=0) + (_STEP * self.loose * np.eye(7))[:, None, :]
        windows = self.windows[i]
        states = run_windows(windows, rig, friction, moved.reshape(-1, 7)).reshape(7, n, -1, 7)
        shown = np.stack([windows.shown(rig, one) for one in states])
        there = np.where(np.isfinite(windows.data), (shown - windows.data) / self.noise[i], 0.0).reshape(7, n, -1)
        found = np.zeros((n, size + 7, 7))
        found[:, :size] = ((there - here) / _STEP).transpose(1, 2, 0)
        found[:, size:] = np.eye(7)
        return found


def _led(windows: Windows, rig: Rig, friction: Friction) -> FloatArray:
    """Where the model, led along the whole record, is at the beginning of each window; (n, 7)."""
    whole = windows if windows.whole is None else windows.whole
    starts = starts_of(whole, rig, friction, _contacts(whole, rig, friction))
    return starts if windows.places is None else starts[windows.places]


def _contacts(windows: Windows, rig: Rig, friction: Friction) -> np.ndarray:
    """Records of CONTACT of all steps, shape (n, m)."""
    forces = windows.forces.ravel()
    pressed = Friction(forces, friction.mu_s, friction.mu_k, friction.v_b, law=friction.law)
    return pressed.contacts(rig, windows.references.ravel(), forces.size).reshape(windows.forces.shape)


def run_windows(windows: Windows, rig: Rig, friction: Friction, starts: FloatArray) -> FloatArray:
    """States at the end of every step of every window from its start, shape (copies * n, m, 7).

    `starts` has shape (copies * n, 7): those of all windows, one copy after the other.
    """
    contacts = _contacts(windows, rig, friction)
    _, period = step_of(rig, windows.period)
    states = advance_along(rig, contacts, np.arange(contacts.shape[1]), starts, windows.lengths, period)
    if not np.isfinite(states).all():
        raise NotFiniteError("calibrate: the model runs away from one of the starts")
    return states
