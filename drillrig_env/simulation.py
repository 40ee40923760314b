"""Simulate a rig: one call, three methods, a result with named signals. No reinforcement learning needed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.model import STATE_NAMES, check_state, torque_into_string
from drillrig_env.parameters import NOT_NEGATIVE, closest, refuse
from drillrig_env.reference import radau, vode
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stepper.batch import advance_batch
from drillrig_env.stepper.finite import check_finite
from drillrig_env.stepper.limits import check_computable
from drillrig_env.stepper.tables import TOLERANCE
from drillrig_env.stepper.times import same_time, sample_count, step_of

Schedule: TypeAlias = float | Sequence[tuple[float, float]]
"""A constant, or (time in s, value) pairs: each value holds from its time on; the first time is 0."""

_Method: TypeAlias = Callable[[Rig, Friction, float, FloatArray, FloatArray], FloatArray]

SIGNALS = ("time", *STATE_NAMES, "speed_reference", "normal_force", "voltage", "torque_into_string", "friction_torque")
"""The names of all signals of a simulation, in the order of its table."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """A simulated run: `time` (n,), `state` (n, 7) in the model's order, and the inputs at those times.

    The states are also there by name: `bit_speed`, `collar_speed`, `top_speed` (rad/s), `twist_12`,
    `twist_23`, `speed_error_integral` (rad), `current` (A).
    """

    rig: Rig
    friction: Friction
    time: FloatArray  # s
    state: FloatArray
    speed_reference: FloatArray  # rad/s
    normal_force: FloatArray  # N

    def _named(self, name: str) -> FloatArray:
        return self.state[:, STATE_NAMES.index(name)]

    @property
    def twist_12(self) -> FloatArray:
        """Twist between disc 1 and disc 2, rad."""
        return self._named("twist_12")

    @property
    def twist_23(self) -> FloatArray:
        """Twist between disc 2 and the motor's output, rad."""
        return self._named("twist_23")

    @property
    def bit_speed(self) -> FloatArray:
        """Speed of disc 1, the bit, rad/s."""
        return self._named("bit_speed")

    @property
    def collar_speed(self) -> FloatArray:
        """Speed of disc 2, rad/s."""
        return self._named("collar_speed")

    @property
    def top_speed(self) -> FloatArray:
        """Speed of the motor's output behind the gear, rad/s."""
        return self._named("top_speed")

    @property
    def current(self) -> FloatArray:
        """Armature current, A."""
        return self._named("current")

    @property
    def speed_error_integral(self) -> FloatArray:
        """Integral of speed reference less top speed, rad."""
        return self._named("speed_error_integral")

    @property
    def voltage(self) -> FloatArray:
        """Voltage of the PI loop (4-6), V."""
        error = self.speed_reference - self.top_speed
        return np.asarray(self.rig.k_p * error + self.rig.k_i * self.speed_error_integral)

    @property
    def torque_into_string(self) -> FloatArray:
        """Torque that the drive delivers into the string, N m."""
        return torque_into_string(self.rig, self.state)

    @property
    def friction_torque(self) -> FloatArray:
        """Friction torque on the bit (4-9), N m."""
        return np.asarray(replace(self.friction, normal_force=self.normal_force).torque(self.rig, self.bit_speed))

    def signals(self) -> dict[str, FloatArray]:
        """Every signal by name, arrays of one length: ready for `pandas.DataFrame` or `numpy.savez`."""
        return {name: self._named(name) if name in STATE_NAMES else getattr(self, name) for name in SIGNALS}


