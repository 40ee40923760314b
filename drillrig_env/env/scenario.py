"""Of what episodes are drawn: rigs, targets, friction, starts, loads, and what of them varies in time."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal, TypeAlias

import numpy as np

from drillrig_env.allowed import SHARE, Allowed, Made, Span
from drillrig_env.course import Course
from drillrig_env.env.wandering import Wandering
from drillrig_env.fleet import Fleet
from drillrig_env.friction import Friction
from drillrig_env.friction.tilt import Tilt
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, check_fields, closest, parameter, refuse
from drillrig_env.scales import Scales
from drillrig_env.toml import record_of

Start: TypeAlias = Literal["stick_slip", "steady", "rest", "given"]
STARTS: tuple[Start, ...] = ("stick_slip", "steady", "rest", "given")
"""How an episode may begin; `info["start"]` is an index into it."""

STICK_SLIP, STEADY, REST, GIVEN = range(4)
MOST_LOAD_STEPS = 8
UNIFORMS = 12
"""Uniform numbers on [0, 1) that one episode takes from its generator, whatever it uses of them."""

LEAST_TARGET = 0.01
"""Lowest speed target on the chapter's rig (rad/s); far below it the reward's share of the target loses its meaning."""


@dataclass(frozen=True)
class Scenario:
    """The distribution of episodes. Ranges are drawn uniformly; `Scenario.named` has the presets.

    The numbers here are those of the chapter's rig; `at` makes those of another. The friction coefficients are those
    of `friction` (on a rig of a fleet whose friction is spread, of that rig's), each times a factor of its own drawn
    within 1 +- `spread`, and mu_s >= 1.05 mu_k is kept. A load step sets N_1 to a new draw at a uniform time, a target
    step the target. What a `course` gives holds in place of what would be drawn: from a control step to the next what
    it gives for the first one's begin. Raises `ValueError` for an empty or impossible range or share.

    >>> import gymnasium as gym
    >>> from drillrig_env import Scenario
    >>> env = gym.make("DrillRig-v0", scenario=Scenario(normal_force=(20.0, 21.0), load_step=0.0))
    >>> observation, info = env.reset(seed=0)
    >>> bool(20.0 <= info["normal_force"] <= 21.0)
    True
    """

    speed_target: tuple[float, float] = parameter((1.0, 5.0), "rad/s", "the target, drawn", allowed=Span(POSITIVE))
    target_skew: float = parameter(
        1.0,
        meaning="power of the uniform number behind the target: above 1, slow targets are more frequent",
        allowed=Allowed(0.0, 100.0, low_open=True),
    )
    normal_force: tuple[float, float] = parameter((5.0, 30.0), "N", "N_1, drawn", allowed=Span(NOT_NEGATIVE))
    spread: float = parameter(
        0.2, meaning="how far mu_s, mu_k and v_b are drawn from their values", allowed=Allowed(0.0, 1.0, high_open=True)
    )
    stick_slip: float = parameter(
        0.7, meaning="share of episodes that start in developed stick-slip; with `steady` at most 1", allowed=SHARE
    )
    steady: float = parameter(
        0.2, meaning="share that starts in steady rotation; the rest starts at rest", allowed=SHARE
    )
    load_step: float = parameter(0.5, meaning="share with one load step, drawn", allowed=SHARE)
    load_force: tuple[float, float] | None = parameter(
        None, "N", "what N_1 then steps to, drawn", allowed=Span(NOT_NEGATIVE), none="as normal_force"
    )
    load_time: tuple[float, float] = parameter(
        (0.0, 1.0), meaning="when it steps, as a share of the episode, drawn", allowed=Span(SHARE)
    )
    candidates: int = parameter(
        1,
        meaning="draws of which every second episode takes the hardest, where friction falls fastest at the target",
        allowed=Allowed(1, 100, whole=True),
    )
    friction: Friction = parameter(
        factory=Friction,
        meaning="nominal coefficients",
        allowed=Made(lambda given: Friction.of(given).single(), "a Friction, or a dictionary of changes to Friction()"),
    )
    target_step: float = parameter(0.0, meaning="share with one step of the target to a new draw", allowed=SHARE)
    target_time: tuple[float, float] = parameter(
        (0.2, 0.6), meaning="when the target steps, as a share of the episode, drawn", allowed=Span(SHARE)
    )
    wandering: Wandering | None = parameter(
        None,
        meaning="how the friction coefficients wander within an episode",
        allowed=Made(Wandering.of, "a Wandering, or a dictionary of changes to Wandering()"),
        none="they stay",
    )
    tilt: Tilt | None = parameter(
        None,
        meaning="how N_1 varies as disc 1 turns",
        allowed=Made(Tilt.of, "a Tilt, or a dictionary of changes to Tilt()"),
        none="it does not",
    )
    course: Course | None = parameter(
        None,
        meaning="what every episode is given over time, in place of what would be drawn",
        allowed=Made(Course.of, "a Course, a dictionary of its fields, or a CSV file"),
        none="nothing",
    )
    rigs: Fleet | None = parameter(
        None,
        meaning="the rigs, of which each episode draws one",
        allowed=Made(Fleet.of, "a Fleet, a list of rigs, or a dictionary of the arguments of Fleet.around"),
        none="the nominal rig alone",
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if self.stick_slip + self.steady > 1.0 + 1e-12:
            raise refuse("Scenario", "stick_slip", self.stick_slip, "", f"with steady = {self.steady} at most 1")

    @classmethod
    def named(cls, scenario: str | Mapping[str, Any] | Scenario, scales: Scales | None = None) -> Scenario:
        """A preset by name ("nominal", "default", "wide", "drift"), changes to the default one, or the scenario itself.

        Presets, and what is not changed of the default one, are those of a rig with these `scales`. `ValueError` for
        an unknown name or field.
        """
        if isinstance(scenario, str):
            if scenario not in PRESETS:
                hint = f"{closest(scenario, PRESETS)}, or a Scenario(...)"
                raise ValueError(f"scenario = {scenario!r} is not known; {hint}")
            return PRESETS[scenario] if scales is None else _preset_at(scenario, scales)
        if not isinstance(scenario, Scenario | Mapping):
            allowed = f"{', '.join(PRESETS)}, a Scenario, or a dictionary of its fields"
            raise refuse("DrillRig", "scenario", repr(scenario), "", allowed)
        if isinstance(scenario, Mapping) and "slower" in scenario:
            warnings.warn("the field `slower` of a scenario is now `target_skew`", DeprecationWarning, stacklevel=2)
            scenario = {"target_skew" if name == "slower" else name: value for name, value in scenario.items()}
        made = record_of(cls, "scenario", scenario)
        if scales is None or not isinstance(scenario, Mapping):
            return made
        return replace(_preset_at("default", scales), **{name: getattr(made, name) for name in scenario})

    @property
    def varies(self) -> bool:
        """Whether the friction or the target of an episode may change, beside its normal force."""
        return self.target_step > 0.0 or self.wandering is not None or self.course is not None

    def at(self, scales: Scales) -> Scenario:
        """The scenario of a rig with such scales that corresponds to this one of the chapter's rig."""
        friction = self.friction

        def grown(span: tuple[float, float], factor: float) -> tuple[float, float]:
            return span[0] * factor, span[1] * factor

        if scales.speed == scales.force == scales.time == 1.0:
            return self
        return replace(
            self,
            speed_target=grown(self.speed_target, scales.speed),
            normal_force=grown(self.normal_force, scales.force),
            load_force=self.load_force and grown(self.load_force, scales.force),
            wandering=self.wandering and replace(self.wandering, time=self.wandering.time * scales.time),
            friction=replace(
                friction,
                normal_force=np.asarray(friction.normal_force) * scales.force,
                v_b=np.asarray(friction.v_b) / scales.speed,
            ),
        )


PRESETS: dict[str, Scenario] = {
    "nominal": Scenario(normal_force=(10.0, 10.0), spread=0.0, load_step=0.0),
    "default": Scenario(),
    "wide": Scenario(normal_force=(2.0, 40.0), spread=0.4),
    "drift": Scenario(spread=0.0, wandering=Wandering(0.2, 20.0), tilt=Tilt(0.1, (1, 2)), target_step=1.0),
}
"""Scenarios by name, on the chapter's rig."""


@lru_cache(maxsize=64)
def _preset_at(name: str, scales: Scales) -> Scenario:
    """A preset on a rig with such scales: always the same record, so that tasks can be compared."""
    return PRESETS[name].at(scales)
