"""Drawing episodes from a scenario: uniform numbers become rigs, targets, frictions, starts and loads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np
from scipy.special import ndtri

from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.course import COLUMNS
from drillrig_env.env.scenario import GIVEN, MOST_LOAD_STEPS, REST, STEADY, STICK_SLIP, Scenario
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig

_LEAST_MU_RATIO = 1.05

_SHIFTS = np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0]) % 1.0
"""What a draw's uniform numbers are shifted by, modulo 1, to make the next candidate: again uniform, and far away."""

_BEHIND = 2.0**26
"""Behind so many bits, those of a uniform number make another one, for what few scenarios draw."""

_HALF = 0.5 / _BEHIND

_ONE_RIG = np.ones((1, 3))


@dataclass(frozen=True, eq=False)
class Draws:
    """n drawn episodes: arrays with one entry an episode."""

    rig: np.ndarray  # index into the bank
    speed_target: FloatArray  # rad/s
    friction: Friction  # at the start
    start: np.ndarray  # index into STARTS
    phase: FloatArray  # of the stick-slip cycle at the start, 0 to 1
    load_times: FloatArray  # (n, MOST_LOAD_STEPS), s; infinite where there is none
    load_forces: FloatArray  # (n, MOST_LOAD_STEPS), N
    target_time: FloatArray  # when the target steps, s; infinite where it does not
    next_target: FloatArray  # what it steps to, rad/s
    coefficients: FloatArray  # (n, 3): mu_s, mu_k and v_b, about which friction wanders
    logarithms: FloatArray  # (n, 3): of mu_k, mu_s - mu_k and v_b, by which it has wandered at the start
    turns: np.ndarray  # how often N_1 varies as disc 1 turns once
    angle: FloatArray  # theta_1 at the start, rad
    delay: FloatArray  # where in its range the delay of the measurements lies, 0 to 1
    noise: FloatArray  # seed of the measurement noise, 0 to 1
    state: FloatArray | None = None  # (7,) or (n, 7), in which they begin where it is given
    speed_reference: FloatArray | None = None  # rad/s, () or (n,), with which they then begin; None is the target


def draw_episodes(
    scenario: Scenario,
    uniforms: FloatArray,
    duration: float,
    pins: Mapping[str, Any],
    rig_friction: FloatArray = _ONE_RIG,
) -> Draws:
    """Turn uniform numbers of shape (n, UNIFORMS) into n episodes of `duration` s, pinned as told.

    `pins` are checked options, as from `drillrig_env.env.pins.check_pins`, but that "rig" is an index there.
    `rig_friction`, of shape (rigs, 3), has for each rig of the bank the factors of mu_k, of mu_s - mu_k and of v_b;
    those drawn are its first ones, as many as the fleet has.
    """
    if scenario.candidates > 1:
        one = replace(scenario, candidates=1)
        shifted = [(uniforms + k * _SHIFTS) % 1.0 for k in range(scenario.candidates)]
        slopes = [_slope(draw_episodes(one, each, duration, pins, rig_friction)) for each in shifted]
        hardest = np.where((uniforms[:, -1] * 2.0**20) % 1.0 < 0.5, np.argmin(slopes, axis=0), 0)
        uniforms = np.stack(shifted)[hardest, np.arange(len(uniforms))]
    u = uniforms.T
    n = len(uniforms)
    rig = _one_of(u[10], len(rig_friction))
    if "rig" in pins:
        rig = np.broadcast_to(pins["rig"], n).copy()
    given = _given_at_first(scenario)
    start = np.select(
        [u[5] < scenario.stick_slip, u[5] < scenario.stick_slip + scenario.steady], [STICK_SLIP, STEADY], REST
    )
    if "start" in pins:
        start = np.broadcast_to(pins["start"], n).copy()
    if "state" in pins:
        start = np.full(n, GIVEN)
    drawn = _draw_numbers(scenario, u, {**given, **pins}, _friction_of(scenario, rig, rig_friction))
    target = drawn.pop("speed_target")
    coefficients = np.stack([drawn[name] for name in ("mu_s", "mu_k", "v_b")], axis=1)
    logarithms = np.zeros((n, 3))
    if scenario.wandering is not None:
        inside = np.minimum(_behind(u[2:5]) + _HALF, 1.0 - _HALF)  # of (0, 1), at whose ends there is no such number
        logarithms = scenario.wandering.deviation * ndtri(inside).T
        drawn["mu_k"] = coefficients[:, 1] * np.exp(logarithms[:, 0])
        drawn["mu_s"] = drawn["mu_k"] + (coefficients[:, 0] - coefficients[:, 1]) * np.exp(logarithms[:, 1])
        drawn["v_b"] = coefficients[:, 2] * np.exp(logarithms[:, 2])
    steps = _behind(u[7]) < (0.0 if "speed_target" in given else scenario.target_step)
    turns = (1,) if scenario.tilt is None else scenario.tilt.turns
    return Draws(
        rig,
        target,
        Friction(**drawn, law=scenario.friction.law),
        start,
        u[6],
        *_draw_loads(scenario, u, duration, pins, "normal_force" in given),
        target_time=np.where(steps, _between(scenario.target_time, _behind(u[8])) * duration, np.inf),
        next_target=_between(scenario.speed_target, _behind(u[0]) ** scenario.target_skew),
        coefficients=coefficients,
        logarithms=logarithms,
        turns=np.asarray(turns)[_one_of(u[5], len(turns))],
        angle=np.zeros(n) if scenario.tilt is None else 2.0 * pi * _behind(u[6]),
        delay=u[10],
        noise=u[11],
        state=pins.get("state"),
        speed_reference=pins.get("speed_reference"),
    )


