"""How episodes begin: in developed stick-slip where there is any, in steady rotation, at rest, or in a given state."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.env.bank import RigBank
from drillrig_env.env.draws import Draws
from drillrig_env.env.episode import EPISODE
from drillrig_env.env.kernel import scratch, settle_episodes
from drillrig_env.env.scenario import REST, STEADY, STICK_SLIP
from drillrig_env.env.task import Task
from drillrig_env.friction import Friction
from drillrig_env.jit.threads import over_slices
from drillrig_env.model import frictionless_state, steady_state, torque_into_string, wound_up

_OTHER_STREAM = np.uint64(0x5851F42D4C957F2D)
"""What the seed of the noise is changed by, so that friction wanders apart from it."""


def begin_episodes(task: Task, draws: Draws, settings: np.ndarray, bank: RigBank, threads: int) -> np.ndarray:
    """The records of n new episodes at their first moment, from what they drew.

    `settings` are those of the batch. The start is made with the nominal rig's own drive, and handed over to the drive
    of the task; a given state is the episode's first, under the drive of the task. But for a start in stick-slip, all
    running statistics are those of a rig that has always turned as it does now.
    """
    rig, friction, target = bank.parameters(draws.rig), draws.friction, draws.speed_target
    contact = friction.as_array(len(target))
    fresh = np.zeros(len(target), dtype=EPISODE)
    for column, name in enumerate(("normal_force", "mu_s", "mu_k", "v_b")):
        fresh[name] = contact[:, column]
    fresh["speed_target"] = fresh["speed_reference"] = fresh["mean"] = target
    fresh["load_times"], fresh["load_forces"] = draws.load_times, draws.load_forces
    fresh["start"], fresh["rig"] = draws.start, draws.rig
    low, high = task.delays
    fresh["delay"] = low + np.minimum((draws.delay * (high - low + 1)).astype(int), high - low)
    fresh["noise"] = (draws.noise * 2.0**53).astype(np.uint64)
    fresh["wandering"] = fresh["noise"] ^ _OTHER_STREAM
    fresh["target_time"], fresh["next_target"] = draws.target_time, draws.next_target
    fresh["coefficients"], fresh["logarithms"] = draws.coefficients, draws.logarithms
    fresh["turns"], fresh["state"][:, 7] = draws.turns, draws.angle
    fresh["state"][:, :7] = steady_state(rig, friction, target)
    rest = draws.start == REST
    fresh["state"][rest, :7] = frictionless_state(bank.parameters(draws.rig[rest]), np.zeros(rest.sum()))
    fresh["speed_reference"][rest] = fresh["mean"][rest] = 0.0
    if draws.state is not None:
        fresh["state"][:, :7] = draws.state
        fresh["mean"] = fresh["state"][:, 2]
        if draws.speed_reference is not None:
            fresh["speed_reference"] = draws.speed_reference
    fresh["string_torque"] = fresh["torque_mean"] = _estimate(bank, fresh)
    _settle(fresh, np.flatnonzero(draws.start == STICK_SLIP), draws, settings, bank, threads)
    if draws.state is None:
        _hand_over(task, bank, fresh)
    else:
        fresh["voltage"] = _voltage(task, bank, fresh)
    fresh["torque_into_string"] = torque_into_string(rig, fresh["state"][:, :7])
    return fresh


def _estimate(bank: RigBank, episodes: np.ndarray) -> FloatArray:
    """What the drive takes for the torque into the string (N m) where the rigs turn steadily or stand; shape (n,)."""
    state, plants = episodes["state"][:, :7], bank.plants[episodes["rig"]]
    torque = torque_into_string(bank.parameters(episodes["rig"]), state)
    return np.asarray(
        plants["torque_gain"] * torque + plants["torque_per_speed"] * state[:, 4] + plants["torque_offset"]
    )


def _settle(
    fresh: np.ndarray,
    indices: npt.NDArray[np.intp],
    draws: Draws,
    settings: np.ndarray,
    bank: RigBank,
    threads: int,
) -> None:
    """Put the rigs at `indices`, now in steady rotation, onto their stick-slip cycle where they have one."""
    if len(indices) == 0:
        return
    cycling = fresh[indices]
    columns = (cycling[name] for name in ("normal_force", "mu_s", "mu_k", "v_b"))
    friction = Friction(*columns, law=draws.friction.law)
    cycling["state"][:, :7] = wound_up(bank.parameters(cycling["rig"]), friction, cycling["speed_target"])
    phases, tables = draws.phase[indices], bank.start_tables

    def settle(part: slice) -> None:
        settle_episodes(
            cycling[part],
            phases[part],
            settings,
            bank.plants,
            tables.ladders,
            scratch(),
        )

    over_slices(settle, len(indices), threads, int(settings["settling"][0]))
    found = cycling["start"] == STICK_SLIP
    fresh[indices[found]] = cycling[found]
    fresh["start"][indices[~found]] = STEADY


def _hand_over(task: Task, bank: RigBank, fresh: np.ndarray) -> None:
    """Give the rigs to the drive of the task, without a jump of the voltage unless its limit asks for one."""
    state, nominal, drive = fresh["state"], task.rig, task.drive
    error = fresh["speed_reference"] - state[:, 4]
    fresh["voltage"] = nominal.k_p * error + nominal.k_i * state[:, 6]
    if drive is not None:
        plants = bank.plants[fresh["rig"]]
        added = plants["back_emf_compensation"] * state[:, 4] + plants["voltage_offset"]
        state[:, 6] = (fresh["voltage"] - added - drive.k_p * error) / drive.k_i
        if drive.current_limit is not None:
            fresh["voltage"] = _voltage(task, bank, fresh)


def _voltage(task: Task, bank: RigBank, episodes: np.ndarray) -> FloatArray:
    """What the drive of the task makes of the rigs' states, V; shape (n,)."""
    state, loop, plants = episodes["state"], task.speed_loop, bank.plants[episodes["rig"]]
    added = plants["back_emf_compensation"] * state[:, 4]
    error = episodes["speed_reference"] - state[:, 4]
    back_emf, room = plants["back_emf"] * state[:, 4], plants["voltage_room"]
    asked = loop.k_p * error + loop.k_i * state[:, 6] + added
    return np.asarray(np.clip(asked, back_emf - room, back_emf + room) + plants["voltage_offset"])
