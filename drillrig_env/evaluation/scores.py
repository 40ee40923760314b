"""The scores of an episode, each from the true bit speed at 160 Hz.

>>> from drillrig_env.evaluation.runner import run
>>> from drillrig_env.evaluation.scores import score, time_to_calm
>>> from drillrig_env.evaluation.suites import suite
>>> from drillrig_env.policy import load
>>> episodes = run(load("lqg"), suite("default", rigs=5))
>>> scores = score(episodes)
>>> scores["mitigated"].tolist()
[True, True, True, True, True]
>>> [round(float(seconds), 1) for seconds in time_to_calm(episodes)]
[5.0, 16.2, 7.6, 5.0, 5.0]
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.evaluation.runner import Episodes
from drillrig_env.friction import Friction
from drillrig_env.model import steady_state, torque_into_string
from drillrig_env.rig import Rig
from drillrig_env.stability import critical_slope, critical_speed, end_of_stick_slip
from drillrig_env.verdict import WINDOW, is_calm, is_mitigated, stick_slip_index

TRAILING = 5.0
"""Window of the trailing stick-slip index that "time to calm" looks at, s on the chapter's rig."""

SCORES = {
    "ssi": ("", "stick-slip index over the last 10 s"),
    "calm": ("", "calm over the last 10 s"),
    "mitigated": ("", "calm, with the mean bit speed within 5 % of the target"),
    "time_to_calm": ("s", "from when on the index over the trailing 5 s stays calm, below 0.1"),
    "stuck": ("", "share of the time with a bit speed below 0.01 rad/s"),
    "peak_speed": ("", "highest bit speed over the target"),
    "peak_torque": ("", "highest string torque over its steady value"),
    "cost": ("", "mean reward, negative"),
    "travel": ("rad/s", "integral of |d omega_ref|"),
}
"""Unit and meaning of every score; times and speeds are those of the chapter's rig."""

REGIONS = ("below", "bistable", "above")
"""Where a target lies: below the critical speed, between it and the fold, above the fold."""

HARDNESS_EDGES = (0.0, 1.0, 2.0, 3.0, 4.0, 6.0, np.inf)
"""Edges of the bins of the hardness q in which results are reported; q < 1 is above the critical speed.

Each bin holds its lower edge and not its upper one: together they hold every rig once.
"""


def describe(rig: Rig, friction: Friction, target: FloatArray) -> dict[str, npt.NDArray[np.generic]]:
    """What tells rigs apart: target and friction, the borders that follow from them, and which side of these they lie.

    `rig` is shared by all; `friction` has an entry an episode, or one.

    `region` splits at the critical speed omega_c and at the fold (see `REGIONS` and `folds`); `hardness`
    is q, the negative friction slope at the target over the slope that the drive can bear. `target`
    (rad/s) and all entries have shape (n,).

    >>> import numpy as np
    >>> from drillrig_env import Friction, Rig
    >>> rig, friction = Rig(), Friction(normal_force=np.array([20.0, 20.0, 20.0]))
    >>> describe(rig, friction, np.array([2.0, 3.0, 6.0]))["region"].tolist()
    ['below', 'bistable', 'above']
    """
    return _described(rig, friction, target, critical_speed(rig, friction), folds(rig, friction))


def _described(
    rig: Rig, friction: Friction, target: FloatArray, critical: Quantity, fold: Quantity
) -> dict[str, npt.NDArray[np.generic]]:
    omega_c, fold = np.broadcast_to(critical, target.shape), np.broadcast_to(fold, target.shape)
    return {
        "speed_target": target,
        "normal_force": np.asarray(friction.normal_force),
        "mu_s": np.asarray(friction.mu_s),
        "mu_k": np.asarray(friction.mu_k),
        "v_b": np.asarray(friction.v_b),
        "critical_speed": omega_c,
        "fold": fold,
        "region": np.select([target < omega_c, target < fold], ["below", "bistable"], "above"),
        "hardness": -np.asarray(friction.slope(rig, target)) / -critical_slope(rig),
    }


