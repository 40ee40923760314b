"""What a calibrated rig means: its critical speed and where stick-slip ends, each with how well it is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drillrig_env.calibrate.calibration import Calibration
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.stability import critical_speed, end_of_stick_slip

_WIDE = 3.0
"""Above so large a ratio of its ends an interval says that the records do not determine a speed."""

_LEAST_DRAWS = 0.9
"""Share of the draws that must have a speed."""


@dataclass(frozen=True)
class Meaning:
    """A speed (rad/s) of the best rig, and its 90 % interval; NaN where none is known."""

    name: str
    value: float
    low: float
    high: float

    @property
    def determined(self) -> bool:
        """Whether the records tell it at all."""
        return bool(np.isfinite(self.low) and np.isfinite(self.value) and self.high < _WIDE * self.low)


def meanings(calibration: Calibration, normal_force: float, draws: int | None = None) -> list[Meaning]:
    """Critical speed and end of stick-slip at a normal force (N), over the first `draws` joint draws; default all."""
    rigs = calibration.rigs()[:draws]
    wanted: tuple[tuple[str, Callable[[Rig, Friction], float]], ...] = (
        ("critical speed", lambda rig, friction: float(critical_speed(rig, friction))),
        ("end of stick-slip", lambda rig, friction: float(end_of_stick_slip(rig, friction).speed)),
    )
    found = []
    for name, speed in wanted:
        value = _of(speed, calibration.rig, calibration.friction, normal_force)
        values = np.array([_of(speed, rig, friction, normal_force) for rig, friction in rigs])
        held = values[np.isfinite(values)]
        if len(held) < _LEAST_DRAWS * len(values):
            found.append(Meaning(name, value, np.nan, np.nan))
        else:
            low, high = np.quantile(held, [0.05, 0.95])
            found.append(Meaning(name, value, float(low), float(high)))
    return found


def _of(speed: Callable[[Rig, Friction], float], rig: Rig, friction: Friction, normal_force: float) -> float:
    """The speed of a rig; NaN where there is none, or it cannot be told."""
    try:
        value = speed(rig, replace(friction, normal_force=normal_force))
    except ValueError:
        return np.nan
    return value if np.isfinite(value) else np.nan
