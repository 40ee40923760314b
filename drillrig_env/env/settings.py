"""What all rigs of a batch share, as the kernels take it."""

from __future__ import annotations

from math import exp

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.course import COLUMNS
from drillrig_env.env.reward_terms import address_of
from drillrig_env.env.sensors import TORQUE_DEVIATION_TIME, TORQUE_MEAN_TIME
from drillrig_env.env.task import Task
from drillrig_env.friction.law import number_of
from drillrig_env.stepper.ladder import SAMPLES
from drillrig_env.verdict import STUCK_SPEED

_SETTLING, _LONGEST_SETTLING = 12.0, 60.0  # s on the chapter's rig, until a start in stick-slip is on its cycle

SETTINGS = np.dtype(
    [
        ("law", "i8"),  # of friction, as in CONTACT
        ("control_period", "f8"),  # s
        ("largest_reference", "f8"),  # rad/s
        ("stuck_speed", "f8"),  # below which the bit counts as stuck, rad/s
        ("slew", "f8"),  # largest change of the speed reference in a control step, rad/s
        ("k_p", "f8"),  # of the drive's speed loop in the episode
        ("k_i", "f8"),
        ("gain", "f8"),  # of the running statistics of the bit speed, a sample
        ("torque_mean_gain", "f8"),  # of those of the torque, a control step
        ("torque_variance_gain", "f8"),
        ("variance_weight", "f8"),
        ("tracking_weight", "f8"),
        ("action_weight", "f8"),
        ("deviation", "b1"),  # shape of the variance term
        ("absolute", "b1"),  # shape of the tracking term
        ("phases", "b1"),  # whether the terms are those in phases
        ("tracking_swing", "f8"),  # the swing at which being on target counts half there
        ("own_terms", "i8"),  # how many compiled terms of the user's own there are, and where their code is
        ("address", "i8"),
        ("kept", "f8"),  # what is left of the wandering logarithms after a control step
        ("added", "f8"),  # deviation of what is added to them; 0 where friction does not wander
        ("tilt", "f8"),  # by what share N_1 varies as disc 1 turns
        ("tilt_phase", "f8"),  # rad
        ("steps", "i8"),  # of an episode
        ("window_start", "i8"),  # step with which the last window begins
        ("settling", "i8"),  # fewest and most steps in which a start in stick-slip is brought onto its cycle
        ("longest_settling", "i8"),
    ],
    align=True,
)


def write_settings(settings: np.ndarray, task: Task, steps: int, window_start: int) -> None:
    """Write the settings of a task, whose episodes have so many control steps, into an array with one record."""
    reward, loop = task.reward, task.speed_loop
    period, scales, own = task.control_period, task.scales, task.reward.own
    kept, added = (1.0, 0.0) if task.scenario.wandering is None else task.scenario.wandering.over(period)
    tilt = task.scenario.tilt
    values = {
        "law": number_of(task.scenario.friction.law),
        "control_period": period,
        "largest_reference": task.largest_reference,
        "stuck_speed": STUCK_SPEED * scales.speed,
        "slew": task.slew_limit * period,
        "k_p": loop.k_p,
        "k_i": loop.k_i,
        "gain": 1.0 - exp(-period / SAMPLES / reward.time_constant),
        "torque_mean_gain": 1.0 - exp(-period / (TORQUE_MEAN_TIME * scales.time)),
        "torque_variance_gain": 1.0 - exp(-period / (TORQUE_DEVIATION_TIME * scales.time)),
        "variance_weight": reward.variance,
        "tracking_weight": reward.tracking,
        "action_weight": reward.action,
        "deviation": reward.variance_shape == "absolute",
        "absolute": reward.tracking_shape == "absolute",
        "phases": reward.form == "phases",
        "tracking_swing": reward.tracking_swing,
        "own_terms": len(own.names) if own is not None and own.compiled else 0,
        "address": address_of(own) if own is not None and own.compiled else 0,
        "kept": kept,
        "added": added,
        "tilt": 0.0 if tilt is None else tilt.share,
        "tilt_phase": 0.0 if tilt is None else tilt.phase,
        "steps": steps,
        "window_start": window_start,
        "settling": round(_SETTLING * scales.time / period),
        "longest_settling": round(_LONGEST_SETTLING * scales.calming / period),
    }
    for name, value in values.items():
        settings[name] = value


def course_of(task: Task, steps: int) -> FloatArray:
    """What the scenario's course gives for each control step, as `Course.table` has it; no rows without a course."""
    if task.scenario.course is None:
        return np.empty((0, len(COLUMNS)))
    return task.scenario.course.table(task.control_period * np.arange(steps, dtype=float))
