"""Where a rig is at the beginning of each window: the model run along a record, led by what was measured."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray, Records
from drillrig_env.calibrate.windows import Windows
from drillrig_env.friction import Friction
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.model import STATE_NAMES, frictionless_state, steady_state
from drillrig_env.rig import Rig
from drillrig_env.stepper.along import advance_over, ladders_for, parts_of
from drillrig_env.stepper.ladder import from_equilibrium, to_states
from drillrig_env.stepper.times import step_of
from drillrig_env.stepper.workspace import workspace

_STANDING = 0.03
"""A rig stands whose speeds are below this share of its fastest one."""

_TAKEN = 0.3
"""How much of the difference between measured and model the model takes over in a step."""


def starts_of(windows: Windows, rig: Rig, friction: Friction, contacts: np.ndarray) -> FloatArray:
    """States at the beginning of each window, shape (n, 7), from a run along all of them.

    `contacts` are those of the windows, records of CONTACT of shape (n, m). The run begins at rest where nothing turns,
    else in steady rotation at the first measured speed, and follows what is measured from step to step.
    """
    n, m, _ = windows.data.shape
    measured, before = np.full((n, m, 7), np.nan), np.full((n, 7), np.nan)
    for i, name in enumerate(windows.names):
        if name in STATE_NAMES:
            measured[:, :, STATE_NAMES.index(name)] = windows.data[:, :, i]
            before[:, STATE_NAMES.index(name)] = windows.before[:, i]
    first = before[0]
    speeds = [(k, first[k]) for k in (4, 2, 3) if np.isfinite(first[k])]
    speed = float(speeds[0][1]) if speeds else float(windows.references[0, 0])
    fastest = np.nanmax(np.abs(measured[:, 2:5]), initial=0.0)
    if all(abs(one) < _STANDING * fastest for _, one in speeds):
        state = frictionless_state(rig, 0.0)
    else:
        pressed = Friction(float(windows.forces[0, 0]), friction.mu_s, friction.mu_k, friction.v_b, law=friction.law)
        state = np.where(np.isfinite(first), first, steady_state(rig, pressed, max(speed, rig.omega_s)))
    _, period = step_of(rig, windows.period)
    begins = np.where(windows.follows[:, None], np.nan, before)
    parts = parts_of(windows.lengths, period)
    coarse, fine = ladders_for(rig, parts, period)
    states = np.empty((n, 7))
    _follow(states, state, contacts, begins, measured, parts, period, coarse, fine, workspace())
    return states


@compiled
def _follow(
    states: FloatArray,
    start: FloatArray,
    contacts: Records,
    begins: FloatArray,
    measured: FloatArray,
    parts: npt.NDArray[np.int64],
    period: float,
    coarse: Records,
    fine: Records,
    works: Records,
) -> None:
    work, ladder = works[0], coarse[0]
    y, state = work.y, start.copy()
    for window in range(contacts.shape[0]):
        _lead(state, begins[window], 1.0)
        states[window] = state
        for i in range(contacts.shape[1]):
            contact = contacts[window, i]
            from_equilibrium(state, contact, ladder, y)
            advance_over(contact, coarse, fine, work, parts[window, i], period, 0.0)
            to_states(y, contact, ladder, state)
            _lead(state, measured[window, i], _TAKEN)


@inlined
def _lead(state: FloatArray, measured: FloatArray, share: float) -> None:
    """Take over a share of the difference to what was measured, where something was."""
    for k in range(7):
        if np.isfinite(measured[k]):
            state[k] += share * (measured[k] - state[k])
