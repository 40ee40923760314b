"""The batch core: reset some rigs, step all rigs. The three variants of the environment stand on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import exp
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.drive import Drive, DriveLike
from drillrig_env.env.kernel import (
    CONTROL_PERIOD,
    EPISODE,
    SETTINGS,
    SETTLING_STEPS,
    SLEW_LIMIT,
    observe_episodes,
    settle_episodes,
    step_episodes,
)
from drillrig_env.env.reward import TERMS, Reward
from drillrig_env.env.scenario import REST, STARTS, STEADY, STICK_SLIP, Draws, Scenario, check_pins
from drillrig_env.env.sensors import LONGEST_DELAY, TORQUE_DEVIATION_TIME, TORQUE_MEAN_TIME, Sensors
from drillrig_env.friction import Friction
from drillrig_env.jit.compiled import bound
from drillrig_env.jit.threads import check_threads, over_slices
from drillrig_env.model import frictionless_state, steady_state, torque_into_string, wound_up
from drillrig_env.parameters import POSITIVE, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stepper.tables import SAMPLES, ladder
from drillrig_env.verdict import WINDOW, is_mitigated

Observations = npt.NDArray[np.float32]
_ALL = slice(None)


class EpisodeBatch:
    """`num_rigs` rigs in their episodes: the rules of `DrillRig-v0`, in one place.

    `rigs` is an array of records (see `drillrig_env.env.kernel.EPISODE`) with the state of every rig and
    what its last control step showed. Rigs share `rig`, and each has its own friction and generator.
    `DrillRigEnv` describes the arguments. Raises `ValueError` for one that is not allowed.
    """

    def __init__(
        self,
        num_rigs: int = 1,
        rig: RigLike = None,
        scenario: str | Mapping[str, Any] | Scenario = "default",
        sensors: str | Sequence[str] = "state",
        reward: Reward | Mapping[str, Any] | None = None,
        slew_limit: float = SLEW_LIMIT,
        duration: float = 60.0,
        threads: int | None = None,
        *,
        noise: float | Mapping[str, float] | None = None,
        delay: int | tuple[int, int] | None = None,
        drive: DriveLike = None,
    ) -> None:
        if num_rigs < 1:
            raise refuse("DrillRig", "number of rigs", num_rigs, "", ">= 1")
        if not POSITIVE.holds(slew_limit):
            raise refuse("DrillRig", "slew_limit", slew_limit, "rad/s^2", POSITIVE)
        steps = round(duration / CONTROL_PERIOD)
        if steps < 1 or abs(steps * CONTROL_PERIOD - duration) > 1e-6:
            raise refuse("DrillRig", "duration", duration, "s", f"a multiple of {CONTROL_PERIOD}")
        self.rig = Rig.of(rig)
        self.scenario = Scenario.named(scenario)
        self.sensors = Sensors.named(sensors)
        self.reward = reward if isinstance(reward, Reward) else Reward(**(reward or {}))
        self.duration = duration
        self.steps = steps
        self.slew_limit = slew_limit
        self.threads = check_threads(threads)
        self.delay = check_delay(self.sensors.delay if delay is None else delay)
        self.drive = Drive.of(drive)
        self.episodes = np.zeros(num_rigs, dtype=EPISODE)
        self.episodes["step"] = steps  # no episode has begun
        channels = len(self.sensors.channels)
        self.observations: Observations = np.zeros((num_rigs, channels), dtype=np.float32)
        slots = self.delay[1] + 1 if self.delay[1] else 0
        self._past = np.zeros((num_rigs, slots, channels), dtype=np.float32)
        self._tables = ladder(self.rig, CONTROL_PERIOD, drive=self.drive)
        self._start_tables = ladder(self.rig, CONTROL_PERIOD)
        self._layout = self.sensors.layout(noise)
        self._settings = np.zeros(1, dtype=SETTINGS)
        loop = self.drive or Drive.of_rig(self.rig)
        self._settings[0] = (
            self.rig.r_1,
            self.rig.omega_s,
            slew_limit * CONTROL_PERIOD,
            loop.k_p,
            loop.k_i,
            loop.compensation(self.rig),
            1.0 - exp(-CONTROL_PERIOD / SAMPLES / self.reward.time_constant),
            1.0 - exp(-CONTROL_PERIOD / TORQUE_MEAN_TIME),
            1.0 - exp(-CONTROL_PERIOD / TORQUE_DEVIATION_TIME),
            self.reward.variance,
            self.reward.tracking,
            self.reward.action,
            self.reward.variance_shape == "absolute",
            self.reward.tracking_shape == "absolute",
            steps,
            self.window_start,
        )

    def __len__(self) -> int:
        return len(self.episodes)

    @property
    def window_start(self) -> int:
        """The control step with which the window of the final verdict begins."""
        return max(0, self.steps - round(WINDOW / CONTROL_PERIOD))

    @property
    def ended(self) -> npt.NDArray[np.bool_]:
        """Which episodes are over (or never began); shape (n,)."""
        return np.asarray(self.episodes["step"] >= self.steps)

    @property
    def mitigated(self) -> npt.NDArray[np.bool_]:
        """The verdict on the window so far: at the end of an episode, whether it was mitigated; shape (n,)."""
        done = np.maximum(self.episodes["step"] - self.window_start, 1)
        mean = self.episodes["window_sum"] / done
        verdict = is_mitigated(
            self.episodes["window_lowest"], self.episodes["window_highest"], mean, self.episodes["speed_target"]
        )
        return np.asarray(verdict)

    def reset(
        self,
        indices: npt.NDArray[np.intp],
        uniforms: FloatArray,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        """Begin a new episode in the rigs at `indices`, from the uniform numbers that it draws, (n, UNIFORMS).

        `options` pins what would be drawn, as numbers or with one entry for each of `indices`.
        Like `step` it leaves earlier `observations` as they were.
        """
        pins = check_pins(options, len(indices), self.duration)
        fresh = self._begin(self.scenario.draw(uniforms, self.duration, pins))
        self.episodes[indices] = fresh
        seen = np.empty((len(indices), self.observations.shape[1]), dtype=np.float32)
        past = np.empty((len(indices), *self._past.shape[1:]), dtype=np.float32)
        observe_episodes(fresh, self._layout, past, seen)
        self._past[indices] = past
        self.observations = self.observations.copy()
        self.observations[indices] = seen

    def step(self, actions: npt.NDArray[np.float32]) -> None:
        """Step every rig whose episode is not over; `actions` of shape (n, 1), finite, clipped to +-1.

        `observations` is a new array after each step, so that earlier ones keep their values.
        """
        observations = np.empty_like(self.observations)
        if self.threads == 1 or len(self.episodes) == 1:
            self._step(_ALL, actions, observations)
        else:
            over_slices(lambda part: self._step(part, actions, observations), len(self.episodes), self.threads)
        self.observations = observations

    def bound_step(self, actions: npt.NDArray[np.float32], observations: Observations) -> Callable[[], None]:
        """A call that steps every rig, each time from and into these arrays, and leaves `self.observations` alone.

        For a single rig it is twice as fast as `step`, where finding the kernel takes longer than the physics.
        """
        return bound(step_episodes, *self._arguments(_ALL, actions, observations))

    def _step(self, part: slice, actions: npt.NDArray[np.float32], observations: Observations) -> None:
        step_episodes(*self._arguments(part, actions, observations))

    def _arguments(self, part: slice, actions: npt.NDArray[np.float32], observations: Observations) -> tuple[Any, ...]:
        tables = self._tables
        return (
            self.episodes[part],
            actions[part],
            self._settings,
            tables.rungs,
            tables.sampling,
            tables.shift,
            self._layout,
            self._past[part],
            observations[part],
        )

    def info(self) -> dict[str, Any]:
        """What every step reports, by name, one entry a rig; `reward_terms` is a dictionary of its own."""
        episodes = self.episodes
        return {
            "bit_speed": episodes["state"][:, 2].copy(),
            "top_speed": episodes["state"][:, 4].copy(),
            "speed_reference": episodes["speed_reference"].copy(),
            "speed_target": episodes["speed_target"].copy(),
            "normal_force": episodes["normal_force"].copy(),
            "mu_s": episodes["mu_s"].copy(),
            "mu_k": episodes["mu_k"].copy(),
            "v_b": episodes["v_b"].copy(),
            "torque_into_string": episodes["torque_into_string"].copy(),
            "delay": episodes["delay"].copy(),
            "reward_terms": {name: episodes["terms"][:, i].copy() for i, name in enumerate(TERMS)},
        }

    def starts(self, indices: npt.NDArray[np.intp]) -> list[str]:
        """How the episodes of some rigs began: stick_slip only where their parameters have it."""
        return [STARTS[i] for i in self.episodes["start"][indices]]

    def _begin(self, draws: Draws) -> np.ndarray:
        """The records of n new episodes at their first moment."""
        friction, target = draws.friction, draws.speed_target
        contact = friction.as_array(len(target))
        fresh = np.zeros(len(target), dtype=EPISODE)
        for column, name in enumerate(("normal_force", "mu_s", "mu_k", "v_b")):
            fresh[name] = contact[:, column]
        fresh["speed_target"] = fresh["speed_reference"] = fresh["mean"] = target
        fresh["load_times"], fresh["load_forces"] = draws.load_times, draws.load_forces
        fresh["start"] = draws.start
        low, high = self.delay
        fresh["delay"] = low + np.minimum((draws.delay * (high - low + 1)).astype(int), high - low)
        fresh["noise"] = (draws.noise * 2.0**53).astype(np.uint64)
        fresh["state"][:, :7] = steady_state(self.rig, friction, target)
        rest = draws.start == REST
        fresh["state"][rest, :7] = frictionless_state(self.rig, 0.0)
        fresh["speed_reference"][rest] = fresh["mean"][rest] = 0.0
        fresh["string_torque"] = fresh["torque_mean"] = torque_into_string(self.rig, fresh["state"][:, :7])
        self._settle(fresh, np.flatnonzero(draws.start == STICK_SLIP), draws.phase)
        self._hand_over(fresh)
        return fresh

    def _hand_over(self, fresh: np.ndarray) -> None:
        """Give the rigs to the gains of the episode's drive, without a jump of the voltage."""
        state, rig, drive = fresh["state"], self.rig, self.drive
        error = fresh["speed_reference"] - state[:, 4]
        fresh["voltage"] = rig.k_p * error + rig.k_i * state[:, 6]
        if drive is not None:
            added = drive.compensation(rig) * state[:, 4]
            state[:, 6] = (fresh["voltage"] - added - drive.k_p * error) / drive.k_i

    def _settle(self, fresh: np.ndarray, indices: npt.NDArray[np.intp], phase: FloatArray) -> None:
        """Put the rigs at `indices`, now in steady rotation, onto their stick-slip cycle where they have one."""
        if len(indices) == 0:
            return
        cycling = fresh[indices]
        friction = Friction(*(cycling[name] for name in ("normal_force", "mu_s", "mu_k", "v_b")))
        cycling["state"][:, :7] = wound_up(self.rig, friction, cycling["speed_target"])
        phases = phase[indices]

        def settle(part: slice) -> None:
            tables = self._start_tables
            settle_episodes(cycling[part], phases[part], self._settings, tables.rungs, tables.sampling, tables.shift)

        over_slices(settle, len(indices), self.threads, SETTLING_STEPS)
        found = cycling["start"] == STICK_SLIP
        fresh[indices[found]] = cycling[found]
        fresh["start"][indices[~found]] = STEADY


def rate_action(wanted: FloatArray, reference: FloatArray, slew_limit: float) -> npt.NDArray[np.float32]:
    """The action, -1 to 1, that takes the speed reference towards a wanted one (rad/s) within a control step; (n, 1).

    `wanted` and `reference` have shape (n,); `slew_limit` is in rad/s^2.
    """
    rate = (wanted - reference) / (slew_limit * CONTROL_PERIOD)
    return np.asarray(np.clip(rate, -1.0, 1.0), dtype=np.float32)[:, None]


def check_delay(delay: int | tuple[int, int]) -> tuple[int, int]:
    """A delay in control steps as (lowest, highest). `ValueError` where it is no whole number or too long."""
    low, high = delay if isinstance(delay, Sequence) else (delay, delay)
    if not (int(low) == low and int(high) == high and 0 <= low <= high <= LONGEST_DELAY):
        raise refuse("DrillRig", "delay", delay, "control steps", f"whole, 0 to {LONGEST_DELAY}, or (low, high)")
    return int(low), int(high)
