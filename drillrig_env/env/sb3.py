"""`DrillRig-v0` as a Stable-Baselines3 `VecEnv`, so that agents train at the batch core's speed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces

from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import EpisodeGenerators
from drillrig_env.env.sensors import LIMIT
from drillrig_env.env.vector import check_actions
from drillrig_env.extras import missing

try:
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import VecEnv
    from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvObs, VecEnvStepReturn
except ImportError as error:
    raise missing("training", "Stable-Baselines3", "agents") from error


class DrillRigVecEnv(VecEnv):
    """N rigs of `DrillRig-v0` for Stable-Baselines3; keyword arguments as for `DrillRigEnv`.

    Rig i with the seed s (an argument, or `seed(s)`) is the single environment with the seed s + i,
    but for rewards, which SB3 holds in float32. An episode's last step begins the next episode; its
    info holds what a `Monitor` would report ("episode": reward r, length l), `is_success`, the
    `terminal_observation` and "TimeLimit.truncated". Other steps have an empty info, since a
    dictionary for every rig would cost more than the physics; `core.info()` has it as arrays.
    """

    core: EpisodeBatch

    def __init__(self, num_envs: int = 1, seed: int | None = None, threads: int | None = None, **kwargs: Any) -> None:
        self.core = EpisodeBatch(num_envs, threads=threads, **kwargs)
        self.render_mode = None
        channels = len(self.core.sensors.channels)
        super().__init__(
            num_envs,
            spaces.Box(-LIMIT, LIMIT, (channels,), np.float32),
            spaces.Box(-1.0, 1.0, (1,), np.float32),
        )
        self._returns = np.zeros(num_envs)
        self._empty: list[dict[str, Any]] = [{} for _ in range(num_envs)]
        self._rates = np.zeros((num_envs, 1), dtype=np.float32)
        self._generators = EpisodeGenerators(num_envs)
        self.seed(seed)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed rig i with `seed` + i, from the next reset on; None takes fresh entropy."""
        return [self._generators.seed(i, None if seed is None else seed + i) for i in range(self.num_envs)]

    def reset(self) -> VecEnvObs:
        """Begin an episode in every rig; `set_options` has pinned what it pins."""
        pins = self._options[0]
        if any(options != pins for options in self._options):
            raise ValueError(
                "set_options: options that differ between rigs are not allowed; allowed: one dictionary for all"
            )
        everywhere = np.arange(self.num_envs)
        self.core.reset(everywhere, self._generators.uniforms(everywhere), pins)
        self._reset_seeds()
        self._reset_options()
        self._returns[:] = 0.0
        return self.core.observations

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions, shape (num_envs, 1), for `step_wait`."""
        self._rates = check_actions(actions, self.num_envs)

    def step_wait(self) -> VecEnvStepReturn:
        """Step all rigs; rigs whose episode ends begin the next one."""
        core = self.core
        core.step(self._rates)
        rewards = core.episodes["reward"].astype(np.float32)
        self._returns += core.episodes["reward"]
        ended = core.ended
        infos = self._empty
        if ended.any():
            infos = [{} for _ in range(self.num_envs)]
            success = core.mitigated
            final = core.observations
            indices = np.flatnonzero(ended)
            for i in indices:
                infos[i] = {
                    "terminal_observation": final[i],
                    "TimeLimit.truncated": True,
                    "is_success": bool(success[i]),
                    "episode": {"r": float(self._returns[i]), "l": core.steps},
                }
            self._returns[indices] = 0.0
            core.reset(indices, self._generators.uniforms(indices))
        return core.observations, rewards, ended, infos

    def close(self) -> None:
        """Nothing to release."""

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute of this environment, once for each of `indices`."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute for all rigs; rigs share everything but their draws."""
        if len(list(self._get_indices(indices))) != self.num_envs:
            raise ValueError(f"set_attr: {attr_name} for some rigs only is not allowed; allowed: for all")
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any) -> list[Any]:
        """Call a method of this environment once for each of `indices`."""
        return [getattr(self, method_name)(*args, **kwargs) for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: VecEnvIndices = None) -> list[bool]:
        """No rig is wrapped, but infos hold what a `Monitor` would report."""
        return [wrapper_class is Monitor for _ in self._get_indices(indices)]

    def get_images(self) -> Iterable[np.ndarray | None]:  # type: ignore[override]
        """No rendering yet."""
        return [None] * self.num_envs