def _draw_numbers(
    scenario: Scenario, u: FloatArray, pins: Mapping[str, Any], friction: tuple[Quantity, Quantity, Quantity]
) -> dict[str, FloatArray]:
    """Target, normal force and coefficients of n episodes from the numbers `u` of shape (UNIFORMS, n)."""
    mu_s, mu_k, v_b = friction
    factors = 1.0 + scenario.spread * (2.0 * u[2:5] - 1.0)
    drawn = {
        "speed_target": _between(scenario.speed_target, u[0] ** scenario.target_skew),
        "normal_force": _between(scenario.normal_force, u[1]),
        "mu_s": mu_s * factors[0],
        "mu_k": mu_k * factors[1],
        "v_b": v_b * factors[2],
    }
    for name in drawn:
        if name in pins:
            drawn[name] = np.broadcast_to(pins[name], u.shape[1]).copy()
    if "mu_s" in pins and "mu_k" not in pins:
        drawn["mu_k"] = np.minimum(drawn["mu_k"], drawn["mu_s"] / _LEAST_MU_RATIO)
    elif "mu_s" not in pins:
        drawn["mu_s"] = np.maximum(drawn["mu_s"], drawn["mu_k"] * _LEAST_MU_RATIO)
    return drawn


def _draw_loads(
    scenario: Scenario, u: FloatArray, duration: float, pins: Mapping[str, Any], given: bool
) -> tuple[FloatArray, FloatArray]:
    """Times (s) and forces (N) of the load steps; none where a course gives the force."""
    times, forces = np.full((u.shape[1], MOST_LOAD_STEPS), np.inf), np.zeros((u.shape[1], MOST_LOAD_STEPS))
    if given:
        return times, forces
    if "load_steps" in pins:
        for i, (time, force) in enumerate(pins["load_steps"]):
            times[:, i], forces[:, i] = time, force
    else:
        times[:, 0] = np.where(u[7] < scenario.load_step, _between(scenario.load_time, u[8]) * duration, np.inf)
        forces[:, 0] = _between(scenario.load_force or scenario.normal_force, u[9])
    return times, forces


def _given_at_first(scenario: Scenario) -> dict[str, float]:
    """What the scenario's course gives at the start, by name."""
    if scenario.course is None:
        return {}
    first = scenario.course.table(np.zeros(1))[0]
    return {name: value for name, value in zip(COLUMNS, first, strict=True) if name in scenario.course.given}


def _friction_of(scenario: Scenario, rig: np.ndarray, rig_friction: FloatArray) -> tuple[Quantity, Quantity, Quantity]:
    """mu_s, mu_k and v_b of the rigs, before the episode's own draws."""
    _, mu_s, mu_k, v_b = scenario.friction.as_array(1)[0]
    if np.all(rig_friction == 1.0):
        return mu_s, mu_k, v_b
    of_mu_k, of_difference, of_v_b = np.vstack([rig_friction, np.ones(3)])[np.minimum(rig, len(rig_friction))].T
    return mu_k * of_mu_k + (mu_s - mu_k) * of_difference, mu_k * of_mu_k, v_b * of_v_b


def _slope(draws: Draws) -> FloatArray:
    """How fast friction falls with speed at the target, N m s/rad but for a factor that all draws share."""
    if draws.friction.law != "exponential":
        return np.asarray(draws.friction.slope(Rig(), draws.speed_target))
    force, mu_s, mu_k, v_b = draws.friction.as_array().T
    return np.asarray(-force * (mu_s - mu_k) * v_b * np.exp(-v_b * draws.speed_target))


def _between(bounds: tuple[float, float], uniform: FloatArray) -> FloatArray:
    return bounds[0] + (bounds[1] - bounds[0]) * uniform


def _behind(uniform: FloatArray) -> FloatArray:
    """Another uniform number, of the later bits of one."""
    return uniform * _BEHIND % 1.0


def _one_of(uniform: FloatArray, count: int) -> np.ndarray:
    """An index below `count`, of the later bits of a uniform number."""
    return np.asarray(np.minimum((_behind(uniform) * count).astype(int), count - 1))
