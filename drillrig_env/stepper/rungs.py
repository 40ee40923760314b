"""The tables of the steps of a rig, from exponentials of its matrix, in the rig's own units and back."""

from __future__ import annotations

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.drive import Drive, Limiting
from drillrig_env.model import friction_input, jacobian, torque_into_string
from drillrig_env.rig import Rig
from drillrig_env.stepper.exponentials import BETWEEN, RADAU_NODES, doubled_steps, variation_of_constants
from drillrig_env.stepper.ladder import (
    DEPTH,
    RUNG,
    RUNGS,
    SAMPLED_RUNGS,
    SAMPLES,
    SAMPLING,
    UNIT_RUNG,
    UNITS,
)
from drillrig_env.stepper.units import Units

SHORTEST = slice(UNIT_RUNG + 1, RUNGS)
"""The rungs that are made only when a rig needs them."""


def in_units(
    rig: Rig, drive: Drive | Limiting | None, units: Units, period: float
) -> tuple[FloatArray, FloatArray, float]:
    """Jacobian, input of the friction torque and period in the rig's own units."""
    M = jacobian(rig, drive=drive) * np.outer(1.0 / units.states, units.states) * units.time
    return M, friction_input(rig) / units.states * (units.torque * units.time), period / units.time


def longest_rungs(M: FloatArray, b: FloatArray, step: float, units: Units) -> np.ndarray:
    """The rungs down to UNIT_RUNG, records of RUNG; M, b and the longest `step` are in the rig's own units."""
    return _rungs(
        M, b, step, units, slice(UNIT_RUNG + 1), variation_of_constants(M, b, step, RADAU_NODES, UNIT_RUNG + 1)
    )


def shortest_rungs(M: FloatArray, b: FloatArray, step: float, units: Units) -> np.ndarray:
    """The rungs below UNIT_RUNG; arguments as for `longest_rungs`."""
    return _rungs(M, b, step, units, SHORTEST, doubled_steps(M, b, step / (2.0 * UNITS), RADAU_NODES, DEPTH))


def _rungs(
    M: FloatArray, b: FloatArray, step: float, units: Units, part: slice, at_nodes: tuple[FloatArray, FloatArray]
) -> np.ndarray:
    """A part of the rungs, from the state at the nodes."""
    (from_state, from_torque), (per_state, per_torque) = at_nodes, _per_unit(units)
    between_from_state, between_from_torque = (table[part, :, 2] for table in doubled_steps(M, b, step, BETWEEN, RUNGS))
    rungs = np.zeros(len(from_state), dtype=RUNG)
    rungs["node_from_state"] = from_state[:, :, 2].transpose(0, 2, 1) * per_state[:, 2, None]
    rungs["node_from_torque"] = from_torque[:, :, 2] * per_torque[2]
    rungs["between_from_state"] = between_from_state.transpose(0, 2, 1) * per_state[:, 2, None]
    rungs["between_from_torque"] = between_from_torque.transpose(0, 2, 1) * per_torque[2]
    rungs["state_from_state"][:, :, :7] = from_state[:, -1].transpose(0, 2, 1) * per_state
    rungs["state_from_torque"][:, :, :7] = from_torque[:, -1].transpose(0, 2, 1) * per_torque
    return rungs


def sampling_of(rig: Rig, M: FloatArray, b: FloatArray, step: float, units: Units) -> np.ndarray:
    """The tables of the samples within the longest steps, a SAMPLING record; the other arguments as above."""
    sampling = np.zeros((), dtype=SAMPLING)
    rows = {"speed": np.eye(7)[2], "torque": torque_into_string(rig, np.eye(7))}
    (per_state, per_torque), before = _per_unit(units), 0
    for r in range(SAMPLED_RUNGS):
        count = SAMPLES >> r
        times = np.arange(1, count + 1) / count
        (from_state,), (from_torque,) = variation_of_constants(M, b, step / 2**r, times)
        from_state, from_torque = from_state * per_state.T, from_torque * per_torque[:, None]
        for name, row in rows.items():
            for source, table in (("state", row @ from_state), ("torque", row @ from_torque)):
                own = slice(before * table.shape[1], (before + count) * table.shape[1])
                sampling[f"{name}_from_{source}"][own] = table.T.ravel()
        before += count
    return sampling


def _per_unit(units: Units) -> tuple[FloatArray, FloatArray]:
    """What tables in the rig's own units are to be multiplied by: those from states, those from torques."""
    return np.outer(1.0 / units.states, units.states), units.states / units.torque
