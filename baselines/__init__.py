"""Policies from the physics, each with Stable-Baselines3's `predict`.

Each works from what the sensors show; one that must be told more says so in `told`.
"""

from __future__ import annotations

from typing import Any

from baselines.baseline import Baseline
from baselines.constant import Constant
from baselines.jump_ease import JumpEase
from baselines.jump_ease_estimated import JumpEaseEstimated
from drillrig_env.parameters import closest

BASELINES: dict[str, type[Baseline]] = {
    "constant": Constant,
    "jump_ease": JumpEase,
    "jump_ease_estimated": JumpEaseEstimated,
}
"""Every baseline by name."""

__all__ = ["BASELINES", "Baseline", "Constant", "JumpEase", "JumpEaseEstimated", "make"]


def make(name: str, **kwargs: Any) -> Baseline:
    """A baseline by name; `kwargs` as for its class. `ValueError` for an unknown name."""
    if name not in BASELINES:
        raise ValueError(f"baseline {name!r} is not known; {closest(name, BASELINES)}")
    return BASELINES[name](**kwargs)
