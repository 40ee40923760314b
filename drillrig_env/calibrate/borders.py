"""Where a calibrated rig changes what it does: critical speed and end of stick-slip over the load, for all draws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import nan

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.calibration import Calibration
from drillrig_env.engine import Engine, used
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.stability import critical_speed, end_of_stick_slip

LOADS = 6
"""Normal forces at which the borders are found, evenly spread up to the largest load of the records."""


@dataclass(frozen=True, eq=False)
class Borders:
    """Critical speed and end of stick-slip (rad/s) at normal forces (N), of the best rig and of its joint draws.

    The last axis but one has the critical speed first. A speed is 0 where the rig has none, being stable at every speed
    or without stick-slip; infinite where steady rotation is stable at no speed; and NaN where it cannot be told.
    """

    normal_force: FloatArray  # (n,)
    best: FloatArray  # (2, n)
    draws: FloatArray  # (draws, 2, n)
    wanted: int  # draws that there would be, had nobody stopped it


def borders(
    calibration: Calibration,
    normal_force: npt.ArrayLike,
    draws: int | None = None,
    told: Callable[[int, int], None] | None = None,
    engine: Engine | str | None = None,
) -> Borders:
    """The borders at normal forces (N), shape (n,), over the first `draws` joint draws; by default all.

    `told` hears how many of how many rigs are done. Ctrl-C ends it with the draws that are done, after the best rig.
    `engine` does the draws; by default this process.
    """
    forces = np.atleast_1d(np.asarray(normal_force, dtype=float))
    best = _of(forces, (calibration.rig, calibration.friction))
    rigs = calibration.rigs()[:draws]
    found: dict[int, FloatArray] = {}
    with used(engine) as at:
        try:
            for number, speeds in at.each(partial(_of, forces), rigs):
                found[number] = speeds
                if told is not None:
                    told(len(found), len(rigs))
        except KeyboardInterrupt:
            pass  # those that are done count
    drawn = np.array([found[number] for number in sorted(found)]).reshape(-1, 2, len(forces))
    return Borders(forces, best, drawn, len(rigs))


def loads(calibration: Calibration) -> FloatArray:
    """Normal forces for a map (N), the largest load of the records last; none where they have no load."""
    return calibration.load / LOADS * np.arange(1.0, LOADS + 1.0) if calibration.load > 0.0 else np.zeros(0)


def _of(forces: FloatArray, one: tuple[Rig, Friction]) -> FloatArray:
    """Both speeds of a rig at all forces, shape (2, n)."""
    return np.stack([_critical(*one, forces), _end(*one, forces)])


def _critical(rig: Rig, friction: Friction, forces: FloatArray) -> FloatArray:
    return _each(lambda pressed: np.asarray(critical_speed(rig, pressed)), friction, forces)


def _end(rig: Rig, friction: Friction, forces: FloatArray) -> FloatArray:
    def of(pressed: Friction) -> FloatArray:
        end = end_of_stick_slip(rig, pressed)
        return np.where(np.asarray(end.kind) == "none", 0.0, end.speed)

    return _each(of, friction, forces)


def _each(of: Callable[[Friction], FloatArray], friction: Friction, forces: FloatArray) -> FloatArray:
    """A speed at all forces at once, which is quick, or else at each; NaN where it cannot be told."""
    try:
        return of(replace(friction, normal_force=forces))
    except (ValueError, FloatingPointError):
        return np.array([_one(of, friction, force) for force in forces.tolist()])


def _one(of: Callable[[Friction], FloatArray], friction: Friction, force: float) -> float:
    try:
        return float(of(replace(friction, normal_force=force)))
    except (ValueError, FloatingPointError):
        return nan
