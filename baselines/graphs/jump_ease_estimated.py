"""Jump and ease on an estimated friction as a graph: the rig's family of slipping orbits as splines within."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicSpline

from baselines.jump_ease import TWIST_RATE_TIME, swing_of_a_ramp
from baselines.jump_ease_estimated import JumpEaseEstimated
from drillrig_env.scales import LARGEST_REFERENCE
from drillrig_env.stability.fold import REACHES
from drillrig_env.stability.slipping_orbits import SlippingOrbits, slipping_orbits
from drillrig_env.stability.stable_sets import critical_fall
from drillrig_env.verdict import STUCK_SPEED

if TYPE_CHECKING:
    from drillrig_env.deploy.graph import Graph, Value


def jump_ease_estimated(law: JumpEaseEstimated, graph: Graph, seen: Mapping[str, Value]) -> Value:
    """Up past the fold while shaking, level until calm, then down at the safe rate to the floor."""
    memory = graph.memory("memory", law.memory)
    square, eased, static, steady, at = (graph.columns(memory, i, i + 1) for i in range(law.memory))
    static, steady, at = _watched(law, graph, seen, static, steady, at)
    _, mu_s, mu_k, v_b = law.nominal_friction.as_array(1)[0].tolist()
    orbits = slipping_orbits(law.plant, REACHES[1])
    decays = (v_b, v_b * (1.0 - law.spread), v_b * (1.0 + law.spread))
    falls = [_fall(law, graph, static, steady, at, decay, mu_k / mu_s) for decay in decays]
    folds = [_fold(law, graph, orbits, fall, decay) for fall, decay in zip(falls, decays, strict=True)]
    likeliest, fold = falls[0], graph.maximum(graph.maximum(folds[0], folds[1]), folds[2])
    past_fold = graph.minimum((1.0 + law.beyond) * fold, LARGEST_REFERENCE)
    target, reference = seen["speed_target"], seen["speed_reference"]
    floor = graph.maximum(target, _critical_speed(law, graph, likeliest, v_b) + law.margin)
    rate = law.of_basin * _basin_depth(graph, orbits, likeliest, v_b, floor) / swing_of_a_ramp(law.plant)
    twisting = seen["bit_speed"] - seen["top_speed"]
    square = square + law.followed(TWIST_RATE_TIME) * (twisting * twisting - square)
    oscillation = graph.make("Sqrt", square) / graph.maximum(reference, 0.1)
    easing = oscillation < graph.where(eased > 0.0, law.shaking, law.calm)
    graph.remember("memory", graph.beside(square, graph.cast(easing, np.float64), static, steady, at))
    down = graph.where(easing, graph.minimum(rate, law.plant_slew) * law.period, 0.0)
    up = graph.maximum(past_fold, reference)
    return graph.maximum(floor, graph.where(oscillation > law.shaking, up, reference - down))


def _watched(
    law: JumpEaseEstimated, graph: Graph, seen: Mapping[str, Value], static: Value, steady: Value, at: Value
) -> tuple[Value, Value, Value]:
    """The largest torque while stuck, and torque and speed of the calmest rotation so far."""
    rig = law.plant
    torque = -rig.k_1 * seen["twist_12"] - rig.d_1 * (seen["bit_speed"] - seen["collar_speed"])
    torque = torque - rig.C_1 * seen["bit_speed"]
    stuck = seen["bit_speed"] < STUCK_SPEED
    winding = rig.k_1 * rig.k_2 / (rig.k_1 + rig.k_2) * law.period * seen["top_speed"]
    torque = torque + graph.where(stuck, 0.5 * winding, 0.0)
    static = graph.where(stuck, graph.maximum(static, torque), static)
    unknown = graph.make("Equal", static, 0.0) & ~stuck
    static = graph.where(unknown, graph.maximum(torque, 0.0), static)
    calm = seen["bit_speed_deviation"] < law.calm * seen["bit_speed_mean"]
    return static, graph.where(calm, torque, steady), graph.where(calm, seen["bit_speed"], at)


def _fall(
    law: JumpEaseEstimated, graph: Graph, static: Value, steady: Value, at: Value, v_b: float, likely: float
) -> Value:
    """The steepest fall of the estimated friction, N_1 r_1 (mu_s - mu_k) v_b in N m s/rad; `likely` is mu_k / mu_s."""
    decayed = graph.make("Exp", -v_b * at)
    seen = (steady - static * decayed) / graph.maximum(1.0 - decayed, 1e-3)
    kinetic = graph.clip(graph.where(at > 0.0, seen, (1.0 - law.spread) * likely * static), 0.0, static)
    ratio = graph.where(static > 0.0, kinetic / graph.maximum(static, 1e-9), likely)
    return v_b * (static * (1.0 - ratio))


def _critical_speed(law: JumpEaseEstimated, graph: Graph, fall: Value, v_b: float) -> Value:
    """omega_c of the friction with a steepest fall, as `critical_speed` has it."""
    bearable = -critical_fall(law.plant, "jump_ease_estimated")
    return graph.make("Log", graph.maximum(fall / bearable, 1.0)) / v_b


def _fold(law: JumpEaseEstimated, graph: Graph, orbits: SlippingOrbits, fall: Value, v_b: float) -> Value:
    """The fold as `fold_speed` has it, 0 where there is none."""
    load = graph.make("Log", fall) - v_b * law.plant.omega_s
    least, largest = float(orbits.loads[0]), orbits.largest_load
    spline = CubicSpline(orbits.loads, orbits.depth[: len(orbits.loads)])
    depth = graph.spline(spline, graph.clip(load, least, largest))
    bistable = _critical_speed(law, graph, fall, v_b) > law.plant.omega_s
    return graph.where(bistable & (load >= least), depth / v_b + law.plant.omega_s, 0.0)


def _basin_depth(graph: Graph, orbits: SlippingOrbits, fall: Value, v_b: float, speed: Value) -> Value:
    """How far below its mean the bit speed may swing at a speed, as `basin_depth` has it."""
    gains, depths = orbits.unstable_side
    log_gain = graph.make("Log", fall) - v_b * speed
    return graph.spline(CubicSpline(gains, depths), graph.clip(-log_gain, gains[0], gains[-1])) / v_b
