"""Suites: the rigs that every policy faces, with starts, loads, disturbances and seeds of their own.

>>> from drillrig_env.evaluation.suites import degraded_suite, drift_suite, load_suite, suite, unknown_suite, wide_suite
>>> [made(100).rigs for made in (wide_suite, load_suite, degraded_suite, drift_suite, unknown_suite)]
[100, 100, 100, 100, 1600]
>>> suite("degraded", rigs=10).env["noise"]
2.0
>>> suite("default", rigs=10).only(3).first_seed == suite("default", rigs=10).first_seed + 3
True
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from drillrig_env.env.registration import UNKNOWN
from drillrig_env.env.scenario import Scenario
from drillrig_env.fleet import Fleet
from drillrig_env.friction import Friction
from drillrig_env.parameters import closest, refuse
from drillrig_env.scales import SLEW_LIMIT, Scales
from drillrig_env.seeds import EVALUATION_FLEETS, EVALUATION_SEEDS
from drillrig_env.verdict import CALM_INDEX, MOVING_INDEX

PIECE = 1000
"""Rigs that are played together: a network's batch decides the last bits of its actions."""

LARGE = 10_000
"""Rigs of a suite beyond which rows are kept in Parquet files, and histories are those of the first piece alone."""

LARGEST_FLEET = 256
"""Most rigs of a suite's fleet."""

_CHAPTER = Scales()

_VARYING = ("rigs", "wandering", "tilt", "course")
"""Fields of a scenario that a definition leaves out where they say nothing, as before there were any of them."""

STICKING: dict[str, Any] = {"start": "stick_slip", "load_steps": []}
"""The reset options of an episode from developed stick-slip at a constant normal force."""


@dataclass(frozen=True, eq=False)
class Suite:
    """Rigs to face. `groups` lists how many rigs share which reset options, in the rigs' order.

    `name` and `description` say what it is; episodes are drawn from `scenario`, but for what options pin.

    `env` holds the arguments of the environment that the suite sets (noise, delay, slew limit); rig i
    has the seed `first_seed` + i. `scales` are those of the rig that all share, or of the nominal one of a fleet.
    `env_id` is the environment whose sensors are meant, where that is not open, and `calm_index` the stick-slip index
    below which a rig is calm. Rigs are played `piece` at a time. A part of a suite begins with its `first_rig`.
    """

    name: str
    description: str
    scenario: Scenario
    groups: tuple[tuple[int, dict[str, Any]], ...]
    env: Mapping[str, Any] = field(default_factory=dict)
    first_seed: int = EVALUATION_SEEDS.start
    scales: Scales = field(default_factory=Scales)
    env_id: str | None = None
    calm_index: float = CALM_INDEX
    first_rig: int = 0
    piece: int = PIECE

    @property
    def rigs(self) -> int:
        """Number of rigs, each an episode."""
        return sum(count for count, _ in self.groups)

    @property
    def slew_limit(self) -> float:
        """Largest rate of the speed reference (rad/s^2): what the action 1 stands for."""
        return float(self.env.get("slew_limit", SLEW_LIMIT * self.scales.rate))

    def only(self, rig: int) -> Suite:
        """The suite that holds a single rig of this one, which faces the very same episode."""
        if not 0 <= rig < self.rigs:
            raise refuse(f"suite {self.name}", "rig", rig, "", f"0 to {self.rigs - 1}")
        return self.part(rig, 1)

    def part(self, first: int, rigs: int) -> Suite:
        """The suite that holds the `rigs` of this one from the number `first` on, which face the very same episodes."""
        begin, groups = 0, []
        for count, options in self.groups:
            low, high = max(first - begin, 0), min(first + rigs - begin, count)
            if low < high:
                chosen = {
                    name: value[low:high] if isinstance(value, np.ndarray) else value for name, value in options.items()
                }
                groups.append((high - low, chosen))
            begin += count
        return replace(self, groups=tuple(groups), first_seed=self.first_seed + first, first_rig=self.first_rig + first)

    def definition(self) -> dict[str, Any]:
        """All that fixes the rigs, as plain numbers, lists and dictionaries."""
        groups = [[count, {name: _plain(value) for name, value in options.items()}] for count, options in self.groups]
        env = {name: _plain(value) for name, value in self.env.items()}
        scenario = {name: _plain(value) for name, value in asdict(replace(self.scenario, friction=Friction())).items()}
        scenario["friction"] = self.scenario.friction.as_dict()  # of a law of the user's own its name
        idle = [name for name in _VARYING if scenario[name] is None]
        if self.scenario.target_step == 0.0:
            idle += ["target_step", "target_time"]
        scenario = {name: value for name, value in scenario.items() if name not in idle}
        if "rigs" in scenario and not scenario["rigs"]["friction"]:
            del scenario["rigs"]["friction"]
        verdict = {} if self.calm_index == CALM_INDEX else {"calm_index": self.calm_index}
        return {
            "description": self.description,
            **verdict,
            "rigs": self.rigs,
            **({"piece": self.piece} if self.rigs > self.piece else {}),
            "first_seed": self.first_seed,
            "env": env,
            "scenario": scenario,
            "groups": groups,
        }


