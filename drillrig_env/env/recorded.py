"""A recorded run: all that an environment needs to play it again, bit for bit, as a file.

    run = Recorded.read("run.json")
    env = DrillRigEnv(**run.environment("A"))
    env.reset(**run.reset)
    for action in run.actions("A"):
        observation, reward, terminated, truncated, info = env.step(action)

What was given over time (target, normal force, friction) is the course of the environment's scenario, and who
controlled the rig, a policy or a hand, is in the actions. The control room writes such files.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.course import COLUMNS, Course
from drillrig_env.drive import Drive
from drillrig_env.env.scenario import STARTS, Scenario
from drillrig_env.env.sensors import Sensors
from drillrig_env.env.task import Task
from drillrig_env.files import write_text
from drillrig_env.parameters import COUNT, closest, refuse
from drillrig_env.rig import Rig

FORMAT, VERSION = "drillrig-run", 1

_LONGEST = 1_000_000
"""Most control steps of a run that is read."""


def scenario_of(task: Task, course: Course, law: Any = None) -> Scenario:
    """A scenario that draws nothing but what a seed decides beside `course`, which gives everything else.

    That is where in its cycle stick-slip begins, noise, and the delay where it has a range. `law` is the friction's.
    """
    scales = task.scales
    friction = scales.friction if law is None else replace(scales.friction, law=law)
    return replace(Scenario.named("nominal", scales), spread=0.0, load_step=0.0, friction=friction, course=course)


@dataclass(frozen=True, eq=False)
class RecordedLane:
    """One rig's part of a run: who controlled it, what its environment is made of, and the actions, shape (steps,)."""

    policy: str
    sensors: tuple[str, ...]
    noise: float
    delay: int
    drive: Drive | None
    taken: npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Recorded:
    """A run of one rig or more that share rig, course, seed and start.

    `setting` is what the control room makes of it, plain values by name.
    """

    rig: Rig
    law: str
    course: Course
    seed: int
    start: str
    lanes: Mapping[str, RecordedLane]
    setting: Mapping[str, Any]
    slew_limit: float | None = None  # rad/s^2; None is the rig's own

    @property
    def steps(self) -> int:
        """Control steps of the run."""
        return min(len(lane.taken) for lane in self.lanes.values())

    @property
    def reset(self) -> dict[str, Any]:
        """The arguments of the environment's `reset`."""
        return {"seed": self.seed, "options": {"start": self.start}}

    def environment(self, lane: str = "A") -> dict[str, Any]:
        """The arguments of the environment of a lane, as `DrillRigEnv` and `gym.make` take them."""
        own = self._lane(lane)
        plain = Task.for_rig(self.rig)
        return {
            "rig": self.rig,
            "scenario": scenario_of(plain, self.course, None if self.law == "exponential" else self.law),
            "sensors": own.sensors,
            "noise": own.noise,
            "delay": own.delay,
            "drive": own.drive,
            "slew_limit": plain.slew_limit if self.slew_limit is None else self.slew_limit,
            "duration": max(self.steps, 1) * plain.control_period,
        }

    def actions(self, lane: str = "A") -> npt.NDArray[np.float32]:
        """The actions of a lane, shape (steps, 1)."""
        return self._lane(lane).taken[: self.steps, None]

    def as_json(self) -> dict[str, Any]:
        """Plain values, as they are written."""
        columns = {name: [float(value) for value in self._column(name)] for name in COLUMNS}
        return {
            "format": FORMAT,
            "version": VERSION,
            "rig": asdict(self.rig),
            "law": self.law,
            "slew_limit": self.slew_limit,
            "reset": self.reset,
            "course": {"time": [float(time) for time in self.course.time], **columns},
            "lanes": {
                name: {
                    "policy": lane.policy,
                    "sensors": list(lane.sensors),
                    "noise": lane.noise,
                    "delay": lane.delay,
                    "drive": None if lane.drive is None else lane.drive.as_dict(),
                    "actions": [float(action) for action in lane.taken],
                }
                for name, lane in self.lanes.items()
            },
            "setting": dict(self.setting),
        }

    def write(self, path: str | Path) -> None:
        """Write the run as a JSON file, whole or not at all."""
        write_text(path, json.dumps(self.as_json()) + "\n")

    @classmethod
    def read(cls, path: str | Path) -> Recorded:
        """Read a run from a file. `ValueError` for one that is no such run, `FileNotFoundError` where there is none."""
        try:
            content = json.loads(Path(path).read_text(encoding="utf-8"))
        except FileNotFoundError as error:
            raise FileNotFoundError(f"run: there is no file {path}") from error
        except (OSError, UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
            raise ValueError(f"{path}: not a recorded run: {error}") from error
        return cls.of(content, str(path))

    @classmethod
    def of(cls, content: Any, where: str = "run") -> Recorded:
        """A run from plain values, as `as_json` has them; `where` says in errors what they are of.

        Raises `ValueError` naming what is not allowed. Nothing in it is a path or is run.
        """
        if not isinstance(content, Mapping) or content.get("format") != FORMAT:
            raise ValueError(f"{where}: not a recorded run: its format is not {FORMAT!r}")
        if content.get("version") != VERSION:
            raise refuse(where, "version", content.get("version"), "", VERSION)
        try:
            reset, law = content["reset"], content["law"]
            options, seed = reset["options"], reset["seed"]
            if law not in ("exponential", "gaussian", "linear"):
                raise ValueError(f"law = {law!r} is not known; allowed: exponential, gaussian, linear")
            if not COUNT.holds(seed + 1) or options["start"] not in STARTS[:3]:
                raise ValueError(f"reset = {reset}: a seed and a start are wanted")
            course = {name: content["course"][name] for name in ("time", *COLUMNS)}
            setting = content.get("setting", {})
            if not isinstance(content["rig"], Mapping) or not isinstance(setting, Mapping):
                raise ValueError("rig and setting must be tables of values by name")
            lanes = {str(name): _lane_of(lane) for name, lane in content["lanes"].items()}
            if not lanes:
                raise ValueError("there is no lane in it")
            rig = Rig.of(dict(content["rig"]))
            slew_limit = content.get("slew_limit")
            return cls(rig, law, Course(**course), int(seed), options["start"], lanes, dict(setting), slew_limit)
        except KeyError as error:
            raise ValueError(f"{where}: the entry {error} is missing") from error
        except (ValueError, TypeError, AttributeError, OverflowError) as error:
            raise ValueError(f"{where}: {error}") from error

    def _lane(self, lane: str) -> RecordedLane:
        if lane not in self.lanes:
            raise ValueError(f"run: lane {lane!r} is not there; {closest(lane, self.lanes)}")
        return self.lanes[lane]

    def _column(self, name: str) -> npt.NDArray[np.float64]:
        values = self.course.values(name)
        if values is None:
            raise refuse("run", "course", ", ".join(self.course.given), "", f"one that gives {', '.join(COLUMNS)}")
        return values


def _lane_of(content: Mapping[str, Any]) -> RecordedLane:
    """A lane from plain values. Raises `ValueError`, `KeyError` or `TypeError` for what is not allowed."""
    taken = np.array(content["actions"], dtype=np.float64)
    if taken.ndim != 1 or len(taken) > _LONGEST or not np.all(np.abs(taken) <= 1.0):
        raise ValueError(f"actions must be at most {_LONGEST} numbers from -1 to 1")
    sensors = Sensors.named(tuple(content["sensors"]))
    return RecordedLane(
        policy=str(content["policy"]),
        sensors=sensors.names,
        noise=content["noise"],
        delay=content["delay"],
        drive=Drive.of(content["drive"]),
        taken=taken.astype(np.float32),
    )
