"""Dry friction between brake pin and bit: a law a file, and the contact as the kernels take it."""

from drillrig_env.friction.contact import CONTACT, Contact, contacts_of, press
from drillrig_env.friction.exponential import Friction, FrictionLike, torque_in_zone, zone_of

__all__ = ["CONTACT", "Contact", "Friction", "FrictionLike", "contacts_of", "press", "torque_in_zone", "zone_of"]
