"""A policy as one ONNX file: network or law, memory, scaling, slew and limits, and beside it all that a user must know.

Every channel is an input of its own, (batch, 1) in its physical unit, so that nobody has to know the order of an
observation. Offset, scale and clipping are in the graph, in single precision at the end as in the environment. The
outputs are `speed_reference_rate` (rad/s^2) and `next_speed_reference` (rad/s), within the slew limit and the ends of
the range; a memory goes in by its name, and comes out with `next_` in front.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
import onnx
from onnx import helper

from drillrig_env.deploy.about import NO_DIGEST, as_properties, digest_of, with_digest
from drillrig_env.deploy.graph import NEXT, Graph, Value
from drillrig_env.drive import Drive
from drillrig_env.env.sensors import LIMIT, TORQUE_DEVIATION_TIME, TORQUE_MEAN_TIME, Channel
from drillrig_env.env.task import Task
from drillrig_env.files import write_bytes
from drillrig_env.parameters import refuse
from drillrig_env.policy import privileged_of
from drillrig_env.stepper.ladder import SAMPLES

RATE, REFERENCE = "speed_reference_rate", f"{NEXT}speed_reference"
"""The outputs."""

_OWN = ("speed_reference", "speed_target")

FORMAT = 1
"""Of the metadata; readers refuse a later one."""


@runtime_checkable
class Exportable(Protocol):
    """A policy that can be a file: beside what every policy is, what it acts in, and how it is drawn."""

    @property
    def task(self) -> Task:
        """What it acts in: rig, sensors, slew limit, control period, largest reference."""

    def draw(self, graph: Graph, observation: Value) -> Value:
        """The action (batch, 1) of observations (batch, channels), as operators. `ValueError` where it has none."""

    def training(self) -> Mapping[str, Any]:
        """Where it comes from: kind, algorithm or law, seed, versions or gains; plain values."""


def export_policy(policy: Any, path: str | Path, name: str = "") -> None:
    """Write a policy as an ONNX file. `ValueError` for one that cannot be a file, with what can."""
    write_bytes(path, with_digest(build(policy, name).SerializeToString(deterministic=True)))


def build(policy: Any, name: str = "") -> onnx.ModelProto:
    """The model of a policy, with `NO_DIGEST` in the place of its digest; `name` is what it calls itself."""
    name = name or getattr(policy, "known_as", "") or type(policy).__name__
    if not isinstance(policy, Exportable):
        raise refuse(name, "policy", type(policy).__name__, "", "a trained agent or a law that can be drawn as a graph")
    if told := privileged_of(policy):
        raise refuse(name, "what it is told", ", ".join(told), "", "nothing: no rig tells that")
    task, graph = policy.task, Graph()
    channels = task.sensors.channels
    for channel in (*(channel.name for channel in channels), *_OWN):
        graph.input(channel)
    action = graph.cast(graph.cast(policy.draw(graph, scaled(graph, channels)), np.float32), np.float64)
    action = graph.clip(action, -1.0, 1.0)
    graph.output(RATE, action * task.slew_limit)
    moved = Value(graph, "speed_reference") + action * (task.slew_limit * task.control_period)
    graph.output(REFERENCE, graph.clip(moved, 0.0, task.largest_reference))
    graph.outputs.sort(key=lambda output: output.name not in (RATE, REFERENCE))  # memory last
    model = graph.model("drillrig_policy")
    helper.set_model_props(model, as_properties(about(policy, name, graph)))
    return model


def scaled(graph: Graph, channels: tuple[Channel, ...]) -> Value:
    """What the environment makes of physical values: (value - offset) / scale, clipped; float32 (batch, channels)."""
    shown = []
    for channel in channels:
        offset = Value(graph, "speed_target") if channel.offset == "target" else channel.offset
        shown.append((Value(graph, channel.name) - offset) / channel.scale)
    return graph.cast(graph.clip(graph.beside(*shown), -LIMIT, LIMIT), np.float32)


def physical(graph: Graph, channels: tuple[Channel, ...], observation: Value) -> dict[str, Value]:
    """The physical values of an observation by channel, as `Sensors.values` has them, (batch, 1) each."""
    wide, names = graph.cast(observation, np.float64), [channel.name for channel in channels]
    columns = {name: graph.columns(wide, i, i + 1) for i, name in enumerate(names)}
    own = dict(zip(names, channels, strict=True))["speed_target"]
    target = columns["speed_target"] * own.scale + float(own.offset)
    return {
        channel.name: columns[channel.name] * channel.scale
        + (target if channel.offset == "target" else float(channel.offset))
        for channel in channels
    }


def about(policy: Exportable, name: str, graph: Graph) -> dict[str, Any]:
    """What a user of the file must know, as plain values by name."""
    task = policy.task
    names = [channel.name for channel in task.sensors.channels]
    drive = task.drive or getattr(policy, "drive", None) or Drive.of_rig(task.rig)
    return {
        "format": FORMAT,
        "name": name,
        "channels": [
            {"name": channel.name, "unit": channel.unit, "meaning": channel.meaning, "measured": channel.measured}
            for channel in task.sensors.channels
        ],
        "scaling": [
            {"channel": channel.name, "offset": channel.offset, "scale": channel.scale}
            for channel in task.sensors.channels
        ],
        "statistics": [one for one in _statistics(task) if one["channel"] in names],
        "control_period": {"value": task.control_period, "unit": "s"},
        "slew_limit": {"value": task.slew_limit, "unit": "rad/s^2"},
        "speed_reference": {"low": 0.0, "high": task.largest_reference, "unit": "rad/s"},
        "outputs": [
            {"name": RATE, "unit": "rad/s^2", "meaning": "rate of the speed reference in the coming control step"},
            {"name": REFERENCE, "unit": "rad/s", "meaning": "speed reference at the end of that step"},
        ],
        "memory": [
            {"name": memory, "width": width, "type": np.dtype(kind).name}
            for memory, (width, kind) in graph.memories.items()
        ],
        "drive": drive.as_dict(),
        "sensors": {"name": task.sensors.name, "noise": _plain(task.noise), "delay": _delays(policy)},
        "rig": asdict(task.rig),
        "training": dict(policy.training()),
    }


def _statistics(task: Task) -> list[dict[str, Any]]:
    """Running means and deviations that a controller makes itself: of what, over which time, from how many samples."""
    bit, mean, deviation = (
        task.reward.time_constant,
        TORQUE_MEAN_TIME * task.scales.time,
        TORQUE_DEVIATION_TIME * task.scales.time,
    )
    return [
        {"channel": "bit_speed_mean", "of": "bit_speed", "is": "mean", "time_constant": bit, "samples": SAMPLES},
        {"channel": "bit_speed_deviation", "of": "bit_speed", "is": "deviation", "time_constant": bit,
         "samples": SAMPLES},
        {"channel": "string_torque_mean", "of": "string_torque", "is": "mean", "time_constant": mean, "samples": 1},
        {"channel": "string_torque_deviation", "of": "string_torque", "is": "deviation", "time_constant": deviation,
         "mean_time_constant": mean, "samples": 1},
    ]  # fmt: skip


def _delays(policy: Exportable) -> list[int]:
    """The lowest and highest delay (control steps) that a policy is made for: its own where it says so."""
    own = getattr(policy, "delay", None)
    return list(policy.task.delays) if own is None else [own, own]


def _plain(noise: Any) -> Any:
    return dict(noise) if isinstance(noise, Mapping) else noise


__all__ = ["FORMAT", "NO_DIGEST", "RATE", "REFERENCE", "Exportable", "about", "build", "digest_of", "export_policy"]
