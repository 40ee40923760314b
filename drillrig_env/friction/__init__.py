"""Dry friction between brake pin and bit: a law a file, and the contact as the kernels take it."""

from drillrig_env.friction.contact import CONTACT, Contact
from drillrig_env.friction.exponential import Friction, FrictionLike

__all__ = ["CONTACT", "Contact", "Friction", "FrictionLike"]
