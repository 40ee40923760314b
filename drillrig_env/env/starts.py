"""How episodes begin: in developed stick-slip where there is any, in steady rotation, or at rest."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.env.kernel import EPISODE, scratch, settle_episodes
from drillrig_env.env.scenario import REST, STEADY, STICK_SLIP, Draws
from drillrig_env.env.task import Task
from drillrig_env.friction import Friction
from drillrig_env.jit.threads import over_slices
from drillrig_env.model import frictionless_state, steady_state, torque_into_string, wound_up
from drillrig_env.stepper.tables import Tables


def begin_episodes(task: Task, draws: Draws, settings: np.ndarray, tables: Tables, threads: int) -> np.ndarray:
    """The records of n new episodes at their first moment, from what they drew.

    `settings` are those of the batch, `tables` those of the rig with its own drive: the start is made with that one,
    and handed over to the drive of the task.
    """
    rig, friction, target = task.rig, draws.friction, draws.speed_target
    contact = friction.as_array(len(target))
    fresh = np.zeros(len(target), dtype=EPISODE)
    for column, name in enumerate(("normal_force", "mu_s", "mu_k", "v_b")):
        fresh[name] = contact[:, column]
    fresh["speed_target"] = fresh["speed_reference"] = fresh["mean"] = target
    fresh["load_times"], fresh["load_forces"] = draws.load_times, draws.load_forces
    fresh["start"] = draws.start
    low, high = task.delays
    fresh["delay"] = low + np.minimum((draws.delay * (high - low + 1)).astype(int), high - low)
    fresh["noise"] = (draws.noise * 2.0**53).astype(np.uint64)
    fresh["state"][:, :7] = steady_state(rig, friction, target)
    rest = draws.start == REST
    fresh["state"][rest, :7] = frictionless_state(rig, 0.0)
    fresh["speed_reference"][rest] = fresh["mean"][rest] = 0.0
    fresh["string_torque"] = fresh["torque_mean"] = torque_into_string(rig, fresh["state"][:, :7])
    _settle(task, fresh, np.flatnonzero(draws.start == STICK_SLIP), draws.phase, settings, tables, threads)
    _hand_over(task, fresh)
    fresh["torque_into_string"] = torque_into_string(rig, fresh["state"][:, :7])
    return fresh


def _settle(
    task: Task,
    fresh: np.ndarray,
    indices: npt.NDArray[np.intp],
    phase: FloatArray,
    settings: np.ndarray,
    tables: Tables,
    threads: int,
) -> None:
    """Put the rigs at `indices`, now in steady rotation, onto their stick-slip cycle where they have one."""
    if len(indices) == 0:
        return
    cycling = fresh[indices]
    friction = Friction(*(cycling[name] for name in ("normal_force", "mu_s", "mu_k", "v_b")))
    cycling["state"][:, :7] = wound_up(task.rig, friction, cycling["speed_target"])
    phases = phase[indices]

    def settle(part: slice) -> None:
        settle_episodes(cycling[part], phases[part], settings, tables.rungs, tables.sampling, tables.shift, scratch())

    over_slices(settle, len(indices), threads, int(settings["settling"][0]))
    found = cycling["start"] == STICK_SLIP
    fresh[indices[found]] = cycling[found]
    fresh["start"][indices[~found]] = STEADY


def _hand_over(task: Task, fresh: np.ndarray) -> None:
    """Give the rigs to the drive of the task, without a jump of the voltage."""
    state, rig, drive = fresh["state"], task.rig, task.drive
    error = fresh["speed_reference"] - state[:, 4]
    fresh["voltage"] = rig.k_p * error + rig.k_i * state[:, 6]
    if drive is not None:
        added = drive.compensation(rig) * state[:, 4]
        state[:, 6] = (fresh["voltage"] - added - drive.k_p * error) / drive.k_i
