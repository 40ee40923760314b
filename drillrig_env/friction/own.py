"""A law of friction of the user's own: the coefficient by speed, its slope and its curvature, as compiled functions.

    import numba
    from drillrig_env import Friction, Law, simulate

    @numba.njit
    def coefficient(speed, mu_s, mu_k, v_b):
        return mu_k + (mu_s - mu_k) / (1.0 + v_b * speed)

    ...  # slope and curvature likewise

    hyperbola = Law("hyperbola", coefficient, slope, curvature)
    simulate(friction=Friction(20.0, law=hyperbola))

Kernels call it by the address of its machine code, and need not be compiled for it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import numba
import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.jit.compiled import NOT_COMPILED, is_compilable, reason_of
from drillrig_env.jit.pointer import SIGNATURE
from drillrig_env.modules import found_in

Function: TypeAlias = Callable[[float, float, float, float], float]
"""Of the speed (rad/s, > 0), mu_s, mu_k and v_b (s/rad)."""

_PARAMETERS = ((0.5, 0.306, 1.0), (0.83, 0.21, 0.37), (0.4, 0.35, 5.3))
"""mu_s, mu_k and v_b with which a law is tried out."""

_SPEEDS = np.geomspace(0.0137, 17.3, 41)
"""Speeds at which it is, times 1/v_b."""

_STEP, _OFF, _ROUNDING = 1e-3, 1e-5, 1e-8
"""Of differences, as a share of speed; how far a derivative may be off as a share of it, and of value over speed."""


@dataclass(frozen=True)
class Law:
    """A law by name: functions of speed (rad/s), mu_s, mu_k and v_b (s/rad), plain or compiled by Numba.

    `coefficient` is that of friction at a speed above omega_s, not negative and smooth; `slope` its derivative by speed
    (s/rad) and `curvature` its second one. Below omega_s the torque is the straight line to its value there.
    `source` is "file.py:name" of a law that was read from there. A pickle holds that, or else the functions, which then
    must be importable.

    Raises `ValueError` for a function that cannot be compiled, a coefficient that is negative or not finite, and for a
    slope or curvature that differs from what differences give.

    >>> from drillrig_env import Friction, Law, Rig
    >>> def coefficient(speed, mu_s, mu_k, v_b):
    ...     return mu_k + (mu_s - mu_k) / (1.0 + v_b * speed)
    ...
    >>> def slope(speed, mu_s, mu_k, v_b):
    ...     return -(mu_s - mu_k) * v_b / (1.0 + v_b * speed) ** 2
    ...
    >>> def curvature(speed, mu_s, mu_k, v_b):
    ...     return 2.0 * (mu_s - mu_k) * v_b**2 / (1.0 + v_b * speed) ** 3
    ...
    >>> law = Law("hyperbola", coefficient, slope, curvature)
    >>> round(float(Friction(20.0, law=law).torque(Rig(), 2.0)), 4)  # N m
    0.3595
    """

    name: str
    coefficient: Function
    slope: Function
    curvature: Function
    source: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        for mu_s, mu_k, v_b in _PARAMETERS:
            self._check(mu_s, mu_k, v_b)

    def __reduce__(self) -> tuple[Any, ...]:
        if self.source:
            return Law.from_file, (self.source,)
        return Law, (self.name, self.coefficient, self.slope, self.curvature)

    def __deepcopy__(self, _memo: Any) -> Law:
        return self

    def __str__(self) -> str:
        return self.source or self.name

    @classmethod
    def from_file(cls, source: str) -> Law:
        """The law that a Python file holds under a name: "file.py:name". `ValueError` where there is none.

        `source` is file and name.
        """
        return replace(found_in(source, cls, "law"), source=source)

    def placed(self) -> Law:
        """The law with the whole path of its file as `source`, which holds in any folder."""
        file, _, name = self.source.rpartition(":")
        return replace(self, source=f"{Path(file).absolute()}:{name}")

    def __call__(self, speed: float, mu_s: float, mu_k: float, v_b: float) -> tuple[float, float, float]:
        """Coefficient, slope (s/rad) and curvature at a speed (rad/s)."""
        out = np.empty(3)
        _machine_code(self).ctypes(speed, mu_s, mu_k, v_b, out.ctypes.data_as(_machine_code(self).ctypes.argtypes[4]))
        return float(out[0]), float(out[1]), float(out[2])

    def _check(self, mu_s: float, mu_k: float, v_b: float) -> None:
        speeds = _SPEEDS / v_b
        steps = _STEP * speeds
        near, far = ([self._at(speeds + k * steps * way, mu_s, mu_k, v_b) for way in (-1, 1)] for k in (1, 2))
        values = self._at(speeds, mu_s, mu_k, v_b)
        where = f"mu_s = {mu_s}, mu_k = {mu_k}, v_b = {v_b} s/rad"
        wrong = np.flatnonzero(~(np.isfinite(values).all(axis=1) & (values[:, 0] >= 0.0)))
        if len(wrong):
            speed, value = speeds[wrong[0]], values[wrong[0]].tolist()
            raise ValueError(
                f"Law {self.name!r}: coefficient, slope and curvature = {value} at {speed:.4g} rad/s ({where}) are not "
                "allowed; allowed: finite numbers, the coefficient >= 0"
            )
        by_differences = (8.0 * (near[1] - near[0]) - (far[1] - far[0])) / (12.0 * steps[:, None])
        for column, name in ((1, "slope"), (2, "curvature")):
            given, expected = values[:, column], by_differences[:, column - 1]
            size = np.abs(values[:, column - 1]).max() / speeds
            wrong = np.flatnonzero(np.abs(given - expected) > _OFF * np.abs(expected) + _ROUNDING * size)
            if len(wrong):
                i = wrong[0]
                raise ValueError(
                    f"Law {self.name!r}: {name} = {given[i]:.6g} at {speeds[i]:.4g} rad/s ({where}) is not allowed; "
                    f"allowed: {expected[i]:.6g}, which differences give"
                )

    def _at(self, speeds: FloatArray, mu_s: float, mu_k: float, v_b: float) -> FloatArray:
        return np.array([self(float(speed), mu_s, mu_k, v_b) for speed in speeds])


def address_of(law: Law) -> int:
    """The address of a law's machine code, which stays where it is for as long as the process lives."""
    return int(_machine_code(law).address)


@cache
def _machine_code(law: Law) -> Any:
    coefficient, slope, curvature = (_compiled(law, name) for name in ("coefficient", "slope", "curvature"))

    def evaluate(speed: float, mu_s: float, mu_k: float, v_b: float, out: Any) -> None:
        out[0] = coefficient(speed, mu_s, mu_k, v_b)
        out[1] = slope(speed, mu_s, mu_k, v_b)
        out[2] = curvature(speed, mu_s, mu_k, v_b)

    try:
        return numba.cfunc(SIGNATURE, error_model="numpy")(evaluate)
    except NOT_COMPILED as error:
        raise ValueError(f"Law {law.name!r}: its functions cannot be compiled: {reason_of(error)}") from error


def _compiled(law: Law, name: str) -> Any:
    function: Any = getattr(law, name)
    if not is_compilable(function):
        raise ValueError(f"Law {law.name!r}: {name} = {function!r} is no function of speed, mu_s, mu_k and v_b")
    return function if hasattr(function, "py_func") else numba.njit(error_model="numpy")(function)
