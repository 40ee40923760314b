"""What an episode draws: rig, target, friction, start and load."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal, TypeAlias

import numpy as np

from drillrig_env.allowed import SHARE, Allowed, Made, Span
from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.fleet import Fleet
from drillrig_env.friction import Friction
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, check_fields, closest, parameter, refuse
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales
from drillrig_env.toml import record_of

Start: TypeAlias = Literal["stick_slip", "steady", "rest", "given"]
STARTS: tuple[Start, ...] = ("stick_slip", "steady", "rest", "given")
STICK_SLIP, STEADY, REST, GIVEN = range(4)
MOST_LOAD_STEPS = 8
UNIFORMS = 12
"""Uniform numbers on [0, 1) that one episode takes from its generator, whatever it uses of them."""

LEAST_TARGET = 0.01
"""Lowest speed target on the chapter's rig (rad/s); far below it the reward's share of the target loses its meaning."""

_LEAST_MU_RATIO = 1.05

_SHIFTS = np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0]) % 1.0
"""What a draw's uniform numbers are shifted by, modulo 1, to make the next candidate: again uniform, and far away."""


_BEHIND = 2.0**26
"""Behind so many bits, those of the uniform number for the delay make another one, for the rig."""

_ONE_RIG = np.ones((1, 3))


@dataclass(frozen=True)
class Scenario:
    """The distribution of episodes. Ranges are drawn uniformly; `Scenario.named` has the presets.

    The numbers here are those of the chapter's rig; `at` makes those of another. The friction coefficients are those
    of `friction` (on a rig of a fleet whose friction is spread, of that rig's), each times a factor of its own drawn
    within 1 +- `spread`, and mu_s >= 1.05 mu_k is kept. A load step sets N_1 to a new draw at a uniform time. Raises
    `ValueError` for an empty or impossible range or share.
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
        """A preset by name ("nominal", "default", "wide"), changes to the default one, or the scenario itself.

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

    def at(self, scales: Scales) -> Scenario:
        """The scenario of a rig with such scales that corresponds to this one of the chapter's rig."""
        friction = self.friction

        def grown(span: tuple[float, float], factor: float) -> tuple[float, float]:
            return span[0] * factor, span[1] * factor

        if scales.speed == scales.force == 1.0:
            return self
        return replace(
            self,
            speed_target=grown(self.speed_target, scales.speed),
            normal_force=grown(self.normal_force, scales.force),
            load_force=self.load_force and grown(self.load_force, scales.force),
            friction=replace(
                friction,
                normal_force=np.asarray(friction.normal_force) * scales.force,
                v_b=np.asarray(friction.v_b) / scales.speed,
            ),
        )

    def draw(
        self, uniforms: FloatArray, duration: float, pins: Mapping[str, Any], rig_friction: FloatArray = _ONE_RIG
    ) -> Draws:
        """Turn uniform numbers of shape (n, UNIFORMS) into n episodes of `duration` s, pinned as told.

        `pins` are checked options, as from `drillrig_env.env.pins.check_pins`, but that "rig" is an index there.
        `rig_friction`, of shape (rigs, 3), has for each rig of the bank the factors of mu_k, of mu_s - mu_k and of v_b;
        those drawn are its first ones, as many as the fleet has.
        """
        if self.candidates > 1:
            one = replace(self, candidates=1)
            shifted = [(uniforms + k * _SHIFTS) % 1.0 for k in range(self.candidates)]
            slopes = [_slope(one.draw(each, duration, pins, rig_friction)) for each in shifted]
            hardest = np.where((uniforms[:, -1] * 2.0**20) % 1.0 < 0.5, np.argmin(slopes, axis=0), 0)
            uniforms = np.stack(shifted)[hardest, np.arange(len(uniforms))]
        u = uniforms.T
        n = len(uniforms)
        rig = np.minimum((u[10] * _BEHIND % 1.0 * len(rig_friction)).astype(int), len(rig_friction) - 1)
        if "rig" in pins:
            rig = np.broadcast_to(pins["rig"], n).copy()
        mu_s, mu_k, v_b = self._friction_of(rig, rig_friction)
        factors = 1.0 + self.spread * (2.0 * u[2:5] - 1.0)
        drawn = {
            "speed_target": _between(self.speed_target, u[0] ** self.target_skew),
            "normal_force": _between(self.normal_force, u[1]),
            "mu_s": mu_s * factors[0],
            "mu_k": mu_k * factors[1],
            "v_b": v_b * factors[2],
        }
        for name in drawn:
            if name in pins:
                drawn[name] = np.broadcast_to(pins[name], n).copy()
        if "mu_s" in pins and "mu_k" not in pins:
            drawn["mu_k"] = np.minimum(drawn["mu_k"], drawn["mu_s"] / _LEAST_MU_RATIO)
        elif "mu_s" not in pins:
            drawn["mu_s"] = np.maximum(drawn["mu_s"], drawn["mu_k"] * _LEAST_MU_RATIO)
        start = np.select([u[5] < self.stick_slip, u[5] < self.stick_slip + self.steady], [STICK_SLIP, STEADY], REST)
        if "start" in pins:
            start = np.broadcast_to(pins["start"], n).copy()
        if "state" in pins:
            start = np.full(n, GIVEN)
        times = np.full((n, MOST_LOAD_STEPS), np.inf)
        forces = np.zeros((n, MOST_LOAD_STEPS))
        if "load_steps" in pins:
            for i, (time, force) in enumerate(pins["load_steps"]):
                times[:, i], forces[:, i] = time, force
        else:
            times[:, 0] = np.where(u[7] < self.load_step, _between(self.load_time, u[8]) * duration, np.inf)
            forces[:, 0] = _between(self.load_force or self.normal_force, u[9])
        target = drawn.pop("speed_target")
        friction = Friction(**drawn, law=self.friction.law)
        given = {name: pins.get(name) for name in ("state", "speed_reference")}
        return Draws(rig, target, friction, start, u[6], times, forces, delay=u[10], noise=u[11], **given)

    def _friction_of(self, rig: np.ndarray, rig_friction: FloatArray) -> tuple[Quantity, Quantity, Quantity]:
        """mu_s, mu_k and v_b of the rigs, before the episode's own draws."""
        _, mu_s, mu_k, v_b = self.friction.as_array(1)[0]
        if np.all(rig_friction == 1.0):
            return mu_s, mu_k, v_b
        of_mu_k, of_difference, of_v_b = np.vstack([rig_friction, np.ones(3)])[np.minimum(rig, len(rig_friction))].T
        return mu_k * of_mu_k + (mu_s - mu_k) * of_difference, mu_k * of_mu_k, v_b * of_v_b


