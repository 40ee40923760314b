"""What records tell of the motor's circuit and its speed loop without any simulation: where a fit may begin.

Between two samples the armature's equation (4-5f) and the speed loop (4-6) are linear in their parameters, so that
there is one answer, wherever one begins. Noise and coarse samples make it rough (L some 30 % off at 50 Hz), which is
near enough for a fit that would otherwise not find back from an inductance that is several times off.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares, lsq_linear

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.unknowns import Unknowns
from drillrig_env.calibrate.windows import Windows

_WITHIN = 20.0
"""How far a parameter may lie from where the fit begins, as a factor."""

_SOFT = 1.5
"""Residuals beyond so many times their median count less than their squares: in some steps the reference jumps."""

_LEAST = 20
"""Steps below which records tell nothing of this kind."""


def circuit_of(windows: Sequence[Windows], unknowns: Unknowns) -> FloatArray | None:
    """Logarithms to begin a fit with, shape (names,): R, K_E, L, k_p and k_i as records tell them, the rest 0.

    Parameters that are weighed stay within three of their deviations. None where no record has top speed, current and
    voltage, or none of the five is looked for.
    """
    eta = unknowns.rig.eta
    voltages, loops = [], []
    for one in windows:
        if not {"top_speed", "current", "voltage"} <= set(one.names):
            continue
        speed, current, voltage = (_samples(one, name) for name in ("top_speed", "current", "voltage"))
        change = np.diff(current, axis=1) / one.lengths
        voltages.append(_rows(_middle(current), eta * _middle(speed), change, _middle(voltage)))
        error = one.asked - speed[:, 1:]
        wound = np.cumsum((one.references - _middle(speed)) * one.lengths, axis=1)
        loops.append(
            _rows(*(part - np.nanmean(part, axis=1, keepdims=True) for part in (error, wound, voltage[:, 1:])))
        )
    if not voltages:
        return None
    found = _solved(np.concatenate(voltages), ("R", "K_E", "L"), unknowns)
    found |= _solved(np.concatenate(loops), ("k_p", "k_i"), unknowns)
    if not found:
        return None
    farthest = np.minimum(np.log(_WITHIN), 3.0 * unknowns.deviations)
    return np.clip([found.get(name, 0.0) for name in unknowns.names], -farthest, farthest)


def _samples(windows: Windows, name: str) -> FloatArray:
    """A channel at the beginning of each window and at the ends of its steps, shape (n, m + 1)."""
    i = windows.names.index(name)
    return np.concatenate([windows.before[:, None, i], windows.data[:, :, i]], axis=1)


def _middle(samples: FloatArray) -> FloatArray:
    """The mean over each step by the trapezoidal rule, shape (n, m)."""
    return np.asarray(0.5 * (samples[:, 1:] + samples[:, :-1]))


def _rows(*columns: FloatArray) -> FloatArray:
    """The columns of an equation side by side, (steps, columns), of the steps where all were measured."""
    table = np.stack(columns, axis=-1).reshape(-1, len(columns))
    return table[np.isfinite(table).all(axis=1)]


def _solved(table: FloatArray, names: tuple[str, ...], unknowns: Unknowns) -> dict[str, float]:
    """Logarithms of the parameters of one equation that are looked for; its last column is what the others give."""
    held = [name for name in names if name in unknowns.names]
    if not held or len(table) < _LEAST:
        return {}
    given = table[:, -1] - sum(
        getattr(unknowns.rig, name) * table[:, i] for i, name in enumerate(names) if name not in held
    )
    sides = table[:, [names.index(name) for name in held]]
    start = np.array([getattr(unknowns.rig, name) for name in held])
    bounds = (start / _WITHIN, start * _WITHIN)
    rough = lsq_linear(sides, given, bounds).x
    noise = max(_SOFT * float(np.median(np.abs(sides @ rough - given))), 1e-12 * float(np.abs(given).max()))

    def residuals(values: FloatArray) -> FloatArray:
        return np.asarray(sides @ values - given)

    def slopes(_: FloatArray) -> FloatArray:
        return sides.copy()  # SciPy before 1.16 weighs its rows in place

    inside = np.clip(rough, 1.001 * bounds[0], 0.999 * bounds[1])
    found = least_squares(residuals, inside, slopes, bounds=bounds, x_scale=start, loss="soft_l1", f_scale=noise)
    return dict(zip(held, np.log(found.x / start).tolist(), strict=True))
