"""What takes long the first time, done once before anybody waits for it: kernels are compiled or loaded."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

from drillrig_env.room.charts import Asked, prepare, quick, thorough, with_orbits
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.setting import Setting
from drillrig_env.room.stock import Stock


def warm_up(stock: Stock, setting: Setting) -> None:
    """Play one step of a setting and draw its maps; what cannot be is told to whoever asks for it later."""
    with suppress(Exception):
        lanes = Lanes(setting, stock)
        lanes.step()
        asked = Asked.of(lanes)
        thorough(asked, with_orbits(asked, quick(asked)), lambda: False)
        prepare(asked)


def playable(stock: Stock, setting: Setting) -> tuple[Setting, str]:
    """The setting, and a sentence where lane B must begin with another policy than it says, since that cannot be made.

    Raises `ValueError` for a rig or a friction that cannot be played at all.
    """
    try:
        Lanes(setting, stock)
    except ValueError as error:
        plain = replace(setting, b=setting.a)
        Lanes(plain, stock)
        return plain, f"lane B begins with {plain.b}: {error}"
    return setting, ""
