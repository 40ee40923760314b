"""Hyperparameters that are written as text: schedules, and keyword arguments of the network."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from torch import nn

from drillrig_env.allowed import POSITIVE, Allowed

LEARNING_RATE = Allowed(0.0, 1.0, low_open=True)


@dataclass(frozen=True)
class Falling:
    """A number that falls linearly from `start` to zero over a training."""

    start: float

    def __call__(self, remaining: float) -> float:
        """The value when the share `remaining` of the training is still to come, from 1 to 0."""
        return remaining * self.start


def schedule(text: str) -> float | Falling:
    """`lin_8e-4`: falling linearly from 8e-4 to zero over the training; a plain number: constant."""
    try:
        start = POSITIVE.parse(text.removeprefix("lin_"))
    except ValueError as error:
        raise ValueError(f"schedule {text!r} is not allowed; allowed: a number > 0, or lin_<number>") from error
    return Falling(start) if text.startswith("lin_") else start


def policy_kwargs(value: str | Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of the network: a mapping, or text such as `dict(net_arch=[128, 128], activation_fn=nn.ReLU)`.

    The text may hold plain values and classes of `torch.nn`. Raises `ValueError` for anything else.
    """
    if isinstance(value, Mapping):
        return dict(value)
    refusal = (
        f"policy_kwargs = {value!r} is not allowed; allowed: dict(name=value, ...) with plain values and nn.<class>"
    )
    if not isinstance(value, str):
        raise ValueError(refusal)
    try:
        call = ast.parse(value.strip(), mode="eval").body
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "dict") or call.args:
            raise ValueError(refusal)
        return {keyword.arg: _value(keyword.value) for keyword in call.keywords if keyword.arg}
    except (SyntaxError, ValueError, AttributeError) as error:
        raise ValueError(refusal) from error


def _value(node: ast.expr) -> Any:
    """A literal; a class of `torch.nn`, written `nn.Tanh`; or `dict(...)` of such."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "nn":
        return getattr(nn, node.attr)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "dict":
        return {keyword.arg: _value(keyword.value) for keyword in node.keywords}
    return ast.literal_eval(node)
