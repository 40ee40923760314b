"""The return of a rig to a section of the state space, and its derivative: what shooting for periodic orbits needs.

The section is x_3 = omega_ref with the bit speeding up for the first time after a stick: an orbit of stick-slip comes
there once a period, however often its bit speed passes the reference.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.friction.law import torque_in_zone, zone_of
from drillrig_env.model import equilibrium, frictionless_state, jacobian
from drillrig_env.rig import Rig
from drillrig_env.stability.multipliers import multipliers_of
from drillrig_env.stability.tangent import COLUMNS, SHORTEST, follow
from drillrig_env.stepper.exponentials import doubled_steps
from drillrig_env.stepper.tables import step_tables
from drillrig_env.stepper.units import time_of, units_of
from drillrig_env.stepper.workspace import workspace

_PERIOD = 0.05
"""Longest step, in the rig's own unit of time."""

_THINNEST = 5e-7
"""The edge of a stick zone that doubles resolve, as a share of the speeds that the bit gains."""

_TOLERANCE = 1e-7
"""That of the steps, as for `simulate`: its own error is what is left of a gap that is closed."""


@dataclass(frozen=True, eq=False)
class Passage:
    """A passage of the section after another: the state there, the time from there (s), and the share of it in stick.

    `derivative` is that of the flow over this time, by the 7 states and the speed reference, shape (7, 8), for states
    counted from the frictionless equilibrium, in their own units (`units_of`) and that of speed. `rates` are the rates
    of the states there, in the same units.
    """

    state: FloatArray
    time: float
    stuck: float
    derivative: FloatArray
    rates: FloatArray

    @property
    def slopes(self) -> FloatArray:
        """The derivative of the passage as a point of the section; row 3 is 0."""
        return np.asarray(self.derivative - np.outer(self.rates / self.rates[2], self.derivative[2]))

    @property
    def multipliers(self) -> npt.NDArray[np.complex128]:
        """The 7 Floquet multipliers, largest first, where the passage is that of a periodic orbit."""
        return multipliers_of(self.derivative[:, :7], self.rates)


@dataclass(frozen=True, eq=False)
class ReturnMap:
    """The return to the section of a rig under one friction."""

    rig: Rig
    friction: Friction

    @cached_property
    def _stick(self) -> tuple[FloatArray, FloatArray]:
        """The flow in the stick zone over the step of each rung, and the state that holds still there at 1 rad/s."""
        units, slope = units_of(self.rig), float(self.friction.break_loose(self._seen)) / self._seen.omega_s
        scale = np.outer(units.states, 1.0 / units.states)
        M = jacobian(self.rig, slope) / scale * units.time
        flows, _ = doubled_steps(M, np.zeros(7), _PERIOD, np.ones(1), SHORTEST + 1)
        still = equilibrium(self.rig, slope, 1.0) - frictionless_state(self.rig, 1.0)
        return np.ascontiguousarray(flows[:, 0] * scale), still

    @cached_property
    def _seen(self) -> Rig:
        """The rig; where its stick zone is too thin for doubles, with one as thin as they resolve."""
        thinnest = _THINNEST * (units_of(self.rig).speed + float(speed_gained(self.rig, self.friction)[0]))
        return replace(self.rig, omega_s=thinnest) if self.rig.omega_s < thinnest else self.rig

    @cached_property
    def _contact(self) -> np.ndarray:
        return self.friction.contacts(self._seen, 0.0)

    def _torque_at(self, speed: float) -> float:
        contact = self._contact[0]
        return float(torque_in_zone(zone_of(speed, contact["omega_s"], contact["knee"]), speed, contact)[0])

    @cached_property
    def _slipping(self) -> FloatArray:
        return jacobian(self.rig)

    def __call__(self, state: FloatArray, speed_reference: float, with_derivative: bool = True) -> Passage | None:
        """The next passage of the section from a state (7,) at a speed reference (rad/s); None where there is none.

        Without `with_derivative` that is the identity, and the passage is found in less time.
        """
        units = units_of(self.rig)
        period = _PERIOD * units.time
        at_rest = frictionless_state(self.rig, speed_reference)
        work, derivative = workspace(), np.eye(7, COLUMNS)
        y = work["y"][0]
        y[:7] = state - at_rest
        tables = step_tables(self.rig, period, _TOLERANCE)
        work["contact"] = self._contact
        work["contact"]["speed_reference"] = speed_reference
        periods, in_stick = follow(work, derivative, tables.ladders[0], *self._stick, with_derivative)
        if np.isnan(periods):
            return None
        rates = self._slipping @ y[:7]
        rates[2] -= self._torque_at(speed_reference) / self.rig.J_1
        late = y[2] / rates[2]  # less than the shortest step
        there, rates = at_rest + y[:7] - late * rates, rates / units.states
        scaled = derivative / units.states[:, None] * np.append(units.states, units.speed)
        return Passage(there, float(periods * period - late), in_stick / periods, scaled, rates)


def speed_gained(rig: Rig, friction: Friction) -> FloatArray:
    """The speed (rad/s) that disc 1 gains when it breaks loose, but for a factor of about 1, one entry a friction."""
    normal_force, mu_s, mu_k, _ = friction.as_array().T
    return np.asarray(normal_force * rig.r_1 * (mu_s - mu_k) * time_of(rig) / rig.J_1)
