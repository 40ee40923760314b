"""What takes long the first time, done once before anybody waits for it: kernels are compiled or loaded."""

from __future__ import annotations

from drillrig_env.room.charts import Asked, prepare, quick, thorough, with_orbits
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.setting import Setting
from drillrig_env.room.stock import Stock


def warm_up(stock: Stock, setting: Setting) -> None:
    """Play one step of a setting and draw its maps; what cannot be played is told to whoever asks for it later."""
    try:
        lanes = Lanes(setting, stock)
        lanes.step()
    except ValueError:
        return
    asked = Asked.of(lanes)
    thorough(asked, with_orbits(asked, quick(asked)), lambda: False)
    prepare(asked)
