"""The reward: variance of the bit speed, tracking of the target, and the cost of moving the reference.

With m and V the exponentially weighted mean and variance of the bit speed,

    reward = - w_V V / omega*^2 - w_m e^2 - w_a a^2,   e = (m - omega*) / omega*,

or |e| in place of e^2 and sqrt(V) / omega* in place of V / omega*^2. Squares are nearly flat where the
scores decide (5 % off the target, a swing of 10 %); absolute values are not. Calm rotation at the target
scores 0. Variance alone would be won by standing still or by racing away; the second term stands
against both.

The reward in phases (`reward="phases"`) is made of the same mean and variance, and asks for one thing after the
other. With a share of motion s, a swing d and an error e, each of the latter as large as it can get for a bit that
stands,

    s = min(1, |m| / 0.3 omega*)
    d = s min(sqrt(V) / max(|m|, 0.3 omega*), 1.5) + (1 - s) 1.5
    e = s min(|m - omega*| / omega*, 2) + (1 - s) 2
    calm = 1 / (1 + (d / 0.07)^2),   on = 1 / (1 + (e / 0.05)^2) / (1 + (d / d_m)^2),   d_m = 0.07
    reward = - w_V (1 - calm + d / 2) - w_m (1 - on + e / 10) - w_a a^2.

While the bit shakes, `on` is small wherever the mean lies, so that nothing is lost by a detour over high speed; once it
is calm, the way down to the target pays. Nothing scores less than standing still. A bit that is never quite calm, such
as one on a tilted disc, is paid for being on target with a larger d_m, `tracking_swing`.

Terms of the user's own (`own`, see `drillrig_env.env.reward_terms`) are added to either, or stand alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

from drillrig_env.allowed import Allowed, Choice, Made
from drillrig_env.env.reward_terms import RewardTerms
from drillrig_env.modules import is_place
from drillrig_env.parameters import check_fields, parameter, refuse
from drillrig_env.toml import record_of

CALM_SWING = 0.07
"""In phases, the swing at which half of what calm is worth is there."""

_WEIGHT = Allowed(0.0, 1e6)
_SHAPE = Choice(("square", "absolute"))
_FORM = Choice(("sum", "phases"))


@dataclass(frozen=True)
class Reward:
    """Weights and shape of the reward. Raises `ValueError` for a value that is not allowed.

    >>> import gymnasium as gym
    >>> from drillrig_env import Reward
    >>> env = gym.make("DrillRig-v0", reward=Reward(tracking=2.0))
    >>> env.unwrapped.reward.tracking
    2.0
    """

    variance: float = parameter(1.0, meaning="weight w_V of the variance", allowed=_WEIGHT)
    tracking: float = parameter(1.0, meaning="weight w_m of the error of the mean", allowed=_WEIGHT)
    action: float = parameter(0.01, meaning="weight w_a of moving the reference", allowed=_WEIGHT)
    variance_shape: str = parameter(
        "square", meaning="V / omega*^2, or its root, the standard deviation", allowed=_SHAPE
    )
    tracking_shape: str = parameter("square", meaning="e^2, or |e|", allowed=_SHAPE)
    time_constant: float = parameter(
        2.5, "s", "of the running mean and variance: about one stick-slip period", allowed=Allowed(1e-12, 1e12)
    )
    form: str = parameter("sum", meaning="the terms as a sum, or in phases: first calm, then on target", allowed=_FORM)
    tracking_swing: float = parameter(
        CALM_SWING,
        meaning="d_m, in phases: the swing at which being on target counts half",
        allowed=Allowed(0.0, 10.0, low_open=True),
    )
    own: RewardTerms | None = parameter(
        None,
        meaning="terms of the user's own, added to these",
        allowed=Made(RewardTerms.of, "`RewardTerms`, or file.py:name of some"),
        none="none",
    )

    def __post_init__(self) -> None:
        check_fields(self)
        for name in ("variance_shape", "tracking_shape"):
            if self.form == "phases" and getattr(self, name) != "square":
                raise refuse("Reward", name, getattr(self, name), "", 'none beside form = "phases", which has its own')
        if self.form != "phases" and self.tracking_swing != CALM_SWING:
            raise refuse("Reward", "tracking_swing", self.tracking_swing, "", f'{CALM_SWING}, but for form = "phases"')

    @classmethod
    def of(cls, reward: RewardLike, time: float = 1.0) -> Reward:
        """A reward as environments take it: None for the default, "phases" for the one that agents are shipped with,
        a `Reward`, a dictionary of changes to the default, a TOML file, or `RewardTerms`, which then stand alone.

        A `time_constant` that is not given in s is the default's times `time`, a rig's scale of times. Raises
        `ValueError` for what is none of these, with the closest known name for an unknown field.
        """
        if isinstance(reward, str) and reward in PRESETS:
            made, given = PRESETS[reward], False
        elif isinstance(reward, RewardTerms) or is_place(reward):
            made, given = cls(0.0, 0.0, 0.0, own=RewardTerms.of(reward)), False
        else:
            made = record_of(cls, "reward", reward)
            given = "time_constant" in reward if isinstance(reward, Mapping) else reward is not None
        return made if given or time == 1.0 else replace(made, time_constant=made.time_constant * time)


PRESETS = {"phases": Reward(variance=0.1, tracking=0.2, action=0.003, form="phases")}
"""Rewards by name."""

RewardLike: TypeAlias = Reward | RewardTerms | Mapping[str, Any] | str | Path | None
"""What `Reward.of` takes."""
