"""Friction that wanders: rock and mud change along the way, and with them the coefficients."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, sqrt
from typing import Any

from drillrig_env.allowed import Allowed
from drillrig_env.parameters import POSITIVE, check_fields, parameter
from drillrig_env.toml import record_of


@dataclass(frozen=True)
class Wandering:
    """The logarithms of mu_k, mu_s - mu_k and v_b wander, each by itself, about those of the values that were drawn.

    They are Ornstein-Uhlenbeck processes, exact from control step to control step, and stationary from the start of an
    episode on: Uhlenbeck & Ornstein (1930). Raises `ValueError` for a value that is not allowed.

    >>> import gymnasium as gym
    >>> from drillrig_env import Scenario, Wandering
    >>> env = gym.make("DrillRig-v0", scenario=Scenario(wandering=Wandering(0.2, 20.0)))
    >>> first = env.reset(seed=0)[1]["mu_k"]
    >>> bool(env.step(env.action_space.sample())[-1]["mu_k"] != first)
    True
    """

    deviation: float = parameter(
        0.2, "", "stationary standard deviation of the logarithms", allowed=Allowed(0.0, 2.0, low_open=True)
    )
    time: float = parameter(20.0, "s", "correlation time", allowed=POSITIVE)

    def __post_init__(self) -> None:
        check_fields(self)

    @classmethod
    def of(cls, wandering: Any) -> Wandering:
        """A wandering as users give it: itself, changes to the default, or a TOML file with the table [wandering]."""
        return record_of(cls, "wandering", wandering)

    def over(self, period: float) -> tuple[float, float]:
        """What is left of a logarithm after a `period` (s), and the deviation of what is added."""
        kept = exp(-period / self.time)
        return kept, self.deviation * sqrt(1.0 - kept * kept)
