"""Dry friction between brake pin and bit: its laws, and the contact as the kernels take it."""

from drillrig_env.friction.contact import CONTACT, Contact
from drillrig_env.friction.friction import Friction, FrictionLike

__all__ = ["CONTACT", "Contact", "Friction", "FrictionLike"]
