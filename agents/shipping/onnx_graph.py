"""A trained network as operators of an ONNX graph, one by one as Stable-Baselines3 has it, in double precision.

Stable-Baselines3 computes in single precision, whose rounding depends on machine and batch: it moves actions by some
1e-6 (`largest_difference` of `drillrig_env.deploy.export` measures it). In double precision the file is the network
itself, and the same on every machine; the weights are kept as they are, in single precision.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.torch_layers import FlattenExtractor

from agents.policy.agent import Agent, Memory
from agents.policy.frames import Frames, no_frames, push
from agents.policy.memory import layers_of, lstm_of, rows_of
from drillrig_env.deploy.graph import Graph, Value

FRAMES = "frames"
"""Name of the memory of an agent with a frame stack: zeros at first, the oldest observation first."""

_OPERATORS = {torch.nn.Tanh: "Tanh", torch.nn.ReLU: "Relu", torch.nn.ELU: "Elu", torch.nn.Sigmoid: "Sigmoid"}


def draw(agent: Agent, graph: Graph, observation: Value) -> Value:
    """The action (batch, 1) of a trained agent. `ValueError` for a network that cannot be a graph, with what can."""
    layers = actor_layers(agent)
    hidden = observation
    if agent.frames > 1:
        channels = len(agent.sensors.channels)
        width = agent.frames * channels
        frames = graph.memory(FRAMES, width, np.float32)
        hidden = graph.beside(graph.columns(frames, channels, width), observation)
        graph.remember(FRAMES, hidden)
    hidden = graph.cast(hidden, np.float64)
    for layer in layers:
        hidden = _lstm(graph, layer, hidden) if isinstance(layer, torch.nn.LSTM) else _layer(graph, layer, hidden)
    return graph.clip(hidden, -1.0, 1.0)


def act_in_double(agent: Agent, observation: Frames, state: Memory) -> tuple[np.ndarray, Memory]:
    """What `agent.predict` gives, with the network computed in double precision: (n, 1), and the next state."""
    rows = np.atleast_2d(observation)
    kept: list[np.ndarray] = []
    if agent.frames > 1:
        stack = no_frames(len(rows), agent.frames, rows.shape[1]) if state is None else state[0]
        rows = push(stack, rows)
        kept, state = [rows], None if state is None else state[1:]
    hidden = torch.as_tensor(rows, dtype=torch.float64)
    with torch.no_grad():
        for layer in actor_layers(agent):
            double: Any = copy.deepcopy(layer).double().eval()  # nothing is dropped out
            if isinstance(layer, torch.nn.LSTM):
                memory = None if state is None else tuple(map(torch.from_numpy, layers_of(state, layer.num_layers)))
                hidden, memory = double(hidden[None], memory)
                hidden, kept = hidden[0], [*kept, *rows_of(tuple(part.numpy() for part in memory))]
            else:
                hidden = double(hidden)
    return np.clip(hidden.numpy(), -1.0, 1.0), tuple(kept) or None


def actor_layers(agent: Agent) -> list[torch.nn.Module]:
    """The layers from an observation to the action before clipping. `ValueError` for another kind of network."""
    model = agent.model
    policy: Any = model.policy
    if agent.observer is not None:
        name = agent.config["hyperparameters"]["observer"]
        raise ValueError(f"the filter `{name}` before the network is not exported; allowed: a network alone")
    if type(model) is PPO:
        layers, extractor = [*policy.mlp_extractor.policy_net, policy.action_net], policy.features_extractor
    elif type(model) is SAC:
        actor = policy.actor
        layers, extractor = [*actor.latent_pi, actor.mu, torch.nn.Tanh()], actor.features_extractor
    elif type(lstm := lstm_of(model)) is torch.nn.LSTM and not (lstm.bidirectional or lstm.proj_size) and lstm.bias:
        layers, extractor = [lstm, *policy.mlp_extractor.policy_net, policy.action_net], policy.pi_features_extractor
    else:
        allowed = "PPO, SAC, and recurrent PPO with a plain LSTM"
        raise ValueError(f"{type(model).__name__}: this network is not exported; allowed: {allowed}")
    if type(extractor) is not FlattenExtractor:
        raise ValueError(f"features extractor {type(extractor).__name__} is not exported; allowed: FlattenExtractor")
    for layer in layers:
        if type(layer) not in (torch.nn.Linear, torch.nn.LSTM, *_OPERATORS):
            allowed = ", ".join(kind.__name__ for kind in (torch.nn.Linear, *_OPERATORS))
            raise ValueError(f"layer {type(layer).__name__} is not exported; allowed: {allowed}")
    return layers


def _layer(graph: Graph, layer: torch.nn.Module, hidden: Value) -> Value:
    if not isinstance(layer, torch.nn.Linear):
        return graph.make(_OPERATORS[type(layer)], hidden)
    return _applied(graph, layer.weight, layer.bias, hidden)


def _lstm(graph: Graph, lstm: torch.nn.LSTM, hidden: Value) -> Value:
    """The layers of an LSTM, with its state as memories of the graph."""
    width = lstm.hidden_size
    for layer in range(lstm.num_layers):
        names = f"hidden_{layer}", f"cell_{layer}"
        before, cell = (graph.memory(name, width) for name in names)
        by_input, by_memory = (
            _applied(graph, getattr(lstm, f"weight_{part}_l{layer}"), getattr(lstm, f"bias_{part}_l{layer}"), value)
            for part, value in (("ih", hidden), ("hh", before))
        )
        gates = by_input + by_memory
        let_in, keep, fresh, let_out = (graph.columns(gates, k * width, (k + 1) * width) for k in range(4))
        cell = graph.make("Sigmoid", keep) * cell + graph.make("Sigmoid", let_in) * graph.make("Tanh", fresh)
        hidden = graph.make("Sigmoid", let_out) * graph.make("Tanh", cell)
        for name, value in zip(names, (hidden, cell), strict=True):
            graph.remember(name, value)
    return hidden


def _applied(graph: Graph, weight: torch.Tensor, bias: torch.Tensor, hidden: Value) -> Value:
    """A layer's weights, kept in single precision, applied in double."""
    kept = (graph.cast(graph.constant(value.detach().numpy(), np.float32), np.float64) for value in (weight, bias))
    return graph.make("Gemm", hidden, *kept, transB=1)
