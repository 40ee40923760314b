"""LQG as a graph: one table a gain, of which the scheduled entry is looked up in each control step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from baselines.linear_rig import LEVEL, SIZE, without_friction
from baselines.lqg import (
    FIRST_LEVEL,
    HIGHEST_SET_POINT,
    LQG,
    OFFSET,
    PAST,
    SHAKING,
    SLOPES,
    STEP,
    TWIST_RATE_TIME,
    WAIT,
)
from drillrig_env.parameters import refuse

if TYPE_CHECKING:
    from drillrig_env.deploy.graph import Graph, Value


def lqg(law: LQG, graph: Graph, seen: Mapping[str, Value]) -> Value:
    """The reference so far and the change that the feedback asks for. `ValueError` for another law of friction."""
    if len(law.plants) > 1:
        raise refuse("LQG", "rigs that it is made for", len(law.plants), "", "one, in a file")
    memory = graph.memory("memory", PAST + law.delay + 1)
    offset, steps, shaking = (graph.columns(memory, i, i + 1) for i in (OFFSET, STEP, SHAKING))
    set_point = seen["speed_target"] + offset
    reference = seen["speed_reference"] - set_point
    gains = _scheduled(law, graph, graph.columns(memory, LEVEL, LEVEL + 1), set_point)
    past = _past(law, graph, memory, steps, reference)
    kept, z = _estimate(law, graph, seen, memory, set_point, gains, past)
    steps = steps + 1.0
    is_shaking = graph.make("Sqrt", shaking) / set_point > law.shaking
    twisting = graph.columns(z, 2, 3) - graph.columns(z, 4, 5)
    shaking = shaking + law.followed(TWIST_RATE_TIME) * (twisting * twisting - shaking)
    wanted = graph.where(is_shaking, law.rise, -law.ease) * law.period
    highest = graph.maximum(HIGHEST_SET_POINT - set_point, 0.0)
    move = graph.where(steps * law.period < WAIT, 0.0, graph.clip(wanted, -offset, highest))
    by_move = np.zeros((1, SIZE))
    by_move[0, :7] = law.per_speed[0]
    lowered = move * graph.entry(_with_slopes(by_move), gains)  # by what the state about the set point changes with it
    graph.remember("memory", graph.beside(kept - lowered, steps, offset + move, shaking, past - move))
    z = z - lowered
    deviation = graph.beside(z - graph.columns(z, LEVEL, LEVEL + 1) * law.per_level, reference - move)
    change = graph.total(graph.entry(law.feedback, gains) * deviation)
    return seen["speed_reference"] + move - change


def _with_slopes(row: np.ndarray) -> np.ndarray:
    """A row for each of SLOPES, with that slope as its friction level."""
    table = np.repeat(row, len(SLOPES), axis=0)
    table[:, LEVEL] = SLOPES
    return table


def _scheduled(law: LQG, graph: Graph, level: Value, speed: Value) -> Value:
    """Which of SLOPES is nearest to `share` times that of the law with the torque `level` at `speed`."""
    rig, friction = law.plant, law.nominal_friction
    law.check_chapters_law()
    _, mu_s, mu_k, v_b = friction.as_array(1)[0].tolist()
    decayed = graph.make("Exp", -v_b * speed)
    inside = speed < rig.omega_s
    torque = graph.where(inside, rig.r_1 * mu_s / rig.omega_s * speed, rig.r_1 * (mu_k + (mu_s - mu_k) * decayed))
    slope = graph.where(inside, rig.r_1 * mu_s / rig.omega_s, -rig.r_1 * (mu_s - mu_k) * v_b * decayed)
    slope = -law.share * (graph.maximum(level, 0.0) / torque) * slope
    ratio = float(np.log(SLOPES[1] / SLOPES[0]))
    nearest = graph.make("Round", graph.make("Log", graph.maximum(slope, SLOPES[0]) / SLOPES[0]) / ratio)
    return graph.cast(graph.minimum(nearest, len(SLOPES) - 1.0), np.int64)


def _past(law: LQG, graph: Graph, memory: Value, steps: Value, reference: Value) -> Value:
    """The references about the set point that still count, the oldest first; (batch, delay + 1)."""
    later = graph.columns(memory, PAST + 1, PAST + law.delay + 1)
    moved = graph.beside(later, reference) if law.delay else reference
    return graph.where(steps < 0.5, reference, moved)


def _estimate(
    law: LQG, graph: Graph, seen: Mapping[str, Value], memory: Value, set_point: Value, gains: Value, past: Value
) -> tuple[Value, Value]:
    """The state when what is shown was measured, and now; (batch, SIZE) each."""
    steps = graph.columns(memory, STEP, STEP + 1)
    held = graph.columns(memory, 0, SIZE)
    transition, by_reference = graph.entry(law.transition, gains), graph.entry(law.by_reference, gains)
    oldest = graph.columns(past, 0, 1)
    rig, shown = law.plant, []
    for name in law.measured:
        at_one, at_two = (without_friction(rig, rig, name, np.array([speed]))[0] for speed in (1.0, 2.0))
        shown.append(seen[name] - ((at_two - at_one) * set_point + (2.0 * at_one - at_two)))
    begins = steps < 0.5
    expected = graph.where(
        begins,
        FIRST_LEVEL * law.per_level,
        graph.applied(transition, held) + by_reference * oldest,
    )
    through = oldest * law.through
    news = graph.beside(*shown) - graph.applied(graph.constant(law.rows[0]), expected) - through
    first = graph.applied(graph.constant(law.first_gain[0]), news)
    z = expected + graph.where(begins, first, graph.applied(graph.entry(law.filter_gains, gains), news))
    waits = ~begins & (steps <= float(law.delay))
    kept = z = graph.where(waits, held, z)
    for age in range(law.delay, 0, -1):
        known = graph.columns(past, law.delay + 1 - age, law.delay + 2 - age)
        z = graph.where(steps >= float(age), graph.applied(transition, z) + by_reference * known, z)
    return kept, z
