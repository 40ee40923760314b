"""Steps that meet the kinks of a law: find where, land there, and go on with the other piece of the law.

A solved step gives T_r1 as a cubic of time, with which the state at any time within the step is known
(`drillrig_env.stepper.landing`). So a step ends just where |x_3| = omega_s, or where a linear fall meets its floor.

A stick begins with x_3 settling within microseconds, which is taken out of the state and followed apart
(`drillrig_env.stepper.settling`).
"""

from __future__ import annotations

from math import exp

from drillrig_env.arrays import FloatArray, Record
from drillrig_env.friction.law import zone_beyond
from drillrig_env.jit.compiled import compiled
from drillrig_env.stepper.collocation import solve_nodes
from drillrig_env.stepper.ladder import STATE
from drillrig_env.stepper.landing import land
from drillrig_env.stepper.reach import rounding_of_speed
from drillrig_env.stepper.settling import split
from drillrig_env.stepper.turning import begin_turning

_PIECES = 4
"""Most pieces of the law within one step; with more, shorter steps are taken."""


@compiled
def step_through_kinks(
    y: FloatArray, zone: int, contact: Record, ladder: Record, rung: int, work: Record, reach: float
) -> bool:
    """Take a step that was solved up to `reach`, across the kinks within it; False, and `y` as it was, if it cannot.

    The arguments are those of `solve_nodes`, which has left its solution in `work`.
    """
    for i in range(STATE):
        work.before[i] = y[i]
    left = 1.0
    for piece in range(_PIECES):
        amplitude, rate = 0.0, 0.0
        rough_stick = zone == 0 and (piece > 0 or reach == 0.0)
        if rough_stick:
            amplitude, rate = split(y, contact, ladder, rung, work)
            if rate == 0.0 and piece == 0:
                break  # it has been solved already, and what makes it rough is no fast settling
        if piece > 0 or rough_stick:
            reach = solve_nodes(y, zone, contact, ladder, rung, work)
        settling = amplitude * exp(rate * min(reach, left))
        if reach == 0.0 or (reach < left and abs(settling) > ladder.settled):
            break
        if not land(y, ladder, rung, work, min(reach, left)):
            break
        if settling != 0.0:
            for i in range(STATE):
                y[i] += settling * work.fast[i]
        if reach >= left:
            return True
        x_3 = y[2] + contact.speed_reference
        at_knee = zone != 0 and abs(abs(x_3) - contact.knee) < abs(abs(x_3) - contact.omega_s)
        away = abs(abs(x_3) - (contact.knee if at_knee else contact.omega_s))
        if not away <= ladder.landed and not away <= rounding_of_speed(y, contact, ladder):
            break
        left -= reach
        if contact.tilt > 0.0:
            work.elapsed += reach * work.length
            begin_turning(y, contact, work)
        zone = zone_beyond(zone, x_3 > 0.0, at_knee, contact.knee <= contact.omega_s)
    for i in range(STATE):
        y[i] = work.before[i]
    return False
