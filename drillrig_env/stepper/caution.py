"""How careful steps must be with a friction: what it makes of errors from one step to the next."""

from __future__ import annotations

from math import sqrt

from drillrig_env.arrays import Record
from drillrig_env.friction.contact import EXPONENTIAL
from drillrig_env.friction.law import steepest_of
from drillrig_env.jit.compiled import inlined

_PER_FALL, _GROWING = 1.0 / 1.5, 4.0
"""How much bounds tighten where friction falls faster with speed than to 1/e in 1/1.5 own units, or grows in time."""

_PER_TILT = 4.0
"""How much bounds tighten where the normal force changes by itself while disc 1 turns by 1 rad."""


@inlined
def caution_for(contact: Record, ladder: Record) -> float:
    """How much smaller than usual bounds on errors must be: more where friction falls fast, with speed or in time."""
    steepest, bend = (contact.static - contact.kinetic) * contact.v_b, contact.v_b
    if contact.law != EXPONENTIAL:
        steepest, bend = steepest_of(contact)
    growth: float = ladder.growth * steepest * (1.0 + contact.tilt)
    caution: float = max(1.0, _PER_FALL * bend * ladder.unit[2])
    caution = max(caution, _PER_TILT * contact.tilt * contact.turns)
    return caution if growth <= 1.0 else max(caution, _GROWING * growth * sqrt(growth))
