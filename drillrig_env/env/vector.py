"""`DrillRig-v0` as a native Gymnasium vector environment: N rigs, one compiled call a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from drillrig_env.drive import DriveLike
from drillrig_env.env.core import EpisodeBatch, Observations
from drillrig_env.env.generators import EpisodeGenerators
from drillrig_env.env.kernel import SLEW_LIMIT
from drillrig_env.env.reward import Reward
from drillrig_env.env.scenario import Scenario
from drillrig_env.env.sensors import LIMIT
from drillrig_env.rig import RigLike

Step = tuple[Observations, npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.bool_], dict[str, Any]]


class DrillRigVectorEnv(VectorEnv[Observations, npt.NDArray[np.float32], np.ndarray]):
    """N rigs of `DrillRig-v0` side by side; `DrillRigEnv` describes spaces, reward and arguments.

    Rig i with the seed s is, bit for bit, the single environment with the seed s + i, whatever the
    number of rigs and `threads` (default: all cores).

    `autoreset_mode` is Gymnasium's: the step after an episode's last begins the next one (NEXT_STEP,
    the default), or that last step itself does and leaves `final_obs` and `final_info` (SAME_STEP),
    or `reset(options={"reset_mask": mask})` does (DISABLED).
    """

    def __init__(
        self,
        num_envs: int = 1,
        rig: RigLike = None,
        scenario: str | Mapping[str, Any] | Scenario = "default",
        sensors: str | Sequence[str] = "state",
        reward: Reward | Mapping[str, Any] | None = None,
        slew_limit: float = SLEW_LIMIT,
        duration: float = 60.0,
        threads: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        *,
        noise: float | Mapping[str, float] | None = None,
        delay: int | tuple[int, int] | None = None,
        drive: DriveLike = None,
    ) -> None:
        if render_mode is not None:
            raise ValueError(f"render_mode = {render_mode!r} is not known; allowed: None")
        self.core = EpisodeBatch(
            num_envs,
            rig,
            scenario,
            sensors,
            reward,
            slew_limit,
            duration,
            threads,
            noise=noise,
            delay=delay,
            drive=drive,
        )
        self.sensors = self.core.sensors
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {"render_modes": [], "autoreset_mode": self.autoreset_mode}
        self.single_action_space = spaces.Box(-1.0, 1.0, (1,), np.float32)
        self.single_observation_space = spaces.Box(-LIMIT, LIMIT, (len(self.sensors.channels),), np.float32)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._generators = EpisodeGenerators(num_envs)
        self._everywhere = np.ones(num_envs, dtype=np.bool_)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Begin an episode in every rig, or in those of `options["reset_mask"]`.

        `seed` s gives rig i the seed s + i; a list gives each its own. `options` are those of the
        single environment, with one number for all or one a rig that is reset.
        """
        self._seed(seed)
        pins = dict(options or {})
        mask = np.asarray(pins.pop("reset_mask", self._everywhere))
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            raise ValueError(f"reset_mask of shape {mask.shape} and {mask.dtype}; allowed: ({self.num_envs},) and bool")
        begun = np.flatnonzero(mask)
        if len(begun):
            self.core.reset(begun, self._generators.uniforms(begun), pins)
        info = self._info()
        info["start"], info["_start"] = np.full(self.num_envs, "", dtype="<U10"), mask
        info["start"][begun] = self.core.starts(begun)
        return self.core.observations, info

    def step(self, actions: npt.NDArray[np.float32]) -> Step:
        """Step all rigs; `actions` of shape (num_envs, 1), clipped to +-1. NaN is a `ValueError`."""
        core = self.core
        rates = check_actions(actions, self.num_envs)
        over = core.ended
        if over.any() and (self.autoreset_mode != AutoresetMode.NEXT_STEP or not self._generators.seeded):
            raise ResetNeeded(f"the episode of rig {int(np.argmax(over))} is over, or none has begun; reset it first")
        core.step(rates)
        rewards = core.episodes["reward"].copy()
        if over.any():
            begun = np.flatnonzero(over)
            core.reset(begun, self._generators.uniforms(begun))
            rewards[begun] = 0.0
        truncated = core.ended
        info = self._info()
        if truncated.any():
            info["is_success"], info["_is_success"] = core.mitigated & truncated, truncated
            if self.autoreset_mode == AutoresetMode.SAME_STEP:
                self._begin_next(truncated, info)
        return core.observations, rewards, np.zeros(self.num_envs, dtype=np.bool_), truncated, info

    def _begin_next(self, ended: npt.NDArray[np.bool_], info: dict[str, Any]) -> None:
        """Keep the last observations and info of ended episodes, and begin the next ones."""
        final_info = dict(info)
        final = self.core.observations
        begun = np.flatnonzero(ended)
        self.core.reset(begun, self._generators.uniforms(begun))
        info.clear()
        info.update(self._info())
        info["final_obs"], info["_final_obs"] = final, ended
        info["final_info"], info["_final_info"] = final_info, ended

    def _info(self) -> dict[str, Any]:
        info = self.core.info()
        return {**info, **{f"_{name}": self._everywhere for name in info}}

    def _seed(self, seed: int | Sequence[int | None] | None) -> None:
        begun = self._generators.seeded
        if seed is None and begun:
            return
        if seed is None:
            seeds: list[int | None] = [None] * self.num_envs
        else:
            seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds are not allowed; allowed: one number, or {self.num_envs}")
        for rig, one in enumerate(seeds):
            if one is not None or not begun:
                self._generators.seed(rig, one)


def check_actions(actions: npt.NDArray[np.float32], rigs: int) -> npt.NDArray[np.float32]:
    """Actions as float32 of shape (rigs, 1). `ValueError` for another shape or NaN, which names the rig."""
    rates = np.ascontiguousarray(actions, dtype=np.float32)
    if rates.shape != (rigs, 1):
        raise ValueError(f"actions of shape {rates.shape} are not allowed; allowed: shape ({rigs}, 1), -1 to 1")
    bad = np.isnan(rates)
    if bad.any():
        raise ValueError(f"action = nan for rig {int(np.argmax(bad))} is not allowed; allowed: a number from -1 to 1")
    return rates
