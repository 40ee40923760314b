"""Simulate a rig: one call, three methods, a result with named signals. No reinforcement learning needed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal, TypeAlias

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.drive import Drive, DriveLike
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.friction.tilt import Tilt
from drillrig_env.inputs import Inputs, Pieces, Schedule
from drillrig_env.model import STATE_NAMES, armature_voltage, check_state, torque_into_string
from drillrig_env.parameters import closest, refuse
from drillrig_env.reference import radau, vode
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stepper.along import advance_along
from drillrig_env.stepper.finite import check_finite
from drillrig_env.stepper.limits import check_computable
from drillrig_env.stepper.tables import TOLERANCE
from drillrig_env.stepper.times import same_time, sample_count, step_of

_Method: TypeAlias = Callable[[Rig, Pieces, Tilt | None, Drive | None, FloatArray, float], FloatArray]
"""From rig, inputs, tilt, drive, first state and tolerance to the states at all stops, shape (stops, 7)."""

SIGNALS = ("time", *STATE_NAMES, "speed_reference", "normal_force", "voltage", "torque_into_string", "friction_torque")
"""The names of all signals of a simulation, in the order of its table."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """A simulated run: `time` (n,), `state` (n, 7) in the model's order, and the inputs at those times.

    `rig`, `friction` (with an entry a time where a course gives coefficients) and `drive` (None: the rig's own) are
    those that were simulated; `speed_reference` (rad/s) and `normal_force` (N, as the disc presses at its angle) have
    the shape (n,).

    The states are also there by name: `bit_speed`, `collar_speed`, `top_speed` (rad/s), `twist_12`,
    `twist_23`, `speed_error_integral` (rad), `current` (A).

    >>> from drillrig_env import simulate
    >>> run = simulate(speed_reference=2.0, duration=30.0)
    >>> run.state.shape, run.bit_speed.shape
    ((3001, 7), (3001,))
    """

    rig: Rig
    friction: Friction  # with one entry a time where a course gives coefficients
    time: FloatArray  # s
    state: FloatArray
    speed_reference: FloatArray  # rad/s
    normal_force: FloatArray  # N, as the disc presses at its angle
    drive: Drive | None = None  # in place of the rig's own

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
        """Voltage of the armature, of the PI loop (4-6) unless a drive says otherwise, V."""
        return armature_voltage(self.rig, self.drive, self.speed_reference, self.top_speed, self.speed_error_integral)

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
    *,
    course: Any = None,
    tilt: Any = None,
    drive: DriveLike = None,
) -> Simulation:
    """Simulate one rig from t = 0 to `duration` and sample it every `sample_period` (both s).

    `rig` and `friction` default to the chapter's, and may be dictionaries of changes to it or paths of TOML files;
    `initial_state` (7 states) defaults to the rig at rest.
    `speed_reference` (rad/s) and `normal_force` (N, default the friction's own) are numbers or
    schedules such as `[(0, 0.0), (50, 25.0)]`: 0 N until 50 s, then 25 N. A `course` (a `Course`, or the path of a CSV
    file) gives normal force or coefficients as a table over time; with a `tilt` (a `Tilt`) the normal force varies as
    disc 1 turns, from theta_1 = 0 on. A `drive` takes the place of the rig's own: a `Drive`, or a dictionary of its
    fields.

    Which method? "fast", the exact stepper, unless you want to check it: the error of any speed stays below
    `tolerance` over 20 s, 1e-7 to 1e-3 in the rig's own unit of speed, 1 rad/s for the chapter's
    (`drillrig_env.stepper.units`; other methods have their own: see `drillrig_env.reference`). "vode" is
    the chapter's own way, hundreds of times slower; "radau", ten thousands of times slower, is the accurate
    reference, with the kinks of the friction law split by events.

    >>> run = simulate(speed_reference=3.0, normal_force=[(0, 0.0), (50, 25.0)], duration=100)
    >>> bool(run.bit_speed[-500:].max() > 5.0)  # stick-slip: the bit races at twice its speed
    True

    Raises `ValueError` for a value that is not allowed, naming it, its unit and what is, and `NotFiniteError` where a
    state can no longer be computed.
    """
    rig, friction, drive = Rig.of(rig), Friction.of(friction), Drive.of(drive)
    if (rigs := len(friction.as_array())) != 1:
        raise ValueError(
            f"simulate: friction for {rigs} rigs is not allowed; allowed: one rig; simulate_batch takes many"
        )
    check_computable(rig, drive)
    count, same = sample_count("simulate", duration, sample_period), same_time(duration, sample_period)
    if method not in _METHODS:
        raise ValueError(f"simulate: method = {method!r} is not known; {closest(method, _METHODS)}")
    inputs = Inputs.of(friction, speed_reference, normal_force, course)
    disc = None if tilt is None else Tilt.of(tilt).of_one_disc()
    if disc is not None and drive is not None and drive.current_limit is not None:
        raise refuse("simulate", "current_limit", drive.current_limit, "A", "none where the disc is tilted")
    if count < 1:
        raise refuse("simulate", "sample_period", sample_period, "s", f"<= duration = {duration}")
    time = sample_period * np.arange(count + 1, dtype=float)
    pieces = inputs.pieces(time, same)
    states = _METHODS[method](rig, pieces, disc, drive, check_state(rig, initial_state, drive), tolerance)
    check_finite(states[None], pieces.stops, "simulate")
    sampled = np.searchsorted(pieces.stops, time)
    force = inputs.force(time, same)
    if disc is not None:
        force = force * disc.factor(pieces.angles(states)[sampled])
    return Simulation(
        rig=rig,
        friction=friction if inputs.course is None else Friction(*inputs.coefficients(time, same).T, law=friction.law),
        time=time,
        state=states[sampled],
        speed_reference=inputs.reference(time, same),
        normal_force=force,
        drive=drive,
    )


def _fast(
    rig: Rig, pieces: Pieces, disc: Tilt | None, drive: Drive | None, state: FloatArray, tolerance: float
) -> FloatArray:
    """The fast stepper: one compiled call along all intervals."""
    _, period = step_of(rig, float(pieces.intervals.max()))
    contacts = pieces.friction.contacts(rig, pieces.references, len(pieces.references))
    if disc is not None:
        disc.put_on(contacts, 0.0)
    runs = advance_along(
        rig, contacts[None], pieces.which, state[None], pieces.intervals[None], period, tolerance, drive
    )
    return np.concatenate([state[None], runs[0]])


def _by_pieces(solve: Callable[..., FloatArray]) -> _Method:
    """A reference method, from one change of the inputs to the next."""

    def run(
        rig: Rig, pieces: Pieces, disc: Tilt | None, drive: Drive | None, state: FloatArray, tolerance: float
    ) -> FloatArray:
        states = np.empty((len(pieces.stops), 7))
        states[0] = state
        for first, last in pairwise([*pieces.changes, len(pieces.intervals)]):
            piece = int(pieces.which[first])
            friction, reference = pieces.friction.each()[piece], float(pieces.references[piece])
            angle = float(pieces.angles(states[: first + 1])[-1])
            times = pieces.stops[first : last + 1]
            states[first + 1 : last + 1] = solve(
                rig, friction, reference, states[first], times, disc=disc, angle=angle, drive=drive
            )
        return states

    return run


_METHODS: dict[str, _Method] = {"fast": _fast, "vode": _by_pieces(vode), "radau": _by_pieces(radau)}
