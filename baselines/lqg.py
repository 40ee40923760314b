"""LQG: a Kalman filter on whatever the sensors show, and a linear quadratic feedback to the speed reference.

Active damping keeps steady rotation stable below the critical speed as well; what is hard is to get there
from stick-slip, where the slew limit saturates and the friction is anything but linear.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from baselines.counted import CountedLaw
from baselines.linear_rig import LEVEL, MEASURED, SIZE, LinearRig, applied, gain_of, without_friction
from baselines.tuned import tuned_values
from drillrig_env.arrays import FloatArray
from drillrig_env.env.sensors import LONGEST_DELAY
from drillrig_env.fleet import side_by_side
from drillrig_env.friction import Friction
from drillrig_env.model import STATE_NAMES, frictionless_state
from drillrig_env.parameters import refuse
from drillrig_env.rig import RigLike
from drillrig_env.scales import LARGEST_REFERENCE

SLOPES = np.geomspace(0.002, 0.25, 32)
"""Friction slopes s that gains are designed for, N m s/rad: up to 20 times what the bare drive can bear."""

STEP, OFFSET, SHAKING, PAST = SIZE, SIZE + 1, SIZE + 2, SIZE + 3
"""Columns of memory after the estimate: steps done, set point less target, mean square twist rate, past references."""

TWIST_RATE_TIME = 2.5  # s, of that mean; about one stick-slip period
_LEAST_NOISE = 0.01  # of an exact channel, as a share of its scale
_FIRST_SPREAD = (0.3, 0.8, 3.0, 3.0, 0.5, 0.3, 0.1)  # of the states at first, for all that is known
FIRST_LEVEL, _FIRST_LEVEL_SPREAD = 0.3, 0.5  # of the friction torque, N m
HIGHEST_SET_POINT = LARGEST_REFERENCE - 2.0  # rad/s; room for the feedback
WAIT = 3.0  # s, before the first verdict on shaking


class LQG(CountedLaw):
    """Kalman filter and LQ feedback about a set point that is raised while the rig shakes; told nothing.

    The design model (`baselines.linear_rig`) is the sampled linear rig with the friction torque as a level that
    wanders, a fluctuation and a slope -s. From what the channels show, in the light of their ordinary noise and of the
    delay that the sensors are known to have, the filter estimates states and torques; it is fed the speed reference
    as it really was, so that slew and range limits do not wind it up. The feedback minimises squares of the
    bit speed's error, the rate of the upper twist and the change of omega_ref (Kwakernaak & Sivan, Linear Optimal
    Control Systems, 1972). In steady rotation it vanishes: the bit turns at the set point, whatever the friction.

    Two things are not textbook. The gains are scheduled: s is `share` times the slope that the
    coefficients of `friction` and the estimated level give at the set point. And as long as the running twist rate
    (bit less top speed, over the set point) is above `shaking`, the set point rises at `rise` (rad/s^2)
    above the target: friction falls less at more speed, and the feedback wins there. Once calm it comes
    down at `ease` (rad/s^2), actively damped all the way.

    `level` (N m in a second's walk), `fluctuation` (N m) and `forgotten` (s) describe the friction torque
    to the filter; `twisting` and `effort` are weights of the feedback. `delay` in control steps is that of
    the sensors if None. The rest is tuned by `python -m baselines.tune lqg` on training seeds.
    """

    any_of = (("bit_speed", "top_speed"), ("twist_23", "top_speed"), ("string_torque",), ("current", "top_speed"))
    memory = PAST + LONGEST_DELAY + 1
    tuned: ClassVar[dict[str, tuple[float, float]]] = {
        "twisting": (0.0, 40.0),
        "effort": (1.0, 60.0),
        "share": (0.2, 2.0),
        "level": (0.005, 0.2),
        "fluctuation": (0.005, 0.5),
        "shaking": (0.1, 0.5),
        "ease": (0.1, 1.0),
    }
    tuned_values: ClassVar[dict[str, dict[str, float]]] = tuned_values("lqg")

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        twisting: float | None = None,
        effort: float | None = None,
        share: float | None = None,
        level: float | None = None,
        fluctuation: float | None = None,
        shaking: float | None = None,
        ease: float | None = None,
        forgotten: float = 6.0,
        rise: float = 2.0,
        delay: int | None = None,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        gains = self._given_or_tuned(
            twisting=twisting,
            effort=effort,
            share=share,
            level=level,
            fluctuation=fluctuation,
            shaking=shaking,
            ease=ease,
        )
        self.share, self.shaking, self.rise, self.ease = gains["share"], gains["shaking"], rise, gains["ease"]
        self.delay = self.sensors.delay if delay is None else delay
        if not 0 <= self.delay <= LONGEST_DELAY:
            raise refuse("LQG", "delay", self.delay, "control steps", f"0 to {LONGEST_DELAY}")
        self.measured = tuple(name for name in MEASURED if name in self.sensors.names)
        models = [
            LinearRig(plant, slope, forgotten, self.period, self.plant) for plant in self.plants for slope in SLOPES
        ]
        channels = {channel.name: channel for channel in self.sensors.channels}
        shown = [channels[name] for name in self.measured]
        noise = np.array(
            [max(channel.noise, _LEAST_NOISE * channel.scale) / self.unit(channel.name) for channel in shown]
        )
        self._design(models, noise, gains)

    def _design(self, models: list[LinearRig], noise: FloatArray, gains: Mapping[str, float]) -> None:
        """Model, filter and feedback for every slope of every rig, one rig after another.

        And for every rig the gain that makes an estimate of the first measurement.
        """
        self._rigs = side_by_side(self.plants)
        self.transition = np.stack([model.transition for model in models])
        self.by_reference = np.stack([model.input for model in models])
        self.filter_gains = np.stack(
            [model.filter_gain(self.measured, noise, gains["level"], gains["fluctuation"]) for model in models]
        )
        self.feedback = np.stack([model.feedback_gain(gains["twisting"], gains["effort"]) for model in models])
        each = models[:: len(SLOPES)]
        self.per_speed = np.stack([model.per_speed for model in each])
        self.per_level = np.stack([model.per_level for model in each])
        self.rows = np.stack([[model.measurement(name)[0] for name in self.measured] for model in each])
        self.through = np.array([[model.measurement(name)[1] for name in self.measured] for model in each])
        first = []
        for rows, per_level in zip(self.rows, self.per_level, strict=True):
            by_level = _FIRST_LEVEL_SPREAD * per_level
            spread = np.diag([*np.square(_FIRST_SPREAD), 0.0, 0.0, 0.01]) + np.outer(by_level, by_level)
            first.append(gain_of(spread, rows, np.diag(noise**2)))
        self.first_gain = np.stack(first)

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The reference so far and the change that the feedback asks for."""
        set_point = seen["speed_target"] + memory[:, OFFSET]
        reference = seen["speed_reference"] - set_point
        places = self.places(privileged)
        gains = self._scheduled(memory[:, LEVEL], set_point, self._law(privileged))
        z = self._estimate(seen, memory, set_point, reference, gains, places)
        move = self._move_set_point(z, memory, set_point, gains, places)
        z[:, :7] -= self.per_speed[places] * move[:, None]
        z[:, LEVEL] -= SLOPES[gains] * move
        deviation = np.column_stack([z - z[:, LEVEL, None] * self.per_level[places], reference - move])
        change = -(self.feedback[_entries(places, gains)] * deviation).sum(axis=-1)
        return np.asarray(seen["speed_reference"] + move + change)

    def estimate(self, state: tuple[np.ndarray, ...], speed_target: FloatArray) -> tuple[FloatArray, FloatArray]:
        """States, shape (n, 7), and friction level T_0 (N m), shape (n,), from the state that `predict` returned.

        They are those of the last measurement, which is as old as the sensors' delay; `speed_target` in rad/s.
        """
        memory = state[0]
        set_point = np.asarray(speed_target) / self.unit("speed_target") + memory[:, OFFSET]
        units = np.array([self.unit(name) for name in STATE_NAMES])
        rigs = self._rigs[self.places(self._privileged_values)]
        states = frictionless_state(rigs, set_point) + memory[:, :7]
        return states * units, memory[:, LEVEL] * self.unit("string_torque")

    def _law(self, privileged: Mapping[str, FloatArray]) -> Friction:
        """The law by which friction is taken to fall with speed, at any force: the nominal one."""
        return self.nominal_friction

    def _scheduled(self, level: FloatArray, speed: FloatArray, law: Friction) -> np.ndarray:
        """Which of SLOPES is nearest to `share` times that of the law with the torque `level` at `speed`."""
        force = np.maximum(level, 0.0) / np.asarray(law.torque(self.plant, speed))
        slope = -self.share * force * np.asarray(law.slope(self.plant, speed))
        ratio = np.log(SLOPES[1] / SLOPES[0])
        nearest = np.rint(np.log(np.maximum(slope, SLOPES[0]) / SLOPES[0]) / ratio)
        return np.asarray(np.minimum(nearest, len(SLOPES) - 1).astype(int))

    def _estimate(
        self,
        seen: Mapping[str, FloatArray],
        memory: FloatArray,
        set_point: FloatArray,
        reference: FloatArray,
        gains: np.ndarray,
        places: npt.NDArray[np.intp],
    ) -> FloatArray:
        """Filter the measurement, which is `delay` steps old, and reckon on from there with the known references."""
        done, past = memory[:, STEP].copy(), memory[:, PAST : PAST + self.delay + 1]
        past[:, :-1] = past[:, 1:]
        past[:, -1] = reference
        past[done == 0] = reference[done == 0, None]
        first, waiting = (done == 0)[:, None], ((done > 0) & (done <= self.delay))[:, None]
        design, rigs = _entries(places, gains), self._rigs[places]
        transition, by_reference = self.transition[design], self.by_reference[design]
        shown = [seen[name] - without_friction(rigs, self.plant, name, set_point) for name in self.measured]
        expected = np.where(
            first,
            FIRST_LEVEL * self.per_level[places],
            applied(transition, memory[:, :SIZE]) + by_reference * past[:, :1],
        )
        news = np.stack(shown, axis=-1) - applied(self.rows[places], expected) - self.through[places] * past[:, :1]
        z = expected + np.where(first, applied(self.first_gain[places], news), applied(self.filter_gains[design], news))
        z = np.where(waiting, memory[:, :SIZE], z)  # the first measurement is all that is seen until the second arrives
        memory[:, :SIZE] = z
        memory[:, STEP] += 1.0
        for age in range(self.delay, 0, -1):
            known = (done >= age)[:, None]
            z = np.where(known, applied(transition, z) + by_reference * past[:, [self.delay + 1 - age]], z)
        return z.copy()

    def _move_set_point(
        self,
        z: FloatArray,
        memory: FloatArray,
        set_point: FloatArray,
        gains: np.ndarray,
        places: npt.NDArray[np.intp],
    ) -> FloatArray:
        """Up while shaking, otherwise down to the target; returns the move (rad/s) and puts the memory about it."""
        is_shaking = np.sqrt(memory[:, SHAKING]) / set_point > self.shaking
        memory[:, SHAKING] += self.followed(TWIST_RATE_TIME) * ((z[:, 2] - z[:, 4]) ** 2 - memory[:, SHAKING])
        rate = np.where(is_shaking, self.rise, -self.ease)
        wanted, time = rate * self.period, memory[:, STEP] * self.period
        move = move_of_set_point(wanted, set_point, memory[:, OFFSET], time, HIGHEST_SET_POINT)
        memory[:, OFFSET] += move
        memory[:, :7] -= self.per_speed[places] * move[:, None]
        memory[:, LEVEL] -= SLOPES[gains] * move
        memory[:, PAST : PAST + self.delay + 1] -= move[:, None]
        return move


def move_of_set_point(
    wanted: FloatArray, set_point: FloatArray, offset: FloatArray, time: FloatArray, highest: float
) -> FloatArray:
    """By what a set point moves that is to move by `wanted`, and is `offset` above the target; all rad/s, shape (n,).

    No lower than the target, no higher than `highest`, and not before there is a verdict on shaking; `time` is that
    since the episode began, s.
    """
    move = np.clip(wanted, -offset, np.maximum(highest - set_point, 0.0))
    move[time < WAIT] = 0.0
    return np.asarray(move)


def _entries(places: npt.NDArray[np.intp], gains: np.ndarray) -> npt.NDArray[np.intp]:
    """Where the design for some rigs and slopes is among those for all."""
    return np.asarray(places * len(SLOPES) + gains)