def default_suite(rigs: int = 1000, scales: Scales = _CHAPTER) -> Suite:
    """Draws of the default scenario from developed stick-slip, with constant N_1: the headline.

    `rigs` is their number, `scales` are those of the rig.
    """
    scenario = Scenario.named("default", scales)
    return Suite("default", "default draws, starts in stick-slip", scenario, _sticking(rigs), scales=scales)


def chapter_suite(_rigs: int, scales: Scales = _CHAPTER) -> Suite:
    """The chapter's own cases: 10 N and 20 N over 1 to 5 rad/s, and 25 N stepped on at 3.0 and 3.14 rad/s.

    `scales` are those of the rig; the number of rigs is given.

    >>> chapter_suite(0).rigs
    44
    """
    time, speed, force = scales.time, scales.speed, scales.force
    targets = np.arange(10, 51, 2) / 10 * speed
    sweeps = [
        (len(targets), {"speed_target": targets, "normal_force": load * force, "start": "stick_slip", "load_steps": []})
        for load in (10.0, 20.0)
    ]
    put_on = [(10.0 * time, 25.0 * force)]
    fast = np.array([3.0, 3.14]) * speed
    stepped = (2, {"speed_target": fast, "normal_force": 0.0, "start": "steady", "load_steps": put_on})
    scenario = Scenario.named("nominal", scales)
    return Suite("chapter", "the chapter's own cases", scenario, (*sweeps, stepped), scales=scales)


def wide_suite(rigs: int = 1000, scales: Scales = _CHAPTER) -> Suite:
    """Draws of the wide scenario, most of them outside the training range; otherwise as `default`.

    `rigs` is their number, `scales` are those of the rig.
    """
    scenario = Scenario.named("wide", scales)
    return Suite("wide", "wide draws, starts in stick-slip", scenario, _sticking(rigs), scales=scales)


def load_suite(rigs: int = 1000, scales: Scales = _CHAPTER) -> Suite:
    """Steady rotation at 5 to 15 N, stepped up to 15 to 30 N at 20 to 50 % of the episode: who keeps out?

    `rigs` is their number, `scales` are those of the rig.
    """
    scenario = Scenario(normal_force=(5.0, 15.0), load_force=(15.0, 30.0), load_time=(0.2, 0.5), load_step=1.0)
    groups = ((rigs, {"start": "steady"}),)
    return Suite("load", "steady starts, N_1 stepped up on the way", scenario.at(scales), groups, scales=scales)


def degraded_suite(rigs: int = 1000, scales: Scales = _CHAPTER) -> Suite:
    """The rigs of `default` seen with twice the noise and 0.1 to 0.5 s late, at half the slew limit.

    `rigs` is their number, `scales` are those of the rig.
    """
    return Suite(
        "degraded",
        "default with noise, delay and half the slew",
        Scenario.named("default", scales),
        _sticking(rigs),
        {"noise": 2.0, "delay": (1, 5), "slew_limit": 0.5 * SLEW_LIMIT * scales.rate},
        scales=scales,
    )


def unknown_suite(rigs: int = 256, scales: Scales = _CHAPTER) -> Suite:
    """Rigs whose string, inertias and friction are anything from half to twice the nominal, and motors 10 % off.

    `rigs` is how many the fleet has, `scales` are those of the nominal one.
    """
    return _of_fleet("unknown", "rigs that nobody knows", UNKNOWN, (1, 2), rigs, scales)


