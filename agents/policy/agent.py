"""A trained agent as a policy: a model that keeps its own memory, and what it was trained with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from stable_baselines3.common.base_class import BaseAlgorithm

from agents.policy.environment import environment_arguments, task_of
from agents.policy.frames import no_frames, push
from agents.policy.memory import Rows, layers_of, lstm_of, rows_of, width_of
from agents.policy.observer import ESTIMATED, Observer
from drillrig_env.drive import Drive
from drillrig_env.env.sensors import Sensors
from drillrig_env.env.task import Task
from drillrig_env.policy import AtHome
from drillrig_env.policy.given import check_state, flags_of, observations_of
from drillrig_env.scales import SLEW_LIMIT, Scales

if TYPE_CHECKING:
    from drillrig_env.deploy.graph import Graph, Value

_OF_TRAINING = ("scenario", "reward", "noise", "delay", "duration", "slew_limit")
"""Arguments of the environment that an agent was trained in and need not meet again."""

Memory = tuple[np.ndarray, ...] | None


class Agent(AtHome):
    """A trained model with Stable-Baselines3's `predict`, for observations of one step at a time.

    `config` is that of the run: see `agents.policy.run_folder`. A frame stack, a recurrent network's state and what an
    observer remembers travel in `predict`'s state, so that one agent may meet any number of rigs.
    """

    def __init__(self, model: BaseAlgorithm, config: Mapping[str, Any]) -> None:
        self.model, self.config = model, config
        self.frames = int(config["hyperparameters"].get("frame_stack", 1))
        self._task = task_of(self.environment)  # in which it was trained
        name = config["hyperparameters"].get("observer")
        self.observer = None if name is None else Observer(name, self._task)
        self._acting = self.slew_limit  # what its action 1 stands for now, rad/s^2
        self._scales: Scales | None = None  # of the rig that it acts on; None for its own

    @property
    def env_id(self) -> str:
        """The id of the environment that it acts in."""
        return str(self.config["env_id"])

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """The arguments of that environment beside those of the id; what only training drew or paid is left out."""
        kept = {name: value for name, value in self.config["env_kwargs"].items() if name not in _OF_TRAINING}
        own = self._acting / self._elsewhere
        return kept if own == SLEW_LIMIT * self._task.scales.rate else {**kept, "slew_limit": own}

    @property
    def environment(self) -> dict[str, Any]:
        """The arguments of the environment in which the agent was trained (`sensors`, `reward`, ...)."""
        return environment_arguments(self.config["env_id"], self.config["env_kwargs"])

    @property
    def task(self) -> Task:
        """What the agent was trained in."""
        return self._task

    def draw(self, graph: Graph, observation: Value) -> Value:
        """The action (batch, 1) of observations (batch, channels) in an ONNX graph; see `drillrig_env.deploy.build`.

        `ValueError` for a network that a graph cannot hold, with what it can.
        """
        from agents.shipping.onnx_graph import draw

        return draw(self, graph, observation)

    def predict_in_double(
        self, observation: npt.NDArray[np.float32], state: Memory = None
    ) -> tuple[np.ndarray, Memory]:
        """Actions (n, 1) for observations (n, channels), and the next state, without single precision's rounding."""
        from agents.shipping.onnx_graph import act_in_double

        return act_in_double(self, observation, state)

    def training(self) -> dict[str, Any]:
        """Where its weights come from: algorithm, environment, seed, steps, date and versions; for its file."""
        config, made = self.config, self.config.get("provenance", {})
        return {
            "kind": "network",
            "algorithm": config["algorithm"],
            "environment": config["env_id"],
            "env_kwargs": config["env_kwargs"],
            "seed": config["seed"],
            "steps": config["hyperparameters"].get("n_timesteps"),
            "frames": self.frames,
            "date": made.get("date"),
            "versions": made.get("versions", {}),
        }

    @property
    def sensors(self) -> Sensors:
        """What the agent must be shown."""
        return self._task.sensors

    @property
    def drive(self) -> Drive | None:
        """The drive that the agent was trained on, as the rig that it acts on has it; None for the rig's own."""
        own = self._task.drive
        return own if own is None or self._scales is None else self._scales.drive(own, self._task.scales)

    @property
    def slew_limit(self) -> float:
        """The slew limit (rad/s^2) that the agent was trained with: what its action 1 stands for."""
        return self._task.slew_limit

    @property
    def control_period(self) -> float:
        """Length of the control steps (s) that the agent was trained with."""
        return self._task.control_period

    def at_slew_limit(self, slew_limit: float, scales: Scales | None = None) -> Agent:
        """The same agent for an environment with this slew limit (rad/s^2): it wants the rates that it wanted.

        On a rig with other `scales` than its own, these are larger as all rates are.
        """
        if self.observer is not None and scales not in (None, self._task.scales):
            raise ValueError(
                f"{self.known_as or 'the agent'} looks through a filter of its own rig, and acts on no other"
            )
        agent = type(self)(self.model, self.config)
        agent.known_as, agent._acting = self.known_as, slew_limit
        agent._scales = None if scales == self._task.scales else scales
        return agent

    @property
    def _elsewhere(self) -> float:
        """By what rates are larger on the rig that it acts on than on its own."""
        return 1.0 if self._scales is None else self._scales.rate / self._task.scales.rate

    def predict(
        self,
        observation: npt.NDArray[np.float32],
        state: Memory = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[np.ndarray, Memory]:
        """Actions and the next state; shapes (n, 1) for observations (n, channels), and (1,) for (channels,).

        `ValueError` for observations of other sensors or that are not finite, and for a `state` or `episode_start` that
        is not of these rigs.
        """
        name = self.known_as or self.config["algorithm"]
        observation = observations_of(name, self.sensors.names, observation)
        rigs = 1 if observation.ndim == 1 else len(observation)
        if widths := self._widths(observation.shape[-1]):
            check_state(name, rigs, widths, state)
        flags = flags_of(name, rigs, episode_start)
        if self.observer is None:
            actions, memory = self._act(observation, state, flags, deterministic)
        else:
            remembered = None if state is None else state[-1]
            rows, remembered = self.observer.look(np.atleast_2d(observation), remembered, flags)
            shown = rows.reshape(*observation.shape[:-1], -1)
            actions, memory = self._act(shown, None if state is None else state[:-1] or None, flags, deterministic)
            memory = (*(memory or ()), remembered)
        rate = self.slew_limit * self._elsewhere / self._acting
        return (actions if rate == 1.0 else np.clip(rate * actions, -1.0, 1.0)), memory

    def _widths(self, channels: int) -> list[int]:
        """Numbers that it remembers of a rig, by parts of its state, but for those of an observer."""
        lstm = lstm_of(self.model)
        shown = channels + (0 if self.observer is None else len(ESTIMATED))
        stacks = [self.frames * shown] if self.frames > 1 else []
        return stacks + ([] if lstm is None else 2 * [width_of(lstm)])

    def _act(
        self,
        observation: npt.NDArray[np.float32],
        state: Memory,
        episode_start: npt.NDArray[np.bool_] | None,
        deterministic: bool,
    ) -> tuple[np.ndarray, Memory]:
        lstm, rows = lstm_of(self.model), np.atleast_2d(observation)
        if self.frames == 1 and lstm is None:
            return self.model.predict(observation, state, episode_start, deterministic)
        stacks: Rows = ()
        if self.frames > 1:
            stack = no_frames(len(rows), self.frames, rows.shape[1]) if state is None else state[0]
            rows = push(stack, rows, episode_start)
            stacks, state = (rows,), None if state is None else state[1:]
        if lstm is not None and not len(rows):  # sb3-contrib steps through rigs, and wants one
            none = np.empty((0, width_of(lstm)), np.float32)
            return np.empty((0, 1), np.float32), (*stacks, none, none)
        memory = layers_of(state, lstm.num_layers) if lstm is not None and state else None
        actions, memory = self.model.predict(rows, memory, episode_start, deterministic)
        return actions.reshape(*observation.shape[:-1], 1), (*stacks, *(rows_of(memory) if memory else ()))
