"""Under which conditions a contest is held: whose sensors, how noisy and how late, and the same for everyone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from drillrig_env.env.registration import ENVIRONMENTS
from drillrig_env.env.sensors import Sensors
from drillrig_env.env.task import Task
from drillrig_env.friction import Friction
from drillrig_env.markdown import listed
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales

_SET_BY_SUITES = (
    "rig",
    "scenario",
    "duration",
    "reward",
    "slew_limit",
    "largest_reference",
    "control_period",
)
"""Arguments of a training's environment that no contest takes over: suites set them, or leave the standard ones."""


@dataclass(frozen=True)
class Conditions:
    """The environment whose sensors everyone sees, their noise and their delay, but where a suite sets these.

    `noise` is a factor on the noise of the channels, or one for each by name; `delay` is in control steps, a number
    or the least and the most. `rig` is what all rigs of a suite share, and `largest_reference` (rad/s) the upper end of
    their speed reference; None is the rig's own. `friction` is what policies are designed for; None is the chapter's in
    the scales of the rig.
    """

    env_id: str
    noise: float | Mapping[str, float]
    delay: tuple[int, int]
    rig: Rig = field(default_factory=Rig)
    largest_reference: float | None = None
    friction: Friction | None = None

    @classmethod
    def named(cls, conditions: str | Conditions) -> Conditions:
        """Conditions, or the standard ones of an environment by its id."""
        return conditions if isinstance(conditions, Conditions) else cls.of(conditions)

    @classmethod
    def of(cls, env_id: str, arguments: Mapping[str, Any] | None = None) -> Conditions:
        """The conditions of an environment that is made with these `arguments`."""
        chosen = {**ENVIRONMENTS[env_id], **(arguments or {})}
        task = Task(**{name: chosen[name] for name in ("sensors", "noise", "delay") if name in chosen})
        return cls(env_id, task.sensors.noise if task.noise is None else task.noise, task.delays)

    @property
    def sensors(self) -> Sensors:
        """All that can be seen."""
        return Sensors.named(ENVIRONMENTS[self.env_id]["sensors"])

    @property
    def arguments(self) -> dict[str, Any]:
        """The arguments of the environment."""
        own: dict[str, Any] = {} if self.rig == Rig() else {"rig": self.rig}
        if self.largest_reference is not None:
            own["largest_reference"] = self.largest_reference
        return {"sensors": self.sensors.name, "noise": self.noise, "delay": self.delay, **own}

    @property
    def scales(self) -> Scales:
        """The scales of the rig."""
        return Scales.of(self.rig, self.largest_reference)

    def __str__(self) -> str:
        low, high = self.delay
        late = f"{low}" if low == high else f"{low} to {high}"
        unit = "step" if high == 1 else "steps"
        return f"the sensors of {self.env_id}, noise {self.noise}, delay {late} {unit}"


def conditions_for(
    trainings: Mapping[str, Mapping[str, Any]], env_id: str | None = None, say: Callable[[str], object] = print
) -> Conditions:
    """The conditions of a contest with these trained agents, which are given by name with their run's config.

    They are those under which all of them were trained, whatever the baselines beside them are used to. Where
    they were trained under different ones, or under another environment's than `env_id`, they are the standard
    ones of `env_id`; without it, of the first environment that shows what all of them see, or else of the first. `say`
    is called with a line for each agent that meets anything else than in its training.
    """
    trained = {name: Conditions.of(config["env_id"], config["env_kwargs"]) for name, config in trainings.items()}
    ways = list(trained.values())
    if ways and all(way == ways[0] for way in ways) and env_id in (None, ways[0].env_id):
        conditions = ways[0]
    else:
        seen = [channel for way in ways for channel in way.sensors.names]
        conditions = Conditions.of(env_id or [*showing(seen), *ENVIRONMENTS][0])
    for name, config in trainings.items():
        if line := _told(trained[name], conditions, config["env_kwargs"]):
            say(f"{name} was trained with {line}")
    return conditions


def showing(channels: Iterable[str]) -> list[str]:
    """The ids of the environments whose sensors show all of these channels."""
    wanted = set(channels)
    return [env_id for env_id in ENVIRONMENTS if wanted <= set(Conditions.of(env_id).sensors.names)]


def _told(trained: Conditions, conditions: Conditions, arguments: Mapping[str, Any]) -> str:
    """What an agent's training had that the contest has too, beyond the standard, and what it had and has not."""
    parts = []
    if trained != conditions:
        parts.append(f"{trained}, and meets {conditions}")
    elif trained != Conditions.of(trained.env_id):
        parts.append(f"{trained}, and so is everyone here shown the rigs")
    others = [name for name in _SET_BY_SUITES if arguments.get(name) is not None]
    if others:
        verb = "are" if len(others) > 1 else "is"
        parts.append(f"{listed(others)} of its own, which {verb} not taken over: suites and scores are everyone's")
    return "; with ".join(parts)