def unknown_hard_suite(rigs: int = 256, scales: Scales = _CHAPTER) -> Suite:
    """As `unknown`, within a factor of 3 and with up to twice the delay.

    `rigs` is how many the fleet has, `scales` are those of the nominal one.

    >>> unknown_hard_suite(100).scenario.rigs.spread["k_2"]
    3.0
    """
    spread = {**dict.fromkeys(UNKNOWN, 3.0), "motor": UNKNOWN["motor"]}
    return _of_fleet("unknown_hard", "rigs that nobody knows at all, seen late", spread, (1, 4), rigs, scales)


def drift_suite(rigs: int = 1000, scales: Scales = _CHAPTER) -> Suite:
    """The nominal rig in stick-slip, with friction that wanders, a tilted disc, and one step of the target.

    `rigs` is the number of episodes, `scales` are those of the rig.

    Such a rig is never quite calm, however well it is held: it counts as calm where the bit is certain not to stop.
    """
    return Suite(
        "drift",
        f"friction wanders, the disc is tilted, the target steps; calm below an index of {MOVING_INDEX}",
        Scenario.named("drift", scales),
        _sticking(rigs),
        {"noise": 1.0, "delay": (1, 2)},
        scales=scales,
        env_id="DrillRigDrift-v0",
        calm_index=MOVING_INDEX,
    )


_OF_ONE_RIG: dict[str, Callable[[int, Scales], Suite]] = {
    "chapter": chapter_suite,
    "default": default_suite,
    "wide": wide_suite,
    "load": load_suite,
    "degraded": degraded_suite,
}

SUITES = _OF_ONE_RIG | {"unknown": unknown_suite, "unknown_hard": unknown_hard_suite, "drift": drift_suite}
"""Every suite by name, in the order of the results."""

OF_ONE_RIG = tuple(_OF_ONE_RIG)
"""The suites of one rig that stays as it is."""

DRAWS = 16
"""Episodes of each rig of a fleet."""


def meant_for(env_id: str) -> tuple[str, ...]:
    """The suites that are run in the environment `env_id` where none is named: those of its own rigs, or of one rig.

    >>> meant_for("DrillRigDrift-v0"), meant_for("DrillRig-v0") == OF_ONE_RIG
    (('drift',), True)
    """
    return tuple(name for name in SUITES if suite(name, 1).env_id == env_id) or OF_ONE_RIG


def home_suite(env_id: str) -> str:
    """The suite of the own rigs of the environment `env_id`, by which an agent's seed is chosen.

    >>> home_suite("DrillRigUnknown-v0"), home_suite("DrillRigSurface-v0")
    ('unknown', 'default')
    """
    own = meant_for(env_id)
    return "default" if own == OF_ONE_RIG else own[0]


def suite(name: str, rigs: int = 1000, scales: Scales = _CHAPTER) -> Suite:
    """A suite by name; `rigs` counts for suites that are drawn. `ValueError` for an unknown name or rigs < 1.

    Its numbers are those of a rig with these `scales`.
    """
    if name not in SUITES:
        raise ValueError(f"suite {name!r} is not known; {closest(name, SUITES)}")
    if rigs < 1:
        raise refuse(f"suite {name}", "rigs", rigs, "", ">= 1")
    return SUITES[name](rigs, scales)


def _of_fleet(
    name: str, what: str, spread: Mapping[str, float], delay: tuple[int, int], rigs: int, scales: Scales
) -> Suite:
    """Episodes of a fleet that nothing is trained or tuned on: at most 256 rigs, DRAWS of each."""
    count = min(rigs, LARGEST_FLEET)
    fleet = Fleet.around(spread=spread, count=count, seed=EVALUATION_FLEETS.start)
    scenario = replace(Scenario.named("default", scales), spread=0.0, rigs=fleet)
    options = {**STICKING, "rig": np.repeat(np.arange(count), DRAWS)}
    env = {"noise": 1.0, "delay": delay}
    groups = ((count * DRAWS, options),)
    return Suite(
        name,
        f"{what}, {DRAWS} draws of each",
        scenario,
        groups,
        env,
        scales=scales,
        env_id="DrillRigUnknown-v0",
        piece=LARGEST_FLEET * DRAWS,
    )


def _sticking(rigs: int) -> tuple[tuple[int, dict[str, Any]], ...]:
    return ((rigs, STICKING),)


def _plain(value: Any) -> Any:
    """A value as JSON knows it."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {name: _plain(inner) for name, inner in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(inner) for inner in value]
    return value
