"""States that are no longer finite: they are found where they arise, and end in one error."""

from __future__ import annotations

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.model import STATE_NAMES, STATE_UNITS


class NotFiniteError(FloatingPointError):
    """A state of a rig has become infinite or not a number: its parameters are beyond what can be computed."""


def check_finite(states: FloatArray, times: FloatArray, where: str) -> None:
    """Raise `NotFiniteError` for the first rig of `states`, shape (rigs, samples, 7), with one that is not finite.

    It names the rig, the state and the time of the sample. `times` (s) has shape (samples,), or (rigs, samples);
    `where` says who asks.
    """
    if np.isfinite(states).all():
        return
    rig, sample, state = (int(index) for index in np.argwhere(~np.isfinite(states))[0])
    time = np.broadcast_to(times, states.shape[:2])[rig, sample]
    raise NotFiniteError(
        f"{where}: {STATE_NAMES[state]} = {states[rig, sample, state]} {STATE_UNITS[state]} of rig {rig} at {time:g} s "
        "is not finite; check the rig's parameters, the gains of its drive, the normal force and the state it began in"
    )
