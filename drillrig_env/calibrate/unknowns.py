"""What a fit looks for: parameters of a rig and its friction, as logarithms of their ratio to what it begins with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from math import log

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.parameters import closest, refuse
from drillrig_env.rig import Rig

OF_FRICTION = ("mu_k", "mu_s - mu_k", "v_b")
_NOT_LOOKED_FOR = ("eta", "r_1", "omega_s")
"""A gear's ratio is counted, r_1 is one with the coefficients, and omega_s is a choice of the model."""

OF_RIGS = tuple(item.name for item in fields(Rig) if item.name not in _NOT_LOOKED_FOR)

UNITS = {item.name: str(item.metadata["unit"]) for item in fields(Rig)} | dict(
    zip(OF_FRICTION, ("", "", "s/rad"), strict=True)
)
"""Of the parameters by name; empty where there is none."""

WIDE = log(3.0)
"""Standard deviation of a logarithm of which nothing is known but where the fit begins: a factor of 3."""


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Names of the parameters that are looked for, what the others are, and how well each is known beforehand."""

    rig: Rig
    friction: Friction
    names: tuple[str, ...]
    deviations: FloatArray  # of their logarithms, before any record

    @classmethod
    def of(
        cls,
        rig: Rig,
        friction: Friction,
        fix: Mapping[str, float | None] | None = None,
        weigh: Mapping[str, float] | None = None,
    ) -> Unknowns:
        """The unknowns of a rig: all that are above 0 but those to `fix`, at a value or where they are.

        `weigh` has the relative standard deviation of what has been measured by itself, such as a weighed disc.
        Raises `ValueError` for a name that is not one of a parameter, a parameter that is fixed and weighed, one that
        is weighed and 0, a share that is none, and where nothing is left to look for.
        """
        fix, weigh = dict(fix or {}), dict(weigh or {})
        known = (*OF_RIGS, *OF_FRICTION)
        for name in (*fix, *weigh):
            if name not in known:
                raise ValueError(f"calibrate: unknown parameter {name!r}; {closest(name, known)}")
        for name, share in weigh.items():
            if name in fix:
                raise ValueError(f"calibrate: {name} is fixed and weighed; allowed: one of them")
            if not 0.0 < share < 1.0:
                raise refuse("calibrate", f"weigh {name}", share, "", "> 0 and < 1, such as 0.02 for 2 %")
        rig = replace(rig, **{name: value for name, value in fix.items() if value is not None and name in OF_RIGS})
        friction = friction.single()
        start = values_of(rig, friction)
        start.update({name: value for name, value in fix.items() if value is not None and name in OF_FRICTION})
        friction = _friction(friction, start)
        names = tuple(name for name in known if name not in fix and start[name] > 0.0)
        for name in weigh:
            if name not in names:
                raise ValueError(f"calibrate: {name} is weighed, but 0 in the rig that the fit begins with")
        if not names:
            raise ValueError("calibrate: every parameter is fixed or 0; allowed: at least one to look for")
        return cls(rig, friction, names, np.array([weigh.get(name, WIDE) for name in names]))

    def values(self, logs: FloatArray) -> dict[str, float]:
        """The parameters by name at some logarithms, shape (names,)."""
        start = values_of(self.rig, self.friction)
        return {name: start[name] * float(np.exp(step)) for name, step in zip(self.names, logs, strict=True)}

    def at(self, logs: FloatArray) -> tuple[Rig, Friction]:
        """The rig and its friction at some logarithms, shape (names,)."""
        values = {**values_of(self.rig, self.friction), **self.values(logs)}
        rig = replace(self.rig, **{name: values[name] for name in OF_RIGS})
        return rig, _friction(self.friction, values)


def values_of(rig: Rig, friction: Friction) -> dict[str, float]:
    """Every parameter of a rig and its friction that a fit may look for, by name."""
    _, mu_s, mu_k, v_b = friction.as_array()[0].tolist()
    return {name: getattr(rig, name) for name in OF_RIGS} | {"mu_k": mu_k, "mu_s - mu_k": mu_s - mu_k, "v_b": v_b}


def _friction(friction: Friction, values: Mapping[str, float]) -> Friction:
    mu_k = values["mu_k"]
    return replace(friction, mu_s=mu_k + values["mu_s - mu_k"], mu_k=mu_k, v_b=values["v_b"])
