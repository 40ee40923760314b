"""Residuals of windows whose starts are free, and their derivatives with the starts projected out.

Each window has eight numbers of its own, which nobody is interested in: the state it begins in, and how long before the
logger shows them its reference jumps, since that need not be at samples. For given parameters they are those that fit
best, found window by window; what is left is a problem in the parameters alone, whose
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

_SHORTER = 0.25
"""How much of a step that was too far is tried next."""

_ENOUGH = 1e-6
"""A step that takes less than this share off the sum of squares is the last one."""

FREE = 8
"""Numbers of a window's own: the 7 states it begins in, and the lag (s) of its reference."""

_LAG = 0.5
"""Deviation of that lag, in sample periods: a jump has happened since the last sample that does not show it."""

_LAGS = np.linspace(0.0, 1.0, 9)
"""Lags that are tried at first, in sample periods: currents are fast, and the cost has more than one minimum."""

_STEP = 1e-5
"""Of differences: of a logarithm, and of a state in its scale."""


@dataclass(eq=False)
class Problem:
    """Residuals of several records for the parameters of one rig; `starts` are kept from one call to the next."""

    windows: list[Windows]
    unknowns: Unknowns
    noise: list[FloatArray]  # (channels,) of each record: what a residual is counted in
    starts: list[FloatArray] = field(default_factory=list)  # (n, FREE) of each record

    def __post_init__(self) -> None:
        states = units_of(self.unknowns.rig).states
        self.loose = [np.append(states, _LAG * one.sample_period) for one in self.windows]
        """How far starts may reasonably lie from where the model, led along a record, has them; (FREE,) of each."""

    def begin(self, logs: FloatArray) -> None:
        """Find where every window begins anew, for the parameters at some logarithms."""
        rig, friction = self.unknowns.at(logs)
        self.starts = [_led(one, rig, friction) for one in self.windows]
        self.expected = [starts.copy() for starts in self.starts]
        for i, one in enumerate(self.windows):
            if one.jumps.size:
                self._try_lags(i, rig, friction)

    def residuals(self, logs: FloatArray) -> list[FloatArray]:
        """Residuals of each record at the best starts, of the data and of the starts; (n, m * channels + FREE).

        In units of the noise; 0 where nothing was measured.
        """
        rig, friction = self.unknowns.at(logs)
        return [self._best(i, rig, friction) for i in range(len(self.windows))]

    def derivatives(self, logs: FloatArray) -> list[FloatArray]:
        """Derivatives of the residuals by the logarithms, the starts projected out; (n, m * channels + FREE, names)."""
        found = []
        for i in range(len(self.windows)):
            by_start, by_log = self._slopes(i, logs)
            basis, _ = np.linalg.qr(by_start)
            found.append(by_log - basis @ (basis.transpose(0, 2, 1) @ by_log))
        return found

    def tangents(self, logs: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        """Of each record, how the best starts move with the logarithms, and what starts can do to the residuals.

        Shapes (n, FREE, names), and (n, m * channels + FREE, FREE) of orthonormal columns.
        """
        found = []
        for i in range(len(self.windows)):
            by_start, by_log = self._slopes(i, logs)
            basis, triangle = np.linalg.qr(by_start)
            moves = -np.linalg.solve(triangle, basis.transpose(0, 2, 1) @ by_log)
            found.append((moves * self.loose[i][:, None], basis))
        return found

    def residuals_from(self, logs: FloatArray, starts: list[FloatArray]) -> list[FloatArray]:
        """Residuals as `residuals` gives them, from these starts of each record, shape (n, FREE)."""
        rig, friction = self.unknowns.at(logs)
        found = []
        for i, one in enumerate(starts):
            lags = np.clip(one[:, 7:], -self.windows[i].sample_period, 0.0)
            found.append(self._full(i, rig, friction, np.concatenate([one[:, :7], lags], axis=1)))
        return found

    def _slopes(self, i: int, logs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives of a record's residuals by the starts in their scales, and by the logarithms."""
        rig, friction = self.unknowns.at(logs)
        here = self._data_residuals(i, rig, friction, self.starts[i])
        by_start = self._by_start(i, rig, friction, here)
        by_log = np.zeros((*by_start.shape[:2], len(logs)))
        for k in range(len(logs)):
            moved = logs.copy()
            moved[k] += _STEP
            there = self._data_residuals(i, *self.unknowns.at(moved), self.starts[i])
            by_log[:, : here.shape[1], k] = (there - here) / _STEP
        return by_start, by_log

    def _best(self, i: int, rig: Rig, friction: Friction) -> FloatArray:
        """Find the best starts of a record, and its residuals there."""
        starts, here = self.starts[i], self._full(i, rig, friction, self.starts[i])
        cost = np.sum(here**2, axis=1)
        shares = np.ones(len(starts))
        for _ in range(_ROUNDS):
            by_start = self._by_start(i, rig, friction, here[:, :-FREE], starts)
            full = -np.stack([np.linalg.lstsq(J, r, rcond=None)[0] for J, r in zip(by_start, here, strict=True)])
            hoped = cost - np.sum((here + np.einsum("nij,nj->ni", by_start, full)) ** 2, axis=1)
            tried = starts + shares[:, None] * full * self.loose[i]
            tried[:, 7] = np.clip(tried[:, 7], -self.windows[i].sample_period, 0.0)
            there = self._full(i, rig, friction, tried)
            new = np.sum(there**2, axis=1)
            better = new < cost
            too_far = np.logical_and(~better, hoped > _ENOUGH * cost)
            gained = float(np.sum(cost[better] - new[better])) / max(float(cost.sum()), 1e-300)
            starts = np.where(better[:, None], tried, starts)
            here = np.where(better[:, None], there, here)
            cost = np.where(better, new, cost)
            shares = np.where(too_far, _SHORTER * shares, 1.0)
            if gained < _ENOUGH and not too_far.any():
                break
        self.starts[i] = starts
        return here

    def _try_lags(self, i: int, rig: Rig, friction: Friction) -> None:
        """Begin the windows of a record with those of some lags that do best."""
        tried = np.repeat(self.starts[i][None], len(_LAGS), axis=0)
        tried[:, :, 7] = -np.multiply.outer(_LAGS, np.full(len(self.windows[i]), self.windows[i].sample_period))
        costs = [np.sum(self._full(i, rig, friction, one) ** 2, axis=1) for one in tried]
        self.starts[i] = tried[np.argmin(costs, axis=0), np.arange(len(self.windows[i]))]

    def _full(self, i: int, rig: Rig, friction: Friction, starts: FloatArray) -> FloatArray:
        """Residuals of the data, and of the starts."""
        data = self._data_residuals(i, rig, friction, starts)
        return np.concatenate([data, (starts - self.expected[i]) / self.loose[i]], axis=1)

    def _data_residuals(self, i: int, rig: Rig, friction: Friction, starts: FloatArray) -> FloatArray:
        windows = self.windows[i]
        states = run_windows(windows, rig, friction, starts)
        shown = windows.shown(rig, states.reshape(-1, *windows.forces.shape, 7))
        residuals = np.where(np.isfinite(windows.data), (shown - windows.data) / self.noise[i], 0.0)
        return residuals.reshape(len(starts), -1)

    def _by_start(
        self, i: int, rig: Rig, friction: Friction, here: FloatArray, starts: FloatArray | None = None
    ) -> FloatArray:
        """Derivatives of the residuals by the starts, in their scales; (n, m * channels + FREE, FREE)."""
        starts = self.starts[i] if starts is None else starts
        n, size = here.shape
        steps = np.append(np.full(7, _STEP), -_STEP)  # a lag above 0 is out of bounds
        moved = np.repeat(starts[None], FREE, axis=0) + (steps * self.loose[i] * np.eye(FREE))[:, None, :]
        there = np.empty((FREE, n, size))
        there[:-1] = self._data_residuals(i, rig, friction, moved[:-1].reshape(-1, FREE)).reshape(-1, n, size)
        jumps = self.windows[i].jumps.size
        there[-1] = self._data_residuals(i, rig, friction, moved[-1]) if jumps else here
        found = np.zeros((n, size + FREE, FREE))
        found[:, :size] = ((there - here) / steps[:, None, None]).transpose(1, 2, 0)
        found[:, size:] = np.eye(FREE)
        return found


def _led(windows: Windows, rig: Rig, friction: Friction) -> FloatArray:
    """Where the model, led along the whole record, is at the beginning of each window, and a usual lag; (n, FREE)."""
    whole = windows if windows.whole is None else windows.whole
    starts = starts_of(whole, rig, friction, _contacts(whole.forces, whole.references, rig, friction))
    states = starts if windows.places is None else starts[windows.places]
    return np.concatenate([states, np.full((len(states), 1), -_LAG * windows.sample_period)], axis=1)


def _contacts(forces: FloatArray, references: FloatArray, rig: Rig, friction: Friction) -> np.ndarray:
    """Records of CONTACT of the same shape as some normal forces (N) and references (rad/s)."""
    pressed = Friction(forces.ravel(), friction.mu_s, friction.mu_k, friction.v_b, law=friction.law)
    return pressed.contacts(rig, references.ravel(), forces.size).reshape(forces.shape)


def run_windows(windows: Windows, rig: Rig, friction: Friction, starts: FloatArray) -> FloatArray:
    """States at the end of every step of every window from its start, shape (copies * n, m, 7).

    `starts` has shape (copies * n, FREE): those of all windows, one copy after the other, with the lags of the first.
    """
    forces, references, lengths = windows.forces, windows.references, windows.lengths
    if windows.jumps.size:  # two intervals a step, one before and one after a jump in it
        held, *both = windows.lagging(starts[: len(windows), 7])
        forces, references = np.repeat(forces, 2, axis=1), _alternating(*both)
        lengths = _alternating(held, lengths - held)
    contacts = _contacts(forces, references, rig, friction)
    _, period = step_of(rig, windows.period)
    states = advance_along(rig, contacts, np.arange(contacts.shape[1]), starts[:, :7], lengths, period)
    if not np.isfinite(states).all():
        raise NotFiniteError("calibrate: the model runs away from one of the starts")
    return states[:, 1::2] if windows.jumps.size else states


def _alternating(first: FloatArray, second: FloatArray) -> FloatArray:
    """Values of shape (n, m) each in turn, shape (n, 2 m)."""
    return np.stack([first, second], axis=-1).reshape(len(first), -1)
