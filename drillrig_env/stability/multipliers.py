"""Floquet multipliers from the derivative of the flow over one period (the monodromy matrix).

While the bit slips, a small change y of the states obeys y' = (M + b sigma(t) e_3^T) y, with sigma the slope of
friction at the bit speed of the orbit. It is solved by the stepper's collocation, with steps of equal length: what is
fast in M costs nothing, and nothing is left to differences of trajectories, which near the stick zone would enter it.
"""

from __future__ import annotations

from functools import reduce

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.model import jacobian
from drillrig_env.rig import Rig
from drillrig_env.stepper.exponentials import RADAU_NODES, variation_of_constants
from drillrig_env.stepper.units import units_of

OFF_SECTION = [0, 1, 3, 4, 5, 6]
"""The states that vary on the section x_3 = omega_ref."""


def slipping_monodromy(rig: Rig, period: float, slopes: FloatArray) -> FloatArray:
    """The monodromy matrix of a period (s) without stick, shape (7, 7), in the units of `units_of`.

    `slopes` holds the slope of friction (N m s/rad) at the Radau nodes of n equal steps, shape (n, nodes).
    """
    units, steps = units_of(rig), len(slopes)
    M = jacobian(rig) * np.outer(1.0 / units.states, units.states) * units.time
    acceleration = np.eye(7)[2]
    tables = variation_of_constants(M, acceleration, period / units.time / steps, RADAU_NODES)
    from_state, from_rate = (table[0] for table in tables)
    rates = -slopes[:, None, :] * (units.time / rig.J_1)
    speeds = np.linalg.solve(np.eye(len(RADAU_NODES)) - from_rate[:, 2] * rates, from_state[:, 2])
    steps_taken = from_state[-1] + from_rate[-1] @ (rates.transpose(0, 2, 1) * speeds)
    return np.asarray(reduce(lambda before, step: step @ before, steps_taken))


def multipliers_of(monodromy: FloatArray, rates: FloatArray) -> npt.NDArray[np.complex128]:
    """The 7 Floquet multipliers, largest first, from the monodromy matrix and the states' rates on the section.

    One of them is 1, exactly: the rates themselves, along the orbit. The others are those of the return to the section.
    """
    returned = monodromy - np.outer(rates / rates[2], monodromy[2])
    others = np.linalg.eigvals(returned[np.ix_(OFF_SECTION, OFF_SECTION)])
    values = np.append(others.astype(complex), 1.0)
    return values[np.argsort(-np.abs(values), kind="stable")]
