"""The fields of a task as attributes of what plays it: read there, and set there where that has an effect."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from copy import copy
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

from drillrig_env.arrays import Quantity
from drillrig_env.drive import Drive
from drillrig_env.env.registration import check_length
from drillrig_env.env.reward import Reward
from drillrig_env.env.scenario import Scenario
from drillrig_env.env.sensors import Sensors
from drillrig_env.env.task import CHANGEABLE, TASK_FIELDS, Task
from drillrig_env.markdown import listed
from drillrig_env.parameters import closest
from drillrig_env.rig import Rig

if TYPE_CHECKING:
    from gymnasium.envs.registration import EnvSpec

    from drillrig_env.env.core import EpisodeBatch

T = TypeVar("T")


class TaskAttribute(Generic[T]):
    """One field of the task. Setting it is `change`, which refuses what an environment is made for."""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, instance: None, owner: type) -> TaskAttribute[T]: ...

    @overload
    def __get__(self, instance: PlaysTask, owner: type) -> T: ...

    def __get__(self, instance: PlaysTask | None, owner: type) -> TaskAttribute[T] | T:
        """The field of the instance's task."""
        if instance is None:
            return self
        value: T = getattr(instance.task, self.name)
        return value

    def __set__(self, instance: PlaysTask, value: Any) -> None:
        """Give the task another value."""
        instance.change(**{self.name: value})


class PlaysTask:
    """What has a task: the batch core and the forms of the environment.

    `scenario`, `reward`, `slew_limit`, `noise` and `delay` can be given anew, as attributes or by `change`; the other
    fields are what an environment is made for, and setting them raises an `AttributeError`.
    """

    rig = TaskAttribute[Rig]()
    scenario = TaskAttribute[Scenario]()
    sensors = TaskAttribute[Sensors]()
    noise = TaskAttribute[float | dict[str, float] | None]()
    delay = TaskAttribute[tuple[int, int] | None]()
    reward = TaskAttribute[Reward]()
    slew_limit = TaskAttribute[float]()
    largest_reference = TaskAttribute[float]()
    control_period = TaskAttribute[float]()
    drive = TaskAttribute[Drive | None]()
    privileged = TaskAttribute[bool]()
    duration = TaskAttribute[float]()

    core: EpisodeBatch

    @property
    def task(self) -> Task:
        """What is played."""
        return self.core.task

    @property
    def privileged_channels(self) -> tuple[str, ...]:
        """What the privileged part of an observation shows, by name and in order; none where there is no such part."""
        critic = self.core.critic
        return () if critic is None else tuple(channel.name for channel in critic.channels)

    def change(self, **fields: Any) -> None:
        """Give scenario, reward, slew limit, noise or delay another value, in any way that the environment takes it.

        Reward, slew limit (rad/s^2) and noise hold from the next step on, scenario and delay (control steps, no longer
        than what the environment was made for) from the next episode on. Raises `AttributeError` for other fields of
        the task and `ValueError` for a value that is not allowed.
        """
        self.core.change(**fields)

    def set_target(self, speed_target: Quantity) -> None:
        """Ask for another speed (rad/s) from now on, of all rigs or, as an array with one entry a rig, of each.

        `speed_target` is that speed.

        It is the operator's hand in an episode under way: the next observation shows it. Raises `ValueError` for a
        target that the task does not allow, and where the scenario's course gives it, and `ResetNeeded` before the
        first episode.
        """
        self.core.set_target(speed_target)


class GymnasiumForm(PlaysTask):
    """A form of the environment that Gymnasium registers: its spec says how long its episodes are."""

    _spec: EnvSpec | None = None

    @property
    def _frame_rate(self) -> int:
        """Frames in a second, so that a film takes as long as the rig does; one at least."""
        return max(1, round(1.0 / self.control_period))

    @property
    def spec(self) -> EnvSpec | None:
        """What the environment was made from; its `max_episode_steps` is the length of an episode."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        if spec is not None:
            check_length(self.duration, self.core.task.steps, sys._getframe(1))
            spec = copy(spec)
            spec.max_episode_steps = self.core.steps
        self._spec = spec


def set_for_all(form: PlaysTask, name: str, value: Any) -> None:
    """Set an attribute of the rigs of a vector environment; they share everything but their draws.

    Raises `AttributeError` for what cannot be changed, which is all but the task, and for a name that nothing has.
    """
    if name not in TASK_FIELDS and not hasattr(form, name):
        raise AttributeError(f"set_attr: there is no attribute {name!r}; {closest(name, TASK_FIELDS)}")
    if name not in TASK_FIELDS:
        raise AttributeError(f"set_attr: {name} cannot be changed; {listed(CHANGEABLE)} can be changed")
    setattr(form, name, value)


def check_changeable(names: Iterable[str]) -> None:
    """Raise `AttributeError` where a task's field cannot be changed, and `ValueError` where there is none of a name."""
    for name in names:
        if name in CHANGEABLE:
            continue
        if name in TASK_FIELDS:
            raise AttributeError(
                f"DrillRig: {name} cannot be changed, an environment is made for it: make a new one; "
                f"{listed(CHANGEABLE)} can be changed"
            )
        raise ValueError(f"DrillRig: {name!r} cannot be changed; {closest(name, CHANGEABLE)}")
