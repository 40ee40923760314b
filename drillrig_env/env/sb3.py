"""`DrillRig-v0` as a Stable-Baselines3 `VecEnv`, so that agents train at the batch core's speed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.error import ResetNeeded

from drillrig_env.env.actions import check_actions
from drillrig_env.env.attributes import set_for_all
from drillrig_env.env.generators import check_seed
from drillrig_env.env.many import ManyRigs
from drillrig_env.env.pins import options_of, pins_of
from drillrig_env.env.privileged import observation_space, seen_by
from drillrig_env.env.task import TaskLike
from drillrig_env.extras import missing
from drillrig_env.parameters import refuse

try:
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import VecEnv
    from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvObs, VecEnvStepReturn
except ImportError as error:
    raise missing("training", "Stable-Baselines3", "agents") from error

_FOR_ALL = ("change", "set_target")
"""Methods that are for all rigs alike."""


class DrillRigVecEnv(ManyRigs, VecEnv):
    """N rigs of `DrillRig-v0` for Stable-Baselines3; arguments as for `DrillRigVectorEnv`.

    `num_envs` is N; `threads` is how many compute (default: all cores), and `render_mode` "rgb_array" or None.

    Rig i with the seed s (an argument, or `seed(s)`) is the single environment with the seed s + i,
    but for rewards, which SB3 holds in float32. An episode's last step begins the next episode; its
    info holds what a `Monitor` would report ("episode": reward r, length l), `is_success`, the
    `terminal_observation` and "TimeLimit.truncated". Other steps have an empty info, since a
    dictionary for every rig would cost more than the physics; `core.info()` has it as arrays.

    What `set_options` pins holds for every episode that begins from then on, those of automatic resets too, until
    `set_options` is called again (without argument: nothing is pinned). In Stable-Baselines3's own vector
    environments it holds for the next `reset` alone, and so for one episode of many.

    >>> import numpy as np
    >>> env = DrillRigVecEnv(8, seed=0, duration=2.0)
    >>> env.reset().shape
    (8, 12)
    >>> observations, rewards, dones, infos = env.step(np.zeros((8, 1), dtype=np.float32))
    >>> rewards.shape, dones.shape, len(infos)
    ((8,), (8,), 8)
    """

    def __init__(
        self,
        num_envs: int = 1,
        task: TaskLike = None,
        *,
        seed: int | None = None,
        threads: int | None = None,
        render_mode: str | None = None,
        **fields: Any,
    ) -> None:
        self._make(num_envs, task, threads, render_mode, fields)
        super().__init__(
            len(self.core),
            observation_space(len(self.core.sensors.channels), self.core.critic),
            spaces.Box(-1.0, 1.0, (1,), np.float32),
        )
        self._returns = np.zeros(self.num_envs)
        self._empty: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        self._rates = np.zeros((self.num_envs, 1), dtype=np.float32)
        self._everywhere = np.arange(self.num_envs)
        self.seed(seed)

    def set_options(self, options: list[dict[str, Any]] | dict[str, Any] | None = None) -> None:
        """Pin what episodes would draw, from now on: one dictionary for all rigs, or a list of one for each.

        Raises `ValueError` for anything else; what a dictionary holds is checked when an episode begins.
        """
        each = options if isinstance(options, list) else [options] * self.num_envs
        if len(each) != self.num_envs:
            raise refuse("set_options", "number of dictionaries", len(each), "", f"one for all, or {self.num_envs}")
        for one in each:
            options_of(one)
        super().set_options(options)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed rig i with `seed` + i, from the next reset on; None takes fresh entropy."""
        first = check_seed(seed)
        return [self._generators.seed(i, None if first is None else first + i) for i in range(self.num_envs)]

    def reset(self) -> VecEnvObs:
        """Begin an episode in every rig; `set_options` has pinned what it pins."""
        self._begin_pinned(self._everywhere)
        self._reset_seeds()
        return self.core.seen

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions, shape (num_envs, 1), for `step_wait`."""
        self._rates = check_actions(actions, self.num_envs)

    def step_wait(self) -> VecEnvStepReturn:
        """Step all rigs; rigs whose episode ends begin the next one."""
        core = self.core
        if core.ended.any():
            raise ResetNeeded("no episode has begun; call reset() first")
        self._advance(self._rates)
        rewards = core.episodes["reward"].astype(np.float32)
        self._returns += core.episodes["reward"]
        ended = core.ended
        infos = self._empty
        if ended.any():
            infos = [{} for _ in range(self.num_envs)]
            success = core.mitigated
            final = core.seen
            indices = np.flatnonzero(ended)
            for i in indices:
                infos[i] = {
                    "terminal_observation": seen_by(final, i),
                    "TimeLimit.truncated": True,
                    "is_success": bool(success[i]),
                    "episode": {"r": float(self._returns[i]), "l": core.steps},
                }
            self._begin_pinned(indices)
        return core.seen, rewards, ended, infos

    def close(self) -> None:
        """Nothing to release."""

    def _own_state(self) -> dict[str, Any]:
        return {"returns": self._returns.copy(), "options": self._options}

    def _take_own_state(self, own: Any) -> None:
        self._returns[:], self._options = own["returns"], own["options"]

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute of this environment, once for each of `indices`."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute for all rigs, which share everything but their draws; `scenario`, for example.

        Raises `AttributeError` for what cannot be changed (see `change`) and `ValueError` for some rigs only.
        """
        self._check_all("set_attr", attr_name, indices)
        set_for_all(self, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any) -> list[Any]:
        """Call a method of this environment once for each of `indices`.

        `method_name` is its name; `args` and `kwargs` go to it.

        Raises `ValueError` for `change` and `set_target` for some rigs only.
        """
        if method_name in _FOR_ALL:
            self._check_all("env_method", method_name, indices)
        return [getattr(self, method_name)(*args, **kwargs) for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: VecEnvIndices = None) -> list[bool]:
        """No rig is wrapped, but infos hold what a `Monitor` would report.

        `wrapper_class` is a wrapper, `indices` are the rigs that are asked for.
        """
        return [wrapper_class is Monitor for _ in self._get_indices(indices)]

    def get_images(self) -> Iterable[np.ndarray | None]:  # type: ignore[override]
        """The rigs as RGB, a frame of shape (540, 960, 3) each, in the mode "rgb_array"; otherwise None for each."""
        return [None] * self.num_envs if self._pictures is None else self._pictures.frames()

    def _check_all(self, where: str, name: str, indices: VecEnvIndices) -> None:
        """Raise `ValueError` where not all rigs are meant."""
        if len(list(self._get_indices(indices))) != self.num_envs:
            each = "; an array has a target for each" if name == "set_target" else ""
            raise ValueError(f"{where}: {name} for some rigs only is not allowed; allowed: for all{each}")

    def _begin_pinned(self, rigs: npt.NDArray[np.intp]) -> None:
        """Begin an episode in the rigs of these numbers, with what `set_options` has pinned."""
        self._returns[rigs] = 0.0
        pinned = np.array([id(self._options[rig] or None) for rig in rigs])  # all that pin nothing are of one kind
        for one in dict.fromkeys(pinned.tolist()):
            some = rigs[pinned == one]
            pins = pins_of(self._options[some[0]], some, self.num_envs)
            self._begin(some, pins)
