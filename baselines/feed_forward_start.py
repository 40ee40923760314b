"""Feed-forward start: stop, and start again along a planned bit speed that no stick-slip can grow on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from baselines.counted import CountedLaw
from baselines.startup_plan import Haste, startup_plan
from baselines.string_torque import torque_from_twist
from baselines.tuned import tuned_values
from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.rig import RigLike
from drillrig_env.scales import LARGEST_REFERENCE
from drillrig_env.stability import critical_speed

_PHASE, _STEPS, _TORQUE, _SPEED, _SQUARE, _WOUND, _WINDING = range(7)
_HOLD, _STOP, _START = 0.0, 1.0, 2.0

_SMOOTHING_TIME = 0.5  # s, of torque and top speed
_UNREST_TIME = 2.5  # s, of its mean square deviation; about one stick-slip period
_STANDING = 0.05  # rad/s, of the speed reference
_LEAST_DROP = 0.06  # N m; noise alone must not look like shaking
_SETTLING = 3.0  # s from standstill of the drive until bit and collars have come to rest


class FeedForwardStart(CountedLaw):
    """Stop, then start along a plan, told the friction; back to a stop where it ends in stick-slip again.

    Aarsnes, di Meglio & Shor, Avoiding stick slip vibrations in drilling through startup trajectory
    design, J. Process Control 70 (2018): stick-slip on a start is set off by the release of the
    string; a bit speed that is planned through the unstable band and inverted for the speed of the top sets off
    none. Three phases:

    - stop: the reference goes to zero, and the string is left to come to rest, the bit stuck;
    - start: `baselines.startup_plan` winds the string up to break-loose and brings the bit to the speed
      max(omega*, omega_c + `beyond`) with at most `acceleration` (rad/s^2), which takes `build_up` (s) to build up;
    - hold: the reference goes on, at `ease` (rad/s^2), to max(omega*, omega_c + `margin`). If the running
      deviation of the torque into the string from its steady value exceeds `shaking` times
      N_1 r_1 (mu_s - mu_k), it stops again. An episode begins here, or with a stop if the rig stands.

    It is open-loop while it starts: below omega_c steady rotation is unstable, and it cannot hold the target by
    nature. At high loads the unstable band magnifies what the hold over a control step leaves of the plan.
    The bit is not seen: torque into the string will do, the drive's estimate of it too. Tuned by
    `python -m baselines.tune feed_forward_start --suites default` on training seeds.
    """

    channels = ("speed_reference", "speed_target", "top_speed")
    any_of = (("string_torque",), ("twist_23", "collar_speed"))
    privileged = ("normal_force", "mu_s", "mu_k", "v_b")
    memory = 7  # phase; steps in it; torque and top speed, smoothed; mean square deviation; both as the start begins

    tuned: ClassVar[dict[str, tuple[float, float]]] = {
        "acceleration": (0.5, 2.0),
        "build_up": (0.4, 2.0),
        "beyond": (0.3, 2.5),
        "margin": (0.05, 0.4),
        "ease": (0.03, 0.3),
    }
    tuned_values: ClassVar[dict[str, dict[str, float]]] = tuned_values("feed_forward_start")

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        acceleration: float | None = None,
        build_up: float | None = None,
        beyond: float | None = None,
        margin: float | None = None,
        ease: float | None = None,
        shaking: float = 0.5,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        self.check_chapters_law()
        values = self._given_or_tuned(
            acceleration=acceleration, build_up=build_up, beyond=beyond, margin=margin, ease=ease
        )
        self.haste = Haste(values["acceleration"], values["build_up"])
        self.beyond, self.margin, self.ease = values["beyond"], values["margin"], values["ease"]
        self.shaking = shaking
        self._stiffness = self.plant.k_1 * self.plant.k_2 / (self.plant.k_1 + self.plant.k_2)

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """Zero, the plan, or the speed to hold, by phase."""
        friction = Friction(**privileged)
        stable = np.asarray(critical_speed(self.plant, friction))
        floor = np.minimum(np.maximum(seen["speed_target"], stable + self.margin), LARGEST_REFERENCE)
        self._watch(seen, friction, memory)
        reference = seen["speed_reference"]
        speeds = np.minimum(np.maximum(floor, stable + self.beyond), LARGEST_REFERENCE)
        contacts = np.broadcast_to(friction.as_array(), (len(reference), 4))
        planned = np.zeros(len(reference))
        for i in np.flatnonzero(memory[:, _PHASE] == _START):
            force, mu_s, mu_k, v_b = contacts[i].tolist()
            plan = startup_plan(
                self.plant,
                (force, mu_s, mu_k, v_b),
                float(memory[i, _WOUND]),
                float(memory[i, _WINDING]),
                float(speeds[i]),
                self.haste,
                self.period,
            )
            step = int(memory[i, _STEPS])
            planned[i] = plan.references[min(step, len(plan.references) - 1)]
            if step >= len(plan.references) - 1:
                memory[i, [_PHASE, _STEPS, _SQUARE]] = _HOLD, 0.0, 0.0
        memory[:, _STEPS] += 1.0
        move = np.clip(floor - reference, -self.ease * self.period, self.ease * self.period)
        phase = memory[:, _PHASE]
        wanted = np.select([phase == _STOP, phase == _START], [np.zeros_like(planned), planned], reference + move)
        return np.asarray(np.maximum(wanted, 0.0))

    def _watch(self, seen: Mapping[str, FloatArray], friction: Friction, memory: FloatArray) -> None:
        """Smooth the torque, and go from hold to stop and from stop to start where it is time."""
        torque = self._torque(seen)
        reference, top = seen["speed_reference"], seen["top_speed"]
        fresh = memory[:, _TORQUE] == 0.0
        for column, value in ((_TORQUE, torque), (_SPEED, top)):
            memory[:, column] += np.where(fresh, 1.0, self.followed(_SMOOTHING_TIME)) * (value - memory[:, column])
        steady = np.asarray(friction.torque(self.plant, np.maximum(reference, self.plant.omega_s))) + self.plant.T_r2
        steady = steady + (self.plant.C_1 + self.plant.C_2) * reference
        memory[:, _SQUARE] += self.followed(_UNREST_TIME) * ((torque - steady) ** 2 - memory[:, _SQUARE])
        drop = self.plant.r_1 * np.asarray(friction.normal_force) * (np.asarray(friction.mu_s) - friction.mu_k)
        drop = np.maximum(drop, _LEAST_DROP)
        hold, stop = memory[:, _PHASE] == _HOLD, memory[:, _PHASE] == _STOP
        unrest = hold & (memory[:, _SQUARE] > (self.shaking * drop) ** 2)
        stopping = unrest | (hold & fresh & (reference < _STANDING))
        standing = stop & (reference < _STANDING) & (np.abs(memory[:, _SPEED]) < 2.0 * _STANDING)
        memory[:, _STEPS] = np.where(stop & ~standing, 0.0, memory[:, _STEPS])
        starting = standing & (memory[:, _STEPS] >= _SETTLING / self.period)
        memory[stopping, _PHASE], memory[starting, _PHASE] = _STOP, _START
        winding = np.maximum(memory[starting, _SPEED], 0.0)
        late = _SMOOTHING_TIME + self.sensors.delay * self.period
        memory[starting, _WOUND] = memory[starting, _TORQUE] - self.plant.T_r2 + self._stiffness * winding * late
        memory[starting, _WINDING] = winding
        memory[:, _STEPS] = np.where(stopping | starting, 0.0, memory[:, _STEPS])

    def _torque(self, seen: Mapping[str, FloatArray]) -> FloatArray:
        """Torque into the string (N m), from the drive's estimate or the upper shaft."""
        if "string_torque" in seen:
            return seen["string_torque"]
        return torque_from_twist(self.plant, seen)