def describe_fleet(
    rigs: Sequence[Rig], place: npt.NDArray[np.intp], friction: Friction, target: FloatArray
) -> dict[str, npt.NDArray[np.generic]]:
    """`describe` for episodes each of which has one of `rigs`, at `place`; and the steady torque into the string, N m.

    `friction` and `target` (rad/s) have an entry an episode.

    Of a fleet of several rigs the fold is left out (NaN), since a rig takes a third of a second to be followed to it:
    `region` then tells only whether the target is below the critical speed or above. Where steady rotation has no one
    critical speed, that is infinite.

    >>> import numpy as np
    >>> from drillrig_env import Friction, Rig
    >>> rigs, place = [Rig(), Rig(J_1=0.0576)], np.array([0, 1])
    >>> found = describe_fleet(rigs, place, Friction(np.array([20.0, 20.0])), np.array([2.0, 3.0]))
    >>> [round(float(torque), 3) for torque in found["steady_torque"]]
    [0.322, 0.306]
    """
    table = friction.as_array(len(target))
    parts: list[tuple[npt.NDArray[np.intp], dict[str, npt.NDArray[np.generic]]]] = []
    for k in np.unique(place):
        chosen = np.flatnonzero(place == k)
        rig, own, at = rigs[k], Friction(*table[chosen].T, law=friction.law), target[chosen]
        described = describe(rig, own, at) if len(rigs) == 1 else _describe_without_fold(rig, own, at)
        torque = torque_into_string(rig, steady_state(rig, own, at))
        parts.append((chosen, {**described, "steady_torque": torque}))
    order = np.argsort(np.concatenate([chosen for chosen, _ in parts]), kind="stable")
    return {name: np.concatenate([part[name] for _, part in parts])[order] for name in parts[0][1]}


def _describe_without_fold(rig: Rig, friction: Friction, target: FloatArray) -> dict[str, npt.NDArray[np.generic]]:
    try:
        critical = critical_speed(rig, friction)
    except ValueError:
        critical = np.inf
    return _described(rig, friction, target, critical, np.nan)


def score(episodes: Episodes) -> dict[str, npt.NDArray[np.generic]]:
    """Every score of SCORES, an entry an episode, after what describes the episode's rig at its end.

    `episodes` are those of one policy in one suite.
    """
    target = episodes.speed_target
    scales, period = episodes.task.scales, episodes.task.control_period
    window = round(WINDOW * scales.time / period)
    lowest = episodes.lowest[:, -window:].min(axis=1)
    highest = episodes.highest[:, -window:].max(axis=1)
    mean, index = episodes.average[:, -window:].mean(axis=1), episodes.calm_index
    described = describe_fleet(episodes.rigs, episodes.place, episodes.friction, target)
    return {
        **{name: described[name] for name in ("speed_target", "normal_force", "mu_s", "mu_k", "v_b")},
        "start": episodes.start,
        **{name: described[name] for name in ("critical_speed", "fold", "region", "hardness")},
        "ssi": stick_slip_index(lowest, highest, mean),
        "calm": is_calm(lowest, highest, mean, scales.speed, index),
        "mitigated": is_mitigated(lowest, highest, mean, target, scales.speed, index),
        "time_to_calm": time_to_calm(episodes),
        "stuck": episodes.stuck.mean(axis=1),
        "peak_speed": episodes.highest.max(axis=1) / target,
        "peak_torque": episodes.highest_torque.max(axis=1) / described["steady_torque"],
        "cost": -episodes.reward.mean(axis=1),
        "travel": np.abs(np.diff(episodes.speed_reference, axis=1)).sum(axis=1),
        "rig": episodes.place,
    }


def folds(rig: Rig, friction: Friction) -> FloatArray:
    """Speed (rad/s) at which stick-slip ends, one entry a rig.

    NaN where friction is so weak that there is no stick-slip: calm rotation is all there is. Infinite
    where friction is too strong for stick-slip that could be followed, far beyond what the drive reaches, and where the
    rig is one of which no orbit is found.

    >>> import numpy as np
    >>> from drillrig_env import Friction, Rig
    >>> [round(float(speed), 2) for speed in folds(Rig(), Friction(normal_force=np.array([10.0, 20.0])))]
    [2.9, 4.79]
    """
    try:
        return np.atleast_1d(end_of_stick_slip(rig, friction).speed)
    except (ValueError, FloatingPointError):
        return np.array([_fold(rig, one) for one in friction.each()])


def _fold(rig: Rig, friction: Friction) -> float:
    try:
        return float(end_of_stick_slip(rig, friction).speed)
    except (ValueError, FloatingPointError):
        return np.inf


def time_to_calm(episodes: Episodes) -> FloatArray:
    """First time (s) after which the trailing stick-slip index stays calm; the whole episode if never.

    `episodes` are those of one policy in one suite; shape (n,).
    """
    period = episodes.task.control_period
    width = round(TRAILING * episodes.task.scales.time / period)
    steps = episodes.lowest.shape[1]
    windows = np.lib.stride_tricks.sliding_window_view
    index = stick_slip_index(
        windows(episodes.lowest, width, axis=1).min(axis=2),
        windows(episodes.highest, width, axis=1).max(axis=2),
        windows(episodes.average, width, axis=1).mean(axis=2),
    )
    shaking = index >= episodes.calm_index
    last = np.where(shaking.any(axis=1), shaking.shape[1] - np.argmax(shaking[:, ::-1], axis=1), 0)
    first_calm_step = np.where(last == shaking.shape[1], steps, last + width)
    return np.asarray(first_calm_step * period)
