"""An agent as an ONNX graph: physical values by name in, rate of the speed reference out.

Every channel is an input of its own, so that nobody has to know the order of an observation. Scaling
and clipping are part of the graph, in double precision as in the environment; the network follows in
single precision, operation by operation as Stable-Baselines3 has it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import onnx
import torch
from onnx import TensorProto, helper, numpy_helper
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.torch_layers import FlattenExtractor

from agents.policy.agent import Agent
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.sensors import LIMIT, Channel

OUTPUT = "speed_reference_rate"
"""Name of the output: the rate of the speed reference, rad/s^2, shape (batch, 1)."""

FRAMES, NEXT_FRAMES = "frames", "next_frames"
"""Names of the memory of an agent with a frame stack: zeros at first, then what came out last."""

_OPSET, _IR_VERSION = 17, 8  # both widely understood by runtimes
_OPERATORS = {torch.nn.Tanh: "Tanh", torch.nn.ReLU: "Relu", torch.nn.ELU: "Elu", torch.nn.Sigmoid: "Sigmoid"}


class Graph:
    """Nodes and constants of a graph in the making; every method returns the name of its result."""

    def __init__(self) -> None:
        self.nodes: list[onnx.NodeProto] = []
        self.constants: list[onnx.TensorProto] = []

    def constant(self, value: Any, dtype: type) -> str:
        """A constant array."""
        name = f"constant_{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.asarray(value, dtype=dtype), name))
        return name

    def add(self, operator: str, *inputs: str, output: str | None = None, **attributes: Any) -> str:
        """A node with one output."""
        name = output or f"{operator.lower()}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, list(inputs), [name], **attributes))
        return name


def build(agent: Agent) -> onnx.ModelProto:
    """The graph of a trained agent. `ValueError` for a network that it cannot hold, with what it can."""
    layers = actor_layers(agent)
    channels = agent.sensors.channels
    graph = Graph()
    observation = _observation(graph, channels)
    inputs = [helper.make_tensor_value_info(c.name, TensorProto.DOUBLE, ["batch", 1]) for c in channels]
    outputs = [helper.make_tensor_value_info(OUTPUT, TensorProto.FLOAT, ["batch", 1])]
    if agent.frames > 1:
        width = agent.frames * len(channels)
        inputs.append(helper.make_tensor_value_info(FRAMES, TensorProto.FLOAT, ["batch", width]))
        outputs.append(helper.make_tensor_value_info(NEXT_FRAMES, TensorProto.FLOAT, ["batch", width]))
        bounds = [graph.constant([n], np.int64) for n in (len(channels), width, 1)]
        kept = graph.add("Slice", FRAMES, *bounds)
        observation = graph.add("Concat", kept, observation, output=NEXT_FRAMES, axis=1)
    hidden = observation
    for layer in layers:
        hidden = _layer(graph, layer, hidden)
    ends = [graph.constant(end, np.float32) for end in (-1.0, 1.0)]
    action = graph.add("Clip", hidden, *ends)
    slew_limit = EpisodeBatch(1, **agent.environment).slew_limit
    graph.add("Mul", action, graph.constant(slew_limit, np.float32), output=OUTPUT)
    made = helper.make_graph(graph.nodes, "drillrig_agent", inputs, outputs, graph.constants)
    model = helper.make_model(made, opset_imports=[helper.make_opsetid("", _OPSET)], ir_version=_IR_VERSION)
    helper.set_model_props(model, _metadata(agent, slew_limit))
    onnx.checker.check_model(model)
    return model


def actor_layers(agent: Agent) -> list[torch.nn.Module]:
    """The layers from an observation to the action before clipping. `ValueError` for another kind of network."""
    model = agent.model
    policy: Any = model.policy
    if type(model) is PPO:
        layers, extractor = [*policy.mlp_extractor.policy_net, policy.action_net], policy.features_extractor
    elif type(model) is SAC:
        actor = policy.actor
        layers, extractor = [*actor.latent_pi, actor.mu, torch.nn.Tanh()], actor.features_extractor
    else:
        raise ValueError(f"{type(model).__name__}: a recurrent network is not exported; allowed: PPO and SAC")
    if type(extractor) is not FlattenExtractor:
        raise ValueError(f"features extractor {type(extractor).__name__} is not exported; allowed: FlattenExtractor")
    for layer in layers:
        if type(layer) is not torch.nn.Linear and type(layer) not in _OPERATORS:
            allowed = ", ".join(kind.__name__ for kind in (torch.nn.Linear, *_OPERATORS))
            raise ValueError(f"layer {type(layer).__name__} is not exported; allowed: {allowed}")
    return layers


def _observation(graph: Graph, channels: Sequence[Channel]) -> str:
    """What the environment makes of physical values: (value - offset) / scale, clipped; shape (batch, channels)."""
    scaled = []
    for channel in channels:
        offset = "speed_target" if channel.offset == "target" else graph.constant(channel.offset, np.float64)
        distance = graph.add("Sub", channel.name, offset)
        scaled.append(graph.add("Div", distance, graph.constant(channel.scale, np.float64)))
    row = graph.add("Concat", *scaled, axis=1)
    clipped = graph.add("Clip", row, graph.constant(-LIMIT, np.float64), graph.constant(LIMIT, np.float64))
    return graph.add("Cast", clipped, to=TensorProto.FLOAT)


def _layer(graph: Graph, layer: torch.nn.Module, hidden: str) -> str:
    if not isinstance(layer, torch.nn.Linear):
        return graph.add(_OPERATORS[type(layer)], hidden)
    weight = graph.constant(layer.weight.detach().numpy(), np.float32)
    bias = graph.constant(layer.bias.detach().numpy(), np.float32)
    return graph.add("Gemm", hidden, weight, bias, transB=1)


def _metadata(agent: Agent, slew_limit: float) -> dict[str, str]:
    """What a user of the file must know, as text; `channels` is JSON."""
    config = agent.config
    channels = [{"name": c.name, "unit": c.unit, "meaning": c.meaning} for c in agent.sensors.channels]
    return {
        "channels": json.dumps(channels),
        "output": f"{OUTPUT}: rate of the speed reference, rad/s^2",
        "control_period": f"{agent.control_period} s",
        "slew_limit": f"{slew_limit} rad/s^2",
        "frames": str(agent.frames),
        "environment": config["env_id"],
        "algorithm": config["algorithm"],
        "seed": str(config["seed"]),
        "versions": json.dumps(config.get("provenance", {}).get("versions", {})),
    }