@dataclass(frozen=True, eq=False)
class Draws:
    """n drawn episodes: arrays with one entry an episode."""

    rig: np.ndarray  # index into the bank
    speed_target: FloatArray  # rad/s
    friction: Friction
    start: np.ndarray  # index into STARTS
    phase: FloatArray  # of the stick-slip cycle at the start, 0 to 1
    load_times: FloatArray  # (n, MOST_LOAD_STEPS), s; infinite where there is none
    load_forces: FloatArray  # (n, MOST_LOAD_STEPS), N
    delay: FloatArray  # where in its range the delay of the measurements lies, 0 to 1
    noise: FloatArray  # seed of the measurement noise, 0 to 1
    state: FloatArray | None = None  # (7,) or (n, 7), in which they begin where it is given
    speed_reference: FloatArray | None = None  # rad/s, () or (n,), with which they then begin; None is the target


PRESETS: dict[str, Scenario] = {
    "nominal": Scenario(normal_force=(10.0, 10.0), spread=0.0, load_step=0.0),
    "default": Scenario(),
    "wide": Scenario(normal_force=(2.0, 40.0), spread=0.4),
}


@lru_cache(maxsize=64)
def _preset_at(name: str, scales: Scales) -> Scenario:
    """A preset on a rig with such scales: always the same record, so that tasks can be compared."""
    return PRESETS[name].at(scales)


def _slope(draws: Draws) -> FloatArray:
    """How fast friction falls with speed at the target, N m s/rad but for a factor that all draws share."""
    if draws.friction.law != "exponential":
        return np.asarray(draws.friction.slope(Rig(), draws.speed_target))
    force, mu_s, mu_k, v_b = draws.friction.as_array().T
    return np.asarray(-force * (mu_s - mu_k) * v_b * np.exp(-v_b * draws.speed_target))


def _between(bounds: tuple[float, float], uniform: FloatArray) -> FloatArray:
    return bounds[0] + (bounds[1] - bounds[0]) * uniform
