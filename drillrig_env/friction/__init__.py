"""Dry friction between brake pin and bit: a law a file."""

from drillrig_env.friction.exponential import Friction, FrictionLike, torque_in_zone, zone_of

__all__ = ["Friction", "FrictionLike", "torque_in_zone", "zone_of"]
