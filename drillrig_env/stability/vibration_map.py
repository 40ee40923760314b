"""Maps over speed reference and normal force: what a rig does there, and how much load it can take.

The torsional vibration map of figure 4.11a is the curve of critical speeds. Beyond the chapter: the
bistable region between that curve and the fold; a map by direct simulation from both kinds of start,
which knows nothing of either curve; and the step of the normal force that knocks calm rotation into
stick-slip, a margin for the driller.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.engine import Engine, used
from drillrig_env.engine.kept import each_kept
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.model import steady_state, wound_up
from drillrig_env.parameters import POSITIVE, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.scales import Scales
from drillrig_env.stability.end_of_stick_slip import end_of_stick_slip
from drillrig_env.stability.stable_sets import critical_speed
from drillrig_env.stepper.batch import advance_batch
from drillrig_env.verdict import WINDOW, is_calm

CALM, BISTABLE, VIBRATING = 0, 1, 2
"""Regions of the map: only calm rotation is stable, both are, only vibration is."""

# On the chapter's rig:
_NUDGE = 0.01  # rad/s of bit speed, beside steady rotation
_ROUNDING = 1e-8  # rad/s; a swing below this is rounding
_LEAD, _SHORTEST, _PERIOD = 20.0, 40.0, 0.1  # s: before the first window, of a run, from one look to the next
_CHUNK = 4000  # points of a piece, simulated at once


@dataclass(frozen=True, eq=False)
class VibrationMap:
    """Regions over speed references (rad/s, columns) and normal forces (N, rows)."""

    speed_reference: FloatArray
    normal_force: FloatArray
    region: npt.NDArray[np.int64]


def region_map(rig: RigLike, friction: FrictionLike, speeds: FloatArray, forces: FloatArray) -> VibrationMap:
    """The map by the curves: vibrating below the critical speed, bistable up to where stick-slip ends, calm above."""
    rig, friction = Rig.of(rig), Friction.of(friction)
    frictions = replace(friction, normal_force=np.asarray(forces, dtype=float))
    border = np.asarray(critical_speed(rig, frictions))[:, None]
    end = np.nan_to_num(np.asarray(end_of_stick_slip(rig, frictions).speed), nan=0.0)[:, None]
    grid = np.asarray(speeds)[None, :]
    return VibrationMap(speeds, forces, np.where(grid < border, VIBRATING, np.where(grid < end, BISTABLE, CALM)))


def simulated_map(
    rig: Rig,
    friction: Friction,
    speeds: FloatArray,
    forces: FloatArray,
    duration: float | None = None,
    threads: int | None = None,
    engine: Engine | str | None = None,
    folder: Path | None = None,
) -> VibrationMap:
    """The map by direct simulation, each point from steady rotation (nudged) and from a wound-up stuck rig.

    A point vibrates where the nudged start does after `duration` s (None: 120 s on the chapter's rig), and is bistable
    where only the stuck start does. Points within a per cent of a border take longer than that to decide. `engine` does
    the points, 4,000 a piece, such as "ray" of `drillrig_env.engine`; by default this process. Pieces that are done are
    kept in a `folder`, where there is one, from which the same call goes on after a stop, on any engine.
    """
    _check_grid(speeds, forces)
    scales = Scales.of(rig)
    duration = 120.0 * scales.duration if duration is None else duration
    grid = np.meshgrid(speeds, forces)
    speed, force = grid[0].ravel(), grid[1].ravel()
    nudged, stuck = np.empty(speed.shape, dtype=bool), np.empty(speed.shape, dtype=bool)
    parts = [slice(first, first + _CHUNK) for first in range(0, len(speed), _CHUNK)]
    pieces = [(speed[part], force[part]) for part in parts]
    of = repr((rig, friction.as_dict(), duration, np.asarray(speeds).tolist(), np.asarray(forces).tolist()))
    with used(engine) as at:
        work = partial(_of_points, rig, friction, duration, threads)
        for number, found in each_kept(at, work, pieces, folder, of):
            nudged[parts[number]], stuck[parts[number]] = found["nudged"], found["stuck"]
    region = np.where(nudged, VIBRATING, np.where(stuck, BISTABLE, CALM))
    return VibrationMap(speeds, forces, region.reshape(grid[0].shape))


def _of_points(
    rig: Rig, friction: Friction, duration: float, threads: int | None, points: tuple[FloatArray, FloatArray]
) -> dict[str, npt.NDArray[np.bool_]]:
    """Which of some points vibrate, by the start."""
    speed, force = points
    frictions = replace(friction, normal_force=force)
    calm_start = steady_state(rig, frictions, speed) + _NUDGE * Scales.of(rig).speed * np.eye(7)[2]
    return {
        "nudged": vibrates(rig, frictions, speed, calm_start, duration, threads),
        "stuck": vibrates(rig, frictions, speed, wound_up(rig, frictions, speed), duration, threads),
    }


def load_step_margin(
    rig: RigLike,
    friction: FrictionLike,
    speeds: FloatArray,
    forces: FloatArray,
    largest_step: float | None = None,
    duration: float | None = None,
    halvings: int = 8,
    threads: int | None = None,
) -> FloatArray:
    """The smallest step of N_1 (N) that knocks calm rotation into stick-slip; shape (forces, speeds).

    At each operating point the rig rotates steadily, N_1 steps up at once and stays up. The step is
    found by halving to `largest_step` / 2^`halvings`. 0 where the point itself vibrates; infinite where
    even `largest_step` does no harm. On the chapter's rig `largest_step` is 60 N and `duration` 60 s where None.
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    _check_grid(speeds, forces)
    scales = Scales.of(rig)
    duration = 60.0 * scales.duration if duration is None else duration
    largest_step = 60.0 * scales.force if largest_step is None else largest_step
    if not POSITIVE.holds(largest_step):
        raise refuse("load_step_margin", "largest_step", largest_step, "N", POSITIVE)
    grid = np.meshgrid(speeds, forces)
    speed, force = grid[0].ravel(), grid[1].ravel()
    before = replace(friction, normal_force=force)
    start = steady_state(rig, before, speed)

    def knocked_out(step: FloatArray) -> npt.NDArray[np.bool_]:
        after = replace(friction, normal_force=force + step)
        return vibrates(rig, after, speed, start, duration, threads)

    low, high = np.zeros(speed.shape), np.full(speed.shape, largest_step)
    harmless = ~knocked_out(high)
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        out = knocked_out(middle)
        low, high = np.where(out, low, middle), np.where(out, middle, high)
    unstable = speed < np.asarray(critical_speed(rig, before))
    margin = np.where(unstable, 0.0, np.where(harmless, np.inf, high))
    return np.asarray(margin.reshape(grid[0].shape))


def vibrates(
    rig: Rig,
    friction: Friction,
    speed_reference: FloatArray,
    states: FloatArray,
    duration: float,
    threads: int | None = None,
) -> npt.NDArray[np.bool_]:
    """Whether rigs are not calm over the last 10 s of `duration` s (> 40 s) from `states`, or shake ever more.

    The latter, a swing that has grown since the window from 20 to 30 s, is how a slow departure from an
    unstable steady rotation shows. These times are the chapter rig's, and grow with the rig's scale. Shape (n,).
    """
    scales = Scales.of(rig)
    if not duration > _SHORTEST * scales.time:
        raise refuse("vibration map", "duration", duration, "s", f"> {_SHORTEST * scales.time:g}")
    lead, window, period = round(_LEAD / _PERIOD), round(WINDOW / _PERIOD), _PERIOD * scales.time

    def advance(start: FloatArray, periods: int, every: int) -> FloatArray:
        return advance_batch(
            rig, friction, start, speed_reference, period=period, periods=periods, every=every, threads=threads
        )

    first = advance(advance(states, lead, lead)[:, -1], window, 1)
    rest = round(duration / period) - lead - 2 * window
    speed = advance(advance(first[:, -1], rest, rest)[:, -1], window, 1)[:, :, 2]
    growing = np.ptp(speed, axis=1) > np.maximum(np.ptp(first[:, :, 2], axis=1), _ROUNDING * scales.speed)
    calm = np.asarray(is_calm(speed.min(axis=1), speed.max(axis=1), speed.mean(axis=1), scales.speed))
    return np.asarray(~calm | growing)


def _check_grid(speeds: FloatArray, forces: FloatArray) -> None:
    for name, values, unit in (("speeds", speeds, "rad/s"), ("forces", forces, "N")):
        if np.ndim(values) != 1 or not POSITIVE.holds(values):
            raise refuse("vibration map", name, values, unit, f"an array, each {POSITIVE}")
