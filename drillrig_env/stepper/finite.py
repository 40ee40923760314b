"""States that are no longer finite: they are found where they arise, and end in one error.

The stepper leaves NaN where a step is not solved, however short, and infinity where a state has grown beyond all
bounds.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.model import STATE_NAMES, STATE_UNITS

_UNSOLVED = "a step before it does not converge down to 2e-12 of a control period"


class NotFiniteError(FloatingPointError):
    """A state or reward has become infinite, or a step cannot be solved."""


def check_finite(
    states: FloatArray,
    times: FloatArray,
    where: str,
    rigs: npt.NDArray[np.intp] | None = None,
    seeds: Sequence[int | None] = (),
) -> None:
    """Raise `NotFiniteError` for the first rig of `states`, shape (n, samples, 7), with one that is not finite.

    It names the rig, the state and the time of the sample. `times` (s) has shape (samples,), or (n, samples);
    `where` says who asks; `rigs`, shape (n,), are the rigs' numbers (default: their places), and `seeds` holds the
    seed of each rig by its number, where they have one.
    """
    if np.isfinite(states).all():
        return
    place, sample, state = (int(index) for index in np.argwhere(~np.isfinite(states))[0])
    time = np.broadcast_to(times, states.shape[:2])[place, sample]
    rig = place if rigs is None else int(rigs[place])
    seed = f" (seed {seeds[rig]})" if rig < len(seeds) and seeds[rig] is not None else ""
    reason = "is not finite" if np.isinf(states[place, sample, state]) else f"is not known: {_UNSOLVED}"
    raise NotFiniteError(
        f"{where}: {STATE_NAMES[state]} = {states[place, sample, state]} {STATE_UNITS[state]} "
        f"of rig {rig}{seed} at {time:g} s {reason}; "
        "check the rig's parameters, the gains of its drive, the normal force and the state it began in"
    )
