"""The memory of one rig at work, handed from kernel to kernel."""

from __future__ import annotations

import numpy as np

from drillrig_env.friction import CONTACT
from drillrig_env.stepper.exponentials import NODES
from drillrig_env.stepper.ladder import SAMPLES, STATE

WORKSPACE = np.dtype(
    [
        ("y", "f8", STATE),
        ("linear", "f8", NODES),
        ("speed", "f8", NODES),
        ("torque", "f8", NODES),
        ("slope", "f8", NODES),
        ("powers", "f8", NODES),
        ("cubic", "f8", NODES),
        ("between", "f8", NODES),
        ("reduced", "f8", (6, 7)),  # a linear system of the 6 states but for the bit speed
        ("state", "f8", STATE),
        ("term", "f8", STATE),
        ("before", "f8", STATE),
        ("origin", "f8", STATE),  # where a step begins within which the mode may change
        ("end", "f8", STATE),  # and where it would end without
        ("trial", "f8", STATE),
        ("torque_kept", "f8", NODES),
        ("speed_reference", "f8"),  # rad/s; that of the contact is where a mode's equilibrium turns
        ("fast", "f8", STATE),
        ("fast_left", "f8", STATE),
        ("fast_gain", "f8"),  # what of its rate is friction's; 0 where the fast settling is not known yet
        ("fast_rate", "f8"),  # of it, over the step for which it was found
        ("speed_samples", "f8", 2 * SAMPLES),  # the last SAMPLES entries mean nothing, nor do those of torques
        ("torque_samples", "f8", 2 * SAMPLES),
        ("factor", "f8", NODES),  # by which a tilted disc presses more than N_1, at the nodes
        ("cosine", "f8"),  # a cos(m theta_1 + phi) of a tilted disc at the start of the step, and with the sine
        ("sine", "f8"),
        ("angle", "f8", NODES),  # by which m theta_1 has turned since then, at the nodes or between them, rad
        ("before_turning", "f8", NODES),
        ("between_factor", "f8", NODES),
        ("turned", "f8"),  # how far m theta_1 turns in the step, rad
        ("elapsed", "f8"),  # since the start of the period, s; only where there is a tilt
        ("length", "f8"),  # of the step, s; likewise
        ("caution", "f8"),  # how much smaller than usual the bounds on errors are, that friction makes grow
        ("contact", CONTACT),
    ],
    align=True,
)
"""One rig at work: its states less the equilibrium `y`, scratch numbers, samples that `advance` leaves, its contact.

`y` and `contact` are what callers hand to `advance`: places of one type, so that it is compiled once for all of them.
"""


def workspace() -> np.ndarray:
    """Memory for one rig at a time, an array with one WORKSPACE record, to be handed to a kernel.

    A kernel must not make it for itself: to Numba a record is an address in its array, which does not keep the array,
    so that the memory would be given away while the record is in use.
    """
    work = np.zeros(1, dtype=WORKSPACE)
    work["caution"] = 1.0
    return work