def simulate(
    rig: RigLike = None,
    friction: FrictionLike = None,
    initial_state: FloatArray | Sequence[float] | None = None,
    speed_reference: Schedule = 2.0,
    duration: float = 30.0,
    sample_period: float = 0.01,
    method: Literal["fast", "vode", "radau"] = "fast",
    normal_force: Schedule | None = None,
    tolerance: float = TOLERANCE,
) -> Simulation:
    """Simulate one rig from t = 0 to `duration` and sample it every `sample_period` (both s).

    `rig` and `friction` default to the chapter's, and may be dictionaries of changes to it or paths of TOML files;
    `initial_state` (7 states) defaults to the rig at rest.
    `speed_reference` (rad/s) and `normal_force` (N, default the friction's own) are numbers or
    schedules such as `[(0, 0.0), (50, 25.0)]`: 0 N until 50 s, then 25 N.

    Which method? "fast", the exact stepper, unless you want to check it: the error of any speed stays below
    `tolerance` over 20 s, 1e-7 to 1e-3 in the rig's own unit of speed, 1 rad/s for the chapter's
    (`drillrig_env.stepper.units`; other methods have their own: see `drillrig_env.reference`). "vode" is
    the chapter's own way, hundreds of times slower; "radau", ten thousands of times slower, is the accurate
    reference, with the kinks of the friction law split by events.

    >>> run = simulate(speed_reference=3.0, normal_force=[(0, 0.0), (50, 25.0)], duration=100)
    >>> bool(run.bit_speed[-500:].max() > 5.0)  # stick-slip: the bit races at twice its speed
    True

    Raises `ValueError` for a value that is not allowed, naming it, its unit and what is, and `NotFiniteError` where a
    state can no longer be computed, or disc 2 turns backwards against a constant T_r2.
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    if (rigs := len(friction.as_array())) != 1:
        raise ValueError(
            f"simulate: friction for {rigs} rigs is not allowed; allowed: one rig; simulate_batch takes many"
        )
    check_computable(rig)
    count, same = sample_count("simulate", duration, sample_period), same_time(duration, sample_period)
    fast = partial(_fast, sample_period=float(sample_period), same=same, tolerance=tolerance)
    methods: dict[str, _Method] = {"fast": fast, "vode": vode, "radau": radau}
    if method not in methods:
        raise ValueError(f"simulate: method = {method!r} is not known; {closest(method, methods)}")
    references = _schedule("speed_reference", speed_reference, "rad/s")
    forces = _schedule("normal_force", float(friction.as_array()[0, 0]) if normal_force is None else normal_force, "N")
    if count < 1:
        raise refuse("simulate", "sample_period", sample_period, "s", f"<= duration = {duration}")
    time = sample_period * np.arange(count + 1, dtype=float)
    state = np.empty((count + 1, 7))
    state[0] = check_state(rig, initial_state)

    switches = sorted({t for t, _ in references + forces if t < time[-1] - same})
    x = state[0]
    for begin, end in zip(switches, [*switches[1:], time[-1]], strict=True):
        inside = (time > begin + same) & (time < end - same)
        stops = np.concatenate([[begin], time[inside], [end]])
        reference, force = (float(_values_at(schedule, begin, same)) for schedule in (references, forces))
        states = methods[method](rig, replace(friction, normal_force=force), reference, x, stops)
        state[inside] = states[:-1]
        x = states[-1]
        state[np.abs(time - end) <= same] = x
    if rig.T_r2 > 0.0:  # the fast stepper has marked a disc 2 that turns backwards; so are the other methods' here
        state[np.logical_or.accumulate(state[:, 3] < -rig.omega_s)] = -np.inf
    check_finite(state[None], time, "simulate")
    return Simulation(
        rig=rig,
        friction=friction,
        time=time,
        state=state,
        speed_reference=_values_at(references, time, same),
        normal_force=_values_at(forces, time, same),
    )


def _fast(
    rig: Rig,
    friction: Friction,
    speed_reference: float,
    state: FloatArray,
    times: FloatArray,
    sample_period: float,
    same: float,
    tolerance: float,
) -> FloatArray:
    """The fast stepper with the signature of the reference methods; whole sample periods share one call.

    They are taken as such and not as differences of times, whose rounding would add up.
    """
    states = np.empty((len(times) - 1, 7))
    intervals = np.diff(times)
    intervals[np.abs(intervals - sample_period) <= same] = sample_period
    starts = np.flatnonzero(np.concatenate([[True], intervals[1:] != intervals[:-1]]))
    x = np.asarray(state)
    for first, last in zip(starts, [*starts[1:], len(intervals)], strict=True):
        parts, step = step_of(rig, float(intervals[first]))
        run = advance_batch(
            rig,
            friction,
            x[None],
            speed_reference,
            period=step,
            periods=int(last - first) * parts,
            every=parts,
            tolerance=tolerance,
            where="simulate",
            begin=float(times[first]),
        )
        states[first:last] = run[0]
        x = states[last - 1]
    return states


def _schedule(name: str, schedule: Schedule, unit: str) -> list[tuple[float, float]]:
    if isinstance(schedule, int | float | np.number):
        schedule = [(0.0, float(schedule))]
    pairs = [(float(time), float(value)) for time, value in schedule]
    if not pairs or pairs[0][0] != 0.0:
        first = pairs[0][0] if pairs else "none"
        raise refuse("simulate", f"first time of {name}", first, "s", "0")
    times = [t for t, _ in pairs]
    if not all(np.isfinite(times)) or any(b <= a for a, b in pairwise(times)):
        raise refuse("simulate", f"times (s) of {name}", times, "", "ascending, finite")
    for _, value in pairs:
        if not NOT_NEGATIVE.holds(value):
            raise refuse("simulate", name, value, unit, NOT_NEGATIVE)
    return pairs


def _values_at(schedule: list[tuple[float, float]], times: Quantity, same: float) -> FloatArray:
    starts, values = np.array(schedule).T
    return np.asarray(values[np.searchsorted(starts, np.asarray(times) + same, side="right") - 1])
