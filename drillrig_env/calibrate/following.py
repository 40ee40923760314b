"""Where a rig is at the beginning of each window: the model run along a record, led by what was measured."""

from __future__ import annotations

import numpy as np

from drillrig_env.arrays import FloatArray, Records
from drillrig_env.calibrate.windows import Windows
from drillrig_env.friction import Friction
from drillrig_env.jit.compiled import compiled
from drillrig_env.model import STATE_NAMES, frictionless_state, steady_state
from drillrig_env.rig import Rig
from drillrig_env.stepper.ladder import UNITS, from_equilibrium, to_states
from drillrig_env.stepper.propagator import advance
from drillrig_env.stepper.tables import step_tables
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
    measured = np.full((n * m, 7), np.nan)
    first = np.full(7, np.nan)
    for i, name in enumerate(windows.names):
        if name in STATE_NAMES:
            measured[:, STATE_NAMES.index(name)] = windows.data[:, :, i].ravel()
            first[STATE_NAMES.index(name)] = windows.before[0, i]
    speeds = [(k, first[k]) for k in (4, 2, 3) if np.isfinite(first[k])]
    speed = float(speeds[0][1]) if speeds else float(windows.references[0, 0])
    fastest = np.nanmax(np.abs(measured[:, 2:5]), initial=0.0)
    if all(abs(one) < _STANDING * fastest for _, one in speeds):
        state = frictionless_state(rig, 0.0)
    else:
        pressed = Friction(float(windows.forces[0, 0]), friction.mu_s, friction.mu_k, friction.v_b, law=friction.law)
        state = np.where(np.isfinite(first), first, steady_state(rig, pressed, max(speed, rig.omega_s)))
    tables = step_tables(rig, windows.period)
    states = np.empty((n * m + 1, 7))
    states[0] = state
    _follow(states, contacts.ravel(), measured, tables.ladders, workspace())
    return states[:-1:m].copy()


@compiled
def _follow(states: FloatArray, contacts: Records, measured: FloatArray, ladders: Records, works: Records) -> None:
    work, ladder = works[0], ladders[0]
    y = work.y
    for i in range(contacts.shape[0]):
        contact = contacts[i]
        from_equilibrium(states[i], contact, ladder, y)
        advance(y, contact, ladders, 0, work, False, UNITS)
        to_states(y, contact, ladder, states[i + 1])
        for k in range(7):
            if np.isfinite(measured[i, k]):
                states[i + 1, k] += _TAKEN * (measured[i, k] - states[i + 1, k])
