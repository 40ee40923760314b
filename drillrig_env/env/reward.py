"""The reward: variance of the bit speed, tracking of the target, and the cost of moving the reference.

With m and V the exponentially weighted mean and variance of the bit speed,

    reward = - w_V V / omega*^2 - w_m e^2 - w_a a^2,   e = (m - omega*) / omega*,

or |e| in place of e^2 and sqrt(V) / omega* in place of V / omega*^2. Squares are nearly flat where the
scores decide (5 % off the target, a swing of 10 %); absolute values are not. Calm rotation at the target
scores 0. Variance alone would be won by standing still or by racing away; the second term stands
against both.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from drillrig_env.allowed import Allowed, Choice
from drillrig_env.parameters import check_fields, parameter
from drillrig_env.toml import record_of

TERMS = ("variance", "tracking", "action")
"""Names of the reward's terms, in the order of `reward_terms`."""


_WEIGHT = Allowed(0.0, 1e6)
_SHAPE = Choice(("square", "absolute"))


@dataclass(frozen=True)
class Reward:
    """Weights and shape of the reward. Raises `ValueError` for a value that is not allowed."""

    variance: float = parameter(1.0, meaning="weight w_V of the variance", allowed=_WEIGHT)
    tracking: float = parameter(1.0, meaning="weight w_m of the error of the mean", allowed=_WEIGHT)
    action: float = parameter(0.01, meaning="weight w_a of moving the reference", allowed=_WEIGHT)
    variance_shape: str = parameter(
        "square", meaning="V / omega*^2, or its root, the standard deviation", allowed=_SHAPE
    )
    tracking_shape: str = parameter("square", meaning="e^2, or |e|", allowed=_SHAPE)
    time_constant: float = parameter(
        2.5, "s", "of the running mean and variance: about one stick-slip period", allowed=Allowed(1e-3, 1e6)
    )

    def __post_init__(self) -> None:
        check_fields(self)

    @classmethod
    def of(cls, reward: RewardLike) -> Reward:
        """A reward as environments take it: None for the default, a `Reward`, a dictionary of changes, or a TOML file.

        Raises `ValueError` for what is none of these, with the closest known name for an unknown field.
        """
        return record_of(cls, "reward", reward)


RewardLike: TypeAlias = Reward | Mapping[str, Any] | str | Path | None
"""What `Reward.of` takes."""
