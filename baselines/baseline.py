"""What all baselines share: a law for the speed reference behind Stable-Baselines3's `predict`."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.drive import Drive
from drillrig_env.env.actions import rate_action
from drillrig_env.env.sensors import SENSORS, Sensors
from drillrig_env.env.task import Task
from drillrig_env.fleet import Fleet, FleetLike
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.policy import AtHome
from drillrig_env.policy.given import check_state, flags_of, observations_of
from drillrig_env.rig import Rig, RigLike

if TYPE_CHECKING:
    from drillrig_env.deploy.graph import Graph, Value


class Baseline(AtHome):
    """A policy that names the speed reference it wants; the action is the rate that gets there.

    Subclasses give `desired_reference` and say, as class attributes, what they live on:

    - `channels`: always read;
    - `any_of`: alternatives, each a tuple of channels, of which the sensors must show one in full;
    - `privileged`: entries of `info` that must be handed over by `tell(info)` before each `predict`;
    - `exact`: whether it is shown the state as it is, whatever the sensors are: no rig shows that;
    - `memory`: numbers a rig that are kept from one call to the next;
    - `tuned`: arguments of the constructor that `python -m baselines.tune` searches, with their bounds;
    - `tuned_values`: what it found for them, by the sensors that it was run with;
    - `slow`: whether an episode takes minutes rather than seconds.

    `rig`, `slew_limit` (rad/s^2), `control_period` (s) and `largest_reference` (rad/s) are those of the environment
    that it acts in; None is the rig's own. `fleet` is what `Scenario.rigs` has of it: a policy that is told "rig" knows
    its members, all others go by the nominal rig. `friction` is what is known of the nominal rig's, at any force: its
    coefficients and its law; None is the chapter's in the scales of the rig. Sensors that do not show what a policy
    reads are refused with a `ValueError`.

    >>> from baselines import Baseline
    >>> class Patient(Baseline):
    ...     channels = ("speed_reference", "speed_target")
    ...
    ...     def desired_reference(self, seen, privileged, memory):
    ...         return 0.9 * seen["speed_reference"] + 0.1 * seen["speed_target"]
    ...
    >>> env = Patient().make_env()
    >>> observation, info = env.reset(seed=0)
    >>> action, memory = Patient().predict(observation)
    >>> action.shape
    (1,)
    """

    channels: ClassVar[tuple[str, ...]] = ("speed_reference", "speed_target")
    any_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    privileged: ClassVar[tuple[str, ...]] = ()
    memory: ClassVar[int] = 0
    tuned: ClassVar[dict[str, tuple[float, float]]] = {}
    tuned_values: ClassVar[dict[str, dict[str, float]]] = {}
    slow: ClassVar[bool] = False
    exact: ClassVar[bool] = False

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        control_period: float | None = None,
        largest_reference: float | None = None,
        fleet: FleetLike = None,
        friction: FrictionLike = None,
    ) -> None:
        self.task = Task.for_rig(
            rig,
            sensors="state" if self.exact else sensors,
            slew_limit=slew_limit,
            control_period=control_period,
            largest_reference=largest_reference,
        )
        self.sensors = self.task.sensors
        self.fleet = Fleet.of(fleet)
        self.friction = None if friction is None else Friction.of(friction).single()
        self._privileged_values: dict[str, FloatArray] = {}
        lacking = self._lacking(self.sensors)
        if lacking:
            would_do = [name for name, offered in SENSORS.items() if not self._lacking(offered)]
            raise ValueError(
                f"{type(self).__name__} reads {lacking}, which the sensors {sensors!r} do not show; "
                f"sensors that would do: {', '.join(would_do) or 'none of those with a name'}"
            )

    @classmethod
    def _lacking(cls, sensors: Sensors) -> str:
        """The channels that this policy misses, in words; empty where the sensors show enough."""
        shown = set(sensors.names)
        missing = [", ".join(name for name in cls.channels if name not in shown)]
        if cls.any_of and not any(shown.issuperset(group) for group in cls.any_of):
            missing.append("one of " + " or ".join(f"({', '.join(group)})" for group in cls.any_of))
        return " and ".join(part for part in missing if part)

    @property
    def rig(self) -> Rig:
        """The rig that it is made for."""
        return self.task.rig

    @property
    def slew_limit(self) -> float:
        """Largest rate of the speed reference (rad/s^2): what the action 1 stands for."""
        return self.task.slew_limit

    def _given_or_tuned(self, **given: float | None) -> dict[str, float]:
        """The tuned arguments: those given, and for None what was found with these sensors or the like.

        Sensors without values of their own take those for "surface" where the torque is the drive's
        estimate, and the first ones otherwise.
        """
        names = set(self.sensors.names)
        estimated = "string_torque" in names and not {"collar_speed", "top_speed"} <= names
        alike = "surface" if estimated and "surface" in self.tuned_values else next(iter(self.tuned_values))
        found = self.tuned_values.get(self.sensors.name, self.tuned_values[alike])
        return {name: found[name] if value is None else value for name, value in given.items()}

    @property
    def env_id(self) -> str:
        """The id of the environment whose sensors it reads: `DrillRigSurface-v0` for those of the surface."""
        return "DrillRigSurface-v0" if self.sensors.name == "surface" else "DrillRig-v0"

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """The arguments of its environment, beside those of the id."""
        kwargs: dict[str, Any] = {}
        if self.rig != Rig():
            kwargs["rig"] = self.rig
        own = Task.for_rig(self.rig)
        if self.task.largest_reference != own.largest_reference:
            kwargs["largest_reference"] = self.task.largest_reference
            own = Task.for_rig(self.rig, largest_reference=self.task.largest_reference)
        for name in ("slew_limit", "control_period"):  # what is the rig's own is another rig's own there
            if getattr(self.task, name) != getattr(own, name):
                kwargs[name] = getattr(self.task, name)
        if self.drive is not None:
            kwargs["drive"] = self.drive
        return kwargs if self.sensors.name in ("state", "surface") else {**kwargs, "sensors": self.sensors}

    @property
    def drive(self) -> Drive | None:
        """The drive that the policy asks for; None leaves the rig's own."""
        return None

    def draw(self, graph: Graph, observation: Value) -> Value:
        """The action (batch, 1) of observations (batch, channels) in an ONNX graph; see `drillrig_env.deploy.build`.

        `graph` is the one to draw in, `observation` its value.

        `ValueError` for a law of which there is no graph, with those of which there is.
        """
        from baselines.graphs import draw

        return draw(self, graph, observation)

    def training(self) -> Mapping[str, Any]:
        """Where its numbers come from: the law, and the values of what is tuned; for its file."""
        tuned = {} if not self.tuned else self._given_or_tuned(**dict.fromkeys(self.tuned))
        values = {name: float(getattr(self, name, value)) for name, value in tuned.items()}
        return {"kind": "law", "law": type(self).__name__, "values": values}

    def tell(self, info: Mapping[str, Any]) -> None:
        """Take from an environment's `info` what this policy is told; one entry a rig, or numbers."""
        self._privileged_values = {name: np.atleast_1d(np.asarray(info[name], dtype=float)) for name in self.privileged}

    def predict(
        self,
        observation: npt.NDArray[np.float32],
        state: tuple[np.ndarray, ...] | None = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[npt.NDArray[np.float32], tuple[np.ndarray, ...] | None]:
        """Actions for observations of shape (n, channels) or (channels,), and the policy's next state.

        `observation` is in the environment's own scaling.

        `state` is what the last call returned (None at first); where `episode_start` is true it is
        begun anew. The law is deterministic whatever `deterministic` says. `ValueError` for observations of other
        sensors or that are not finite, and for a `state` or `episode_start` that is not of these rigs.
        """
        name = self.known_as or type(self).__name__
        observation = observations_of(name, self.sensors.names, observation)
        batch = np.atleast_2d(observation)
        check_state(name, len(batch), [self.memory], state)
        starts = flags_of(name, len(batch), episode_start)
        memory = np.zeros((len(batch), self.memory)) if state is None else np.array(state[0])
        if starts is not None:
            memory[starts] = 0.0
        seen = self.sensors.values(batch)
        if self.privileged and not self._privileged_values:
            raise RuntimeError(
                f"{type(self).__name__} is told {', '.join(self.privileged)}: call tell(info) before predict"
            )
        desired = self._desired(seen, self._privileged_values, memory)
        actions = rate_action(desired, seen["speed_reference"], self.slew_limit, self.task.control_period)
        return (actions if observation.ndim == 2 else actions[0]), (memory,)

    def _desired(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The wanted speed reference in rad/s, from physical values."""
        return self.desired_reference(seen, privileged, memory)

    @abstractmethod
    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The wanted speed reference, rad/s, shape (n,).

        `seen` and `privileged` hold physical values by name, shape (n,); `memory` of shape (n, memory) is
        zero when an episode begins and is changed in place.
        """
