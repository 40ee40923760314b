"""Where stick-slip meets the slipping orbits, at grazing: does the branch p1 end there, or go on to higher speeds?

Of an orbit that just touches the stick zone let M be the monodromy matrix from its lowest point on. A change that keeps
the bit out of the zone grows by M. One that takes it in is clipped: the bit leaves the zone with the speed omega_s at
which it entered, so that the change grows by M (1 - e_3 e_3^T). (All that this takes is a narrow stick zone.) Let l be
the multipliers of M but for the trivial one, and r those of M (1 - e_3 e_3^T). Orbits on either side of grazing lie at
speeds of the same side where the products of all (1 - l) and of all (1 - r) differ in sign (Feigin): then p1 and p2
meet and end there. p1 ends there as the stable branch where every r lies in the unit circle, and p2, which begins, has
one multiplier above 1.

As the slipping orbits themselves, l and r belong to the rig and the depth, whatever the friction.
"""

from __future__ import annotations

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.model import jacobian
from drillrig_env.rig import Rig
from drillrig_env.stability.fourier_orbit import FourierOrbit
from drillrig_env.stability.multipliers import OFF_SECTION
from drillrig_env.stepper.units import units_of


def grazing_multipliers(rig: Rig, wave: FloatArray, frequency: float, log_gain: float) -> tuple[float, float]:
    """Of the orbit that grazes, the product of all (1 - l), and the largest |r|."""
    orbit = FourierOrbit(rig, Friction(0.0, v_b=1.0), 0.0, wave, frequency, log_gain)
    units, order = units_of(rig), np.arange(len(orbit.spectrum))
    rates = (1j * frequency * order @ orbit.spectrum).real * units.time / units.states
    M = orbit.monodromy(0.0)
    # The section of lowest bit speeds, on which the rate of x_3 is 0, is crossed by the rates.
    across = jacobian(rig, -np.exp(log_gain - wave[0]))[2] * units.states
    returned = M - np.outer(rates / (across @ rates), across @ M)
    clipped = returned[np.ix_(OFF_SECTION, OFF_SECTION)]
    return float(np.linalg.det(np.eye(7) - returned)), float(np.abs(np.linalg.eigvals(clipped)).max())
