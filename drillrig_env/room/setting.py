"""The setting of a room: which rig, who controls it, what is seen, how it begins. All that a link holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np

from drillrig_env.allowed import Allowed, Choice, Made
from drillrig_env.course import COLUMNS, Course
from drillrig_env.env.recorded import scenario_of
from drillrig_env.env.sensors import LONGEST_DELAY, SENSORS, Sensors
from drillrig_env.env.task import Task
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, check_fields, closest, parameter
from drillrig_env.policy import Policy, channels_of, drive_of, is_exact
from drillrig_env.policy.finding import context_of
from drillrig_env.rig import Rig
from drillrig_env.room.stock import Stock
from drillrig_env.room.strangers import named

MOST_STEPS = 36_000
"""Control steps of the longest run, an hour on the chapter's rig."""

LARGEST_SEED = 2**31 - 1

_STARTS = ("stick_slip", "steady", "rest")
_TARGET = 2.5
"""The target to begin with on the chapter's rig (rad/s): between its critical speed and its fold, at 10 N."""


def _name(value: Any) -> str:
    if not isinstance(value, str) or len(value) > 100:
        raise ValueError(f"{value!r} is not allowed; allowed: a name")
    return value


_NAME = Made(_name, "a name")


@dataclass(frozen=True)
class Setting:
    """What is chosen; None is the rig's own, and `at` fills it in. Raises `ValueError` for a value not allowed."""

    rig: str = parameter("laboratory", meaning="the rig, by name", allowed=_NAME)
    a: str = parameter("constant", meaning="who controls lane A", allowed=_NAME)
    b: str = parameter("lqg", meaning="who controls lane B", allowed=_NAME)
    sensors: str = parameter("state", meaning="what is seen", allowed=Choice(tuple(SENSORS)))
    noise: float | None = parameter(
        None, meaning="factor on the standard noise", allowed=Allowed(0.0, 100.0), none="the sensors' own"
    )
    delay: int | None = parameter(
        None,
        "control steps",
        "by which measurements come late",
        allowed=Allowed(0, LONGEST_DELAY, whole=True),
        none="the sensors' own",
    )
    k_p: float | None = parameter(
        None, "V s/rad", "proportional gain of the drive", allowed=NOT_NEGATIVE, none="the rig's own"
    )
    k_i: float | None = parameter(None, "V/rad", "integral gain of the drive", allowed=POSITIVE, none="the rig's own")
    start: str = parameter("stick_slip", meaning="how a run begins", allowed=Choice(_STARTS))
    seed: int = parameter(0, meaning="seed of a run", allowed=Allowed(0, LARGEST_SEED, whole=True))
    speed_target: float | None = parameter(
        None, "rad/s", "what the operator wants", allowed=POSITIVE, none="the rig's own"
    )
    normal_force: float | None = parameter(None, "N", "N_1", allowed=NOT_NEGATIVE, none="the rig's own")
    mu_s: float | None = parameter(None, meaning="static friction coefficient", allowed=NOT_NEGATIVE, none="own")
    mu_k: float | None = parameter(None, meaning="kinetic friction coefficient", allowed=NOT_NEGATIVE, none="own")
    v_b: float | None = parameter(None, "s/rad", "decay of friction with speed", allowed=POSITIVE, none="the rig's own")

    def __post_init__(self) -> None:
        check_fields(self, "control room")

    def changed(self, changes: Mapping[str, Any]) -> Setting:
        """The setting with some values anew. `ValueError` for an unknown name, and for a value that is not allowed.

        On another rig the numbers of the old one mean nothing: what is not among the changes is that rig's own.
        """
        known = [item.name for item in fields(self)]
        for name in changes:
            if name not in known:
                raise ValueError(f"control room: unknown setting {name!r}; {closest(name, known)}")
        anew: dict[str, Any] = {}
        if changes.get("rig", self.rig) != self.rig:
            anew = dict.fromkeys(("k_p", "k_i", *COLUMNS))
        return replace(self, **{**anew, **changes})

    def at(self, stock: Stock) -> Setting:
        """The setting with every None filled in, of a rig that the stock has."""
        rig, sensors = stock.rig_named(self.rig), Sensors.named(self.sensors)
        task = Task.for_rig(rig)
        friction = (stock.friction or task.scales.friction).single()
        own: dict[str, Any] = {
            "noise": sensors.noise,
            "delay": sensors.delay,
            "k_p": rig.k_p,
            "k_i": rig.k_i,
            "speed_target": float(f"{_TARGET * task.scales.speed:.3g}"),
            "normal_force": float(f"{friction.normal_force:.4g}"),
            "mu_s": float(friction.mu_s),
            "mu_k": float(friction.mu_k),
            "v_b": float(f"{friction.v_b:.4g}"),
        }
        return replace(self, **{name: value for name, value in own.items() if getattr(self, name) is None})

    def as_dict(self) -> dict[str, Any]:
        """Its values by name."""
        return asdict(self)

    def driven(self, stock: Stock) -> Rig:
        """The rig with the gains that are chosen, for a setting that is filled in."""
        gains: dict[str, Any] = {"k_p": self.k_p, "k_i": self.k_i}
        return replace(stock.rig_named(self.rig), **gains)

    def values(self) -> dict[str, float]:
        """What is given at first, by `COLUMNS`, for a setting that is filled in."""
        return {name: float(getattr(self, name)) for name in COLUMNS}

    def lane(self, name: str, stock: Stock) -> tuple[Task, Policy]:
        """The task of a lane that the policy `name` controls, and the policy, made for it.

        Raises `ValueError` where the sensors do not show what the policy must see, for a rig, a drive or a course that
        the environment refuses, and for whatever the policy raises when it is made.
        """
        rig, law = self.driven(stock), None if stock.friction is None else stock.friction.law
        plain = Task.for_rig(rig, sensors=self.sensors)
        course = Course(time=np.zeros(1), **{name: [value] for name, value in self.values().items()})
        base = replace(plain, scenario=scenario_of(plain, course, law))
        source, context, shown = stock.policy(name), context_of(base), base.sensors.names
        with named(f"{name} with k_p = {self.k_p:g} V s/rad and k_i = {self.k_i:g} V/rad"):
            policy = source.make(**context)
            sees, exact, own_drive = channels_of(policy), is_exact(policy), drive_of(policy)
        if missing := [channel for channel in sees or () if channel not in shown and not exact]:
            enough = [other for other in SENSORS if set(sees or ()) <= set(Sensors.named(other).names)]
            would_do = f"; sensors that would do: {', '.join(enough)}" if enough else ""
            raise ValueError(
                f"{name} sees {', '.join(missing)}, which the sensors {self.sensors!r} do not show{would_do}"
            )
        task = Task.of(
            base,
            sensors=shown if sees is None else sees,
            noise=0.0 if exact else self.noise,
            delay=0 if exact else self.delay,
            drive=own_drive,
            duration=MOST_STEPS * plain.control_period,
        )
        return task, policy
