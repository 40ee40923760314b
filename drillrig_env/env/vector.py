"""`DrillRig-v0` as a native Gymnasium vector environment: N rigs, one compiled call a step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from drillrig_env.env.actions import check_actions
from drillrig_env.env.attributes import GymnasiumForm, set_for_all
from drillrig_env.env.many import ManyRigs
from drillrig_env.env.pins import options_of
from drillrig_env.env.privileged import Seen, copied, observation_space
from drillrig_env.env.task import TaskLike
from drillrig_env.parameters import refuse

Step = tuple[Seen, npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.bool_], dict[str, Any]]
Seeds = int | Sequence[int | None] | npt.NDArray[np.integer] | None


class DrillRigVectorEnv(ManyRigs, GymnasiumForm, VectorEnv[Seen, npt.NDArray[np.float32], np.ndarray]):
    """N rigs of `DrillRig-v0` side by side; `DrillRigEnv` describes spaces, reward, infos and arguments.

    `num_envs` is N; `task` and `fields` are given as to `DrillRigEnv`, `render_mode` is "rgb_array" or None.

    Rig i with the seed s is, bit for bit, the single environment with the seed s + i, whatever the
    number of rigs and `threads` (default: all cores).

    `autoreset_mode` is Gymnasium's: the step after an episode's last begins the next one (NEXT_STEP,
    the default), or that last step itself does and leaves `final_obs` and `final_info` (SAME_STEP),
    or `reset(options={"reset_mask": mask})` does (DISABLED). `max_episode_steps` ends episodes before their
    `duration` does.

    >>> import numpy as np
    >>> envs = DrillRigVectorEnv(16, scenario="nominal", duration=2.0)
    >>> observations, infos = envs.reset(seed=0)
    >>> observations, rewards, terminated, truncated, infos = envs.step(np.zeros((16, 1), dtype=np.float32))
    >>> observations.shape, rewards.shape, infos["bit_speed"].shape
    ((16, 12), (16,), (16,))
    """

    def __init__(
        self,
        num_envs: int = 1,
        task: TaskLike = None,
        *,
        threads: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **fields: Any,
    ) -> None:
        self._make(num_envs, task, threads, render_mode, fields)
        self.num_envs = len(self.core)
        self.autoreset_mode = check_autoreset_mode(autoreset_mode)
        self.metadata = {
            "render_modes": ["rgb_array"],
            "render_fps": self._frame_rate,
            "autoreset_mode": self.autoreset_mode,
        }
        self.single_action_space = spaces.Box(-1.0, 1.0, (1,), np.float32)
        self.single_observation_space = observation_space(len(self.sensors.channels), self.core.critic)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._everywhere = np.ones(self.num_envs, dtype=np.bool_)

    def reset(self, *, seed: Seeds = None, options: dict[str, Any] | None = None) -> tuple[Seen, dict[str, Any]]:
        """Begin an episode in every rig, or in those of `options["reset_mask"]`.

        `seed` s gives rig i the seed s + i; a list gives each its own. `options` are those of the
        single environment, with one number for all or one a rig that is reset; as in Gymnasium they hold
        for the episodes that begin now.
        """
        self._generators.seed_all(seed)
        pins = options_of(options)
        mask = np.asarray(pins.pop("reset_mask", self._everywhere))
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            raise ValueError(f"reset_mask of shape {mask.shape} and {mask.dtype}; allowed: ({self.num_envs},) and bool")
        self._begin(np.flatnonzero(mask), pins)
        return copied(self.core.seen), self._info()

    def step(self, actions: npt.NDArray[np.float32]) -> Step:
        """Step all rigs; `actions` of shape (num_envs, 1), clipped to +-1. NaN is a `ValueError`."""
        core = self.core
        rates = check_actions(actions, self.num_envs)
        over = core.ended
        if over.any() and (self.autoreset_mode != AutoresetMode.NEXT_STEP or not self._generators.seeded):
            raise ResetNeeded(f"the episode of rig {int(np.argmax(over))} is over, or none has begun; reset it first")
        self._advance(rates)
        rewards = core.episodes["reward"].copy()
        if over.any():
            self._begin(np.flatnonzero(over))
            rewards[over] = 0.0
        truncated = core.ended
        info = self._info()
        if truncated.any() and self.autoreset_mode == AutoresetMode.SAME_STEP:
            final = {
                "final_obs": core.seen,
                "_final_obs": truncated,
                "final_info": info,
                "_final_info": truncated,
            }
            self._begin(np.flatnonzero(truncated))
            info = {**self._info(), **final}
        return copied(core.seen), rewards, np.zeros(self.num_envs, dtype=np.bool_), truncated, info

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """A method of this environment, called once, or an attribute; the result once for each rig.

        `name` is its name; `args` and `kwargs` go to the method.
        """
        found = getattr(self, name)
        return (found(*args, **kwargs) if callable(found) else found,) * self.num_envs

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of this environment, once for each rig. `name` is its name."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute for all rigs, which share everything but their draws; `scenario`, for example.

        `name` is its name.

        `values` is one value, or a list or tuple of it, once for each rig. Raises `AttributeError` for what cannot
        be changed (see `change`) and `ValueError` for values that differ or are not allowed.
        """
        if isinstance(values, list | tuple):
            if len(values) != self.num_envs or any(value != values[0] for value in values):
                raise ValueError(f"set_attr: {name} that differs between rigs is not allowed; allowed: one for all")
            values = values[0]
        set_for_all(self, name, values)

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """The rigs as RGB, a frame of shape (540, 960, 3) each, in the mode "rgb_array"; otherwise None.

        Raises `ResetNeeded` before the first episode.
        """
        if self._pictures is not None:
            return self._pictures.frames()
        gym.logger.warn(
            "render() does nothing without a render_mode; name one when the environment is made, "
            'for example gym.make_vec("DrillRig-v0", num_envs=2, render_mode="rgb_array")'
        )
        return None

    @property
    def _form(self) -> str:
        """Which episodes are begun when depends on the mode as well."""
        return f"{super()._form} in the mode {self.autoreset_mode.value}"

    def _info(self) -> dict[str, Any]:
        info, everywhere = self.core.info(), self._everywhere.copy()  # what is given away may be written into
        return {**info, **{f"_{name}": everywhere for name in info}}


def check_autoreset_mode(mode: AutoresetMode | str) -> AutoresetMode:
    """Gymnasium's mode from itself or its name, such as "SameStep"; `ValueError` for anything else.

    >>> check_autoreset_mode("SameStep")
    <AutoresetMode.SAME_STEP: 'SameStep'>
    """
    try:
        return AutoresetMode(mode)
    except ValueError as error:
        names = ", ".join(known.value for known in AutoresetMode)
        raise refuse("DrillRig", "autoreset_mode", repr(mode), "", names) from error
