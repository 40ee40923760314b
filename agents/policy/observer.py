"""A filter under a network: what a model of the nominal rig makes of the measurements, shown beside them.

The Kalman filter of `lqg` estimates the seven states and the friction torque as they were at the last measurement. Its
estimates are channels in front of those of the sensors, so that a network need not learn to filter from nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from drillrig_env.arrays import FloatArray
from drillrig_env.env.sensors import LIMIT, Sensors
from drillrig_env.env.task import Task
from drillrig_env.model import STATE_NAMES
from drillrig_env.parameters import refuse
from drillrig_env.policy import context_of, make_policy, privileged_of

Rows = npt.NDArray[np.float32]

ESTIMATED = (*STATE_NAMES, "string_torque")
"""What is estimated, by channel; the torque is that of the friction, which the string has in steady rotation."""


class Observer:
    """The filter of the policy `name`, of the kind of `lqg`, for rigs of a `task`.

    `ValueError` for a policy that estimates nothing.
    """

    def __init__(self, name: str, task: Task) -> None:
        policy = make_policy(name, **context_of(task))
        if not hasattr(policy, "estimate"):
            raise refuse("observer", "policy", name, "", "lqg, or another that has its `estimate`")
        if told := privileged_of(policy):
            raise refuse(
                "observer", "policy", name, "", f"one that is told nothing; this one is told {', '.join(told)}"
            )
        self.policy: Any = policy
        self.sensors = task.sensors
        self.estimated = Sensors.named(ESTIMATED).at(task.scales).channels

    def look(
        self, observation: Rows, memory: FloatArray | None, starts: npt.NDArray[np.bool_] | None
    ) -> tuple[Rows, FloatArray]:
        """What a network is shown, (n, 8 + channels), of observations (n, channels), and what the filter remembers.

        `memory`, of shape (n, numbers), is what it remembered before, None at first; `starts` (n,) where an episode
        begins.
        """
        _, state = self.policy.predict(observation, None if memory is None else (memory,), starts, deterministic=True)
        target = self.sensors.value(observation, "speed_target")
        states, level = self.policy.estimate(state, target)
        shown = np.column_stack([states, level])
        for column, channel in zip(shown.T, self.estimated, strict=True):
            column -= target if channel.offset == "target" else channel.offset
            column /= channel.scale
        return np.concatenate([shown.clip(-LIMIT, LIMIT), observation], axis=1, dtype=np.float32), state[0]


class ShowsEstimates(VecEnvWrapper):
    """An environment of a `task` whose observations have the estimates of the policy `observer` in front."""

    def __init__(self, venv: VecEnv, observer: str, task: Task) -> None:
        self.observer = Observer(observer, task)
        assert venv.observation_space.shape is not None
        width = len(ESTIMATED) + venv.observation_space.shape[0]
        super().__init__(venv, observation_space=spaces.Box(-LIMIT, LIMIT, (width,), np.float32))
        self.memory: FloatArray | None = None

    def reset(self) -> VecEnvObs:
        """Begin an episode in every rig."""
        return self._look(self.venv.reset(), None)

    def step_wait(self) -> VecEnvStepReturn:
        """Step all rigs."""
        observations, rewards, dones, infos = self.venv.step_wait()
        ended = np.flatnonzero(dones).tolist()
        if ended:
            assert self.memory is not None
            last = np.stack([infos[rig]["terminal_observation"] for rig in ended])
            for rig, shown in zip(ended, self.observer.look(last, self.memory[ended], None)[0], strict=True):
                infos[rig]["terminal_observation"] = shown
        return self._look(observations, dones), rewards, dones, infos

    def _look(self, observations: VecEnvObs, starts: npt.NDArray[np.bool_] | None) -> VecEnvObs:
        assert isinstance(observations, np.ndarray)
        shown, self.memory = self.observer.look(observations, None if starts is None else self.memory, starts)
        return shown


def estimates_of(env: VecEnv) -> ShowsEstimates | None:
    """The part of an environment that shows estimates; None where it has none."""
    while isinstance(env, VecEnvWrapper):
        if isinstance(env, ShowsEstimates):
            return env
        env = env.venv
    return None
