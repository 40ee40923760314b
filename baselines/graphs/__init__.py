"""Laws as ONNX graphs, for hardware: the same law as in the file of that name, operator by operator.

A test plays episodes through both. `LAWS` says which there are.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from baselines.graphs.constant import constant
from baselines.graphs.jump_ease_estimated import jump_ease_estimated
from baselines.graphs.lqg import lqg
from baselines.graphs.z_torque import z_torque
from drillrig_env.parameters import refuse

if TYPE_CHECKING:
    from baselines.baseline import Baseline
    from drillrig_env.deploy.graph import Graph, Value

Law = Callable[[Any, "Graph", Mapping[str, "Value"]], "Value"]

LAWS: Mapping[str, Law] = {
    "Constant": constant,
    "JumpEaseEstimated": jump_ease_estimated,
    "LQG": lqg,
    "ZTorque": z_torque,
}
"""By the name of a class: what draws its wanted speed reference, from what is seen, both counted as the law counts."""


def draw(law: Baseline, graph: Graph, observation: Value) -> Value:
    """The action (batch, 1) of a law for observations (batch, channels). `ValueError` for a law that has no graph."""
    from drillrig_env.deploy.build import physical

    name = type(law).__name__
    if name not in LAWS:
        raise refuse(name, "a file of", law.known_as or name, "", ", ".join(LAWS))
    unit: Callable[[str], float] = getattr(law, "unit", lambda name: 1.0)
    shown = physical(graph, law.sensors.channels, observation)
    units = {channel: unit(channel) for channel in shown}
    seen = {channel: value if units[channel] == 1.0 else value / units[channel] for channel, value in shown.items()}
    desired = LAWS[name](law, graph, seen)
    if unit("bit_speed") != 1.0:
        desired = desired * unit("bit_speed")
    rate = (desired - shown["speed_reference"]) / (law.slew_limit * law.task.control_period)
    return graph.cast(graph.clip(rate, -1.0, 1.0), np.float32)
