"""Z-torque as a graph, and the torque's deviation and oscillation that it stands on."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, pi, sin
from typing import TYPE_CHECKING

from baselines.string_torque import MEMORY
from baselines.z_torque import LIFT_TIME, ZTorque

if TYPE_CHECKING:
    from drillrig_env.deploy.graph import Graph, Value


def z_torque(law: ZTorque, graph: Graph, seen: Mapping[str, Value]) -> Value:
    """The target, less what the torque asks the top to give way, plus the lift."""
    memory = graph.memory("memory", law.memory)
    held = [graph.columns(memory, i, i + 1) for i in range(law.memory)]
    deviation, kept = _deviation(law, graph, seen, held[:MEMORY])
    step = 2.0 * pi * law.plant.string_frequencies[0] * law.period
    real, imaginary = held[MEMORY], held[MEMORY + 1]
    expected = cos(step) * real - sin(step) * imaginary
    real, imaginary = (
        expected + law.each_step(law.follow) * (deviation - expected),
        sin(step) * real + cos(step) * imaginary,
    )
    square = held[MEMORY + 2]
    square = square + law.period / LIFT_TIME * (real * real + imaginary * imaginary - square)
    graph.remember("memory", graph.beside(*kept, real, imaginary, square))
    turn = 2.0 * pi * law.plant.string_frequencies[0] * law.lead
    ahead = real * cos(turn) - imaginary * sin(turn)
    calm = law.calm * law.plant.impedance * seen["speed_target"]
    excess = graph.maximum(graph.make("Sqrt", square) - calm, 0.0)
    return seen["speed_target"] - law.gain * ahead + law.lift * excess


def _deviation(
    law: ZTorque, graph: Graph, seen: Mapping[str, Value], held: list[Value]
) -> tuple[Value, tuple[Value, Value, Value]]:
    """The deviation of the torque from its slow mean, N m, and what is kept; as `torque_deviation` has it."""
    rig, (samples, deviation, last) = law.plant, held
    damping: Value | None = None
    if "twist_23" in seen and "collar_speed" in seen:
        now = -(rig.k_2 * seen["twist_23"] + rig.d_2 * (seen["collar_speed"] - seen["top_speed"]))
        change = now - last
    elif "string_torque" in seen:
        now = seen["string_torque"]
        change = now - last
    else:
        now = seen["collar_speed"] - seen["top_speed"]
        change = -rig.k_2 * 0.5 * law.period * (now + last)
        damping = -rig.d_2 * now
    gain = graph.maximum(1.0 / (samples + 1.0), law.period / law.time_constant)
    deviation = (1.0 - gain) * (deviation + change)
    return (deviation if damping is None else deviation + damping), (samples + 1.0, deviation, now)
