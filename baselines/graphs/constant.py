"""The constant reference as a graph."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from baselines.constant import Constant

if TYPE_CHECKING:
    from drillrig_env.deploy.graph import Graph, Value


def constant(law: Constant, graph: Graph, seen: Mapping[str, Value]) -> Value:
    """The target."""
    return seen["speed_target"]
