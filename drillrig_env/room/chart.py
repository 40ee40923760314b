"""The map of this very rig and friction: critical speed, fold and end of stick-slip over the normal force; the orbit.

All of it comes from `drillrig_env.stability`. Critical speed and fold take milliseconds once a rig is known, so that
they follow a slider; the orbit comes behind them. Where stick-slip goes on beyond the fold, at heavy loads, its end
must be followed for each force, a tenth of a second each: that comes when the slider rests. The rig is the one that a
lane has, with the drive that its policy sets.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.drive import Drive
from drillrig_env.friction import Friction
from drillrig_env.model import steady_state
from drillrig_env.rig import Rig
from drillrig_env.stability import critical_speed, end_of_stick_slip, fold_speed, stick_slip_orbit

_FORCES, _FOLLOWED = 40, 10
"""Normal forces for which borders are worked out, and for which the end of stick-slip is followed."""

_SAMPLES = 160
"""Points of an orbit."""

_BEYOND = 1e9
"""What stands on a map for a critical speed that no speed exceeds, rad/s."""

_NOTHING = np.empty(0)


def driven(rig: Rig, drive: Drive | None) -> Rig:
    """The rig as a drive leaves it, for what is worked out from a rig alone."""
    if drive is None:
        return rig
    return replace(rig, k_p=drive.k_p, k_i=drive.k_i, K_E=max(drive.remaining_K_E(rig), 0.0))


@dataclass(frozen=True, eq=False)
class Chart:
    """The borders over normal forces (N), in rad/s, and at the force that is given now.

    `critical` is the speed below which steady rotation is unstable, `end`, over forces of its own, that above which
    there is no stick-slip: the fold, or where stick-slip goes on beyond it, once `followed`, its true end. NaN stands
    where there is none. `note` is a sentence where the chart cannot be told; the arrays are empty then.
    """

    forces: FloatArray = field(default_factory=lambda: _NOTHING)
    critical: FloatArray = field(default_factory=lambda: _NOTHING)
    end_forces: FloatArray = field(default_factory=lambda: _NOTHING)
    end: FloatArray = field(default_factory=lambda: _NOTHING)
    critical_now: float = np.nan
    end_now: float = np.nan
    followed: bool = False
    note: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Plain values, None for what is no number."""
        arrays = {name: _plain(getattr(self, name)) for name in ("forces", "end_forces", "end")}
        arrays["critical"] = _plain(np.minimum(self.critical, _BEYOND))
        now = _plain(np.array([self.critical_now, self.end_now]))
        own = {"critical_now": now[0], "end_now": now[1], "followed": self.followed, "note": self.note}
        return {**arrays, **own}


def chart_of(rig: Rig, friction: Friction, largest_force: float) -> Chart:
    """The chart of a rig for normal forces up to `largest_force` (N), with the fold for the end of stick-slip.

    Under another law than the exponential one there is no fold until it is `followed`.
    """
    forces = np.linspace(largest_force / _FORCES, largest_force, _FORCES)
    asked = np.concatenate([[max(float(friction.normal_force), 1e-9 * largest_force)], forces])
    pressed = replace(friction, normal_force=asked)
    try:
        critical = np.broadcast_to(np.asarray(critical_speed(rig, pressed), dtype=float), asked.shape)
    except (ValueError, FloatingPointError) as error:
        return Chart(note=str(error))
    fold = np.full(asked.shape, np.nan)
    if friction.law == "exponential":
        try:
            fold = np.asarray(fold_speed(rig, pressed), dtype=float)
        except (ValueError, FloatingPointError):  # a load beyond what can be followed, somewhere on the map
            fold = np.array([_number(fold_speed, rig, one) for one in pressed.each()])
    return Chart(forces, critical[1:].copy(), forces, fold[1:], float(critical[0]), float(fold[0]))


def followed(
    chart: Chart, rig: Rig, friction: Friction, largest_force: float, stop: Callable[[], bool]
) -> Chart | None:
    """The chart with the true end of stick-slip, now and over forces up to `largest_force` (N).

    `stop` is asked after each force: where it says so, the chart is no longer wanted, and None comes back.
    """
    if not len(chart.forces):
        return chart
    ends = []
    forces = np.linspace(largest_force / _FOLLOWED, largest_force, _FOLLOWED)
    for force in (max(float(friction.normal_force), 1e-9 * largest_force), *forces):
        one = replace(friction, normal_force=float(force))
        ends.append(_number(lambda rig, one: end_of_stick_slip(rig, one).speed, rig, one))
        if stop():
            return None
    return replace(chart, end_forces=forces, end=np.array(ends[1:]), end_now=ends[0], followed=True)


@lru_cache(maxsize=32)
def deepen(rig: Rig, heaviest: tuple[float, float, float, float]) -> None:
    """Follow the rig's slipping orbits as far as its `heaviest` friction needs them: a second, once for a rig."""
    _number(fold_speed, rig, Friction(*heaviest))


@lru_cache(maxsize=64)
def _orbit(rig: Rig, friction: tuple[float, ...], law: Any, speed: float) -> tuple[list[float], list[float], float]:
    orbit = stick_slip_orbit(rig, Friction(*friction, law=law), speed)
    _, states = orbit.trajectory(_SAMPLES)
    return states[:, 0].tolist(), states[:, 2].tolist(), orbit.period


def orbit_of(rig: Rig, friction: Friction, speed: float) -> dict[str, Any]:
    """The stick-slip cycle and the calm point at a speed reference (rad/s), in the plane of twist and bit speed.

    `twist` (rad) and `bit_speed` (rad/s) are empty where there is no such cycle, and `period` (s) is None.
    """
    calm = steady_state(rig, friction, speed)
    given = tuple(friction.as_array()[0].tolist())
    try:
        twist, bit_speed, period = _orbit(rig, given, friction.law, speed)
    except (ValueError, FloatingPointError):
        twist, bit_speed, period = [], [], None
    return {
        "speed": speed,
        "calm_twist": float(calm[0]),
        "calm_speed": float(calm[2]),
        "twist": twist,
        "bit_speed": bit_speed,
        "period": period,
    }


def _number(find: Callable[[Rig, Friction], Any], rig: Rig, friction: Friction) -> float:
    """A speed, NaN where it cannot be had."""
    try:
        return float(find(rig, friction))
    except (ValueError, FloatingPointError):
        return np.nan


def _plain(values: FloatArray) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in values]
