"""Two reference solutions with SciPy: the chapter's VODE-BDF, and Radau with the kinks split by events.

The fast stepper is tested against both. They are hundreds (VODE) to ten thousands (Radau) of times slower.

>>> import numpy as np
>>> from drillrig_env import Friction, Rig, simulate
>>> from drillrig_env.reference import radau, vode
>>> rig, friction, times = Rig(), Friction(normal_force=20.0), np.linspace(0.0, 2.0, 21)
>>> run = simulate(rig, friction, speed_reference=2.0, duration=2.0, sample_period=0.1)
>>> slow = radau(rig, friction, 2.0, run.state[0], times)
>>> bool(np.abs(slow - run.state[1:]).max() < 1e-6)
True
>>> bool(np.abs(vode(rig, friction, 2.0, run.state[0], times) - slow).max() < 1e-5)
True
"""

from __future__ import annotations

from math import inf

import numpy as np
from scipy.integrate import ode, solve_ivp

from drillrig_env.arrays import FloatArray
from drillrig_env.drive import Drive
from drillrig_env.friction import Contact, Friction
from drillrig_env.friction.law import edges_of, torque_in_zone, zone_of
from drillrig_env.friction.tilt import Tilt
from drillrig_env.model import friction_input, jacobian, state_equations, with_stuck_collars
from drillrig_env.rig import Rig

_torque_in_zone = torque_in_zone.py_func  # type: ignore[attr-defined]
_zone_of = zone_of.py_func  # type: ignore[attr-defined]
_edges_of = edges_of.py_func  # type: ignore[attr-defined]


def vode(
    rig: Rig,
    friction: Friction,
    speed_reference: float,
    state: FloatArray,
    times: FloatArray,
    *,
    rtol: float = 1e-8,
    with_jacobian: bool = True,
    disc: Tilt | None = None,
    angle: float = 0.0,
    drive: Drive | None = None,
) -> FloatArray:
    """Integrate as the chapter does, with VODE's BDF method on (4-17) and (4-9), in plain Python.

    `rig` and `friction` are of one rig, at a constant `speed_reference` (rad/s) and under its `drive` (None: its own);
    `times` (s) have the shape (n + 1,), and `rtol` is the relative tolerance of a step.

    `times` starts at the time of `state`, when a tilted `disc` is at `angle` (theta_1, rad); returns the states at
    `times[1:]`, shape (n, 7). With `with_jacobian=False` VODE iterates functionally, at some 40 times the work. The
    Jacobian is left to VODE's differences: SciPy 1.17 reads a user's one transposed here.
    """
    contact = _plain_contact(rig, friction, speed_reference)
    press = _Press(disc, angle, speed_reference, state, times[0])

    def rates(t: float, x: FloatArray) -> list[float]:
        x_3 = float(x[2])
        torque, _ = _torque_in_zone(_zone_of(x_3, rig.omega_s, contact.knee), x_3, contact)
        torque *= press.factor(t, x)
        return state_equations(x.tolist(), speed_reference, torque, rig, drive)

    solver = ode(rates).set_integrator(
        "vode", method="bdf", rtol=rtol, atol=1e-3 * rtol, with_jacobian=with_jacobian, nsteps=10_000_000
    )
    solver.set_initial_value(state, times[0])
    states = np.empty((len(times) - 1, 7))
    for i, time in enumerate(times[1:]):
        states[i] = solver.integrate(time)
        if not solver.successful():
            raise RuntimeError(f"vode: gave up at t = {solver.t:g} s of {times[-1]:g} s")
    return states


def radau(
    rig: Rig,
    friction: Friction,
    speed_reference: float,
    state: FloatArray,
    times: FloatArray,
    *,
    rtol: float = 1e-11,
    atol: float = 1e-13,
    disc: Tilt | None = None,
    angle: float = 0.0,
    drive: Drive | None = None,
) -> FloatArray:
    """Integrate with Radau one piece of every law at a time, each kink located as an event.

    `rig`, `friction`, `speed_reference` (rad/s), `state` (7,), `times` (s), `disc`, `angle` (rad) and `drive` are those
    of `vode`; `rtol` and `atol` (in each state's own unit) are the tolerances of a step.

    Laws are that of (4-9), that of T_r2, and the limit of the drive's current.

    Every piece is smooth beyond its zone, so the event is found on a smooth solution. Arguments and
    result as for `vode`; the accurate reference of the project.
    """
    contact, to_rates = _plain_contact(rig, friction, speed_reference), friction_input(rig)
    press = _Press(disc, angle, speed_reference, state, times[0])
    at_rest = np.asarray(state_equations([0.0] * 7, speed_reference, 0.0, rig))
    loop = _Loop(rig, drive or Drive.of_rig(rig), speed_reference)
    states = np.empty((len(times) - 1, 7))
    time, x, done = float(times[0]), np.asarray(state, dtype=float), 0
    zone, collars = _zone_of(float(x[2]), rig.omega_s, contact.knee), _zone_of(float(x[3]), rig.omega_s, inf)
    limit = loop.limit_at(x)
    while done < len(states):
        linear = jacobian(rig if collars else with_stuck_collars(rig))
        constant = at_rest - np.eye(7)[3] * collars * rig.T_r2 / rig.J_2
        linear[5:], constant[5:] = loop.rows(limit)

        def rates(
            t: float, x: FloatArray, zone: int = zone, linear: FloatArray = linear, constant: FloatArray = constant
        ) -> FloatArray:
            torque = press.factor(t, x) * _torque_in_zone(zone, float(x[2]), contact)[0]
            return np.asarray(linear @ x + constant + to_rates * torque)

        def slopes(t: float, x: FloatArray, zone: int = zone, linear: FloatArray = linear) -> FloatArray:
            full = linear.copy()
            full[2, 2] += to_rates[2] * press.factor(t, x) * _torque_in_zone(zone, float(x[2]), contact)[1]
            return full

        edges = [*_edges(zone, contact), *_collars_edges(collars, rig), *loop.edges(limit)]
        events = [_Edge(loop.row if state == _LOOP else np.eye(7)[state], *level) for state, *level, _ in edges]
        piece = solve_ivp(
            rates,
            (time, times[-1]),
            x,
            "Radau",
            t_eval=times[1 + done :],
            events=events,
            rtol=rtol,
            atol=atol,
            jac=slopes,
        )
        if not piece.success:
            raise RuntimeError(f"radau: gave up at t = {time:g} s: {piece.message}")
        sampled = np.reshape(piece.y, (7, -1)).T  # SciPy gives an empty list where an event came first
        states[done : done + len(sampled)] = sampled
        done += len(sampled)
        if piece.t_events is not None and piece.y_events is not None and piece.status == 1:
            hit = next(k for k in range(len(edges)) if piece.t_events[k].size)
            time, x = float(piece.t_events[hit][0]), np.array(piece.y_events[hit][0])
            one, level, _, beyond = edges[hit]
            if one == _LOOP:
                limit = beyond
            else:
                x[one] = level
                zone, collars = (beyond, collars) if one == 2 else (zone, beyond)
    return states


def _edges(zone: int, contact: Contact) -> list[tuple[int, float, float, int]]:
    """The ends of a piece of the law of disc 1: the state, its speed (rad/s), its direction, and the piece beyond."""
    (low, high), flat = _edges_of(zone, contact.omega_s, contact.knee), contact.knee <= contact.omega_s
    if zone == 0:
        return [(2, side * high, side, 2 * side if flat else side) for side in (-1, 1)]
    side = 1 if zone > 0 else -1
    below = side if abs(zone) == 2 and not flat else 0
    return [
        (2, side * speed, direction * side, beyond)
        for speed, direction, beyond in ((low, -1, below), (high, 1, 2 * side))
        if np.isfinite(speed)
    ]


def _collars_edges(collars: int, rig: Rig) -> list[tuple[int, float, float, int]]:
    """The same for T_r2 on disc 2, where there is any."""
    if rig.T_r2 == 0.0:
        return []
    if collars == 0:
        return [(3, side * rig.omega_s, side, side) for side in (-1, 1)]
    return [(3, collars * rig.omega_s, -collars, 0)]


def _plain_contact(rig: Rig, friction: Friction, speed_reference: float) -> Contact:
    return Contact(*friction.single().contacts(rig, speed_reference)[0].item())


_LOOP = 7
"""The speed loop, where the ends of a piece name a state."""


class _Loop:
    """The speed loop of a drive, which limits the current forwards (1), backwards (-1) or not (0)."""

    def __init__(self, rig: Rig, drive: Drive, speed_reference: float) -> None:
        self.rig, self.drive, self.speed_reference = rig, drive, speed_reference
        self.row = np.zeros(7)  # of what it asks for beyond the back-EMF, but for k_p omega_ref
        self.row[4] = -drive.k_p - rig.eta * rig.K_E + drive.compensation(rig)
        self.row[6] = drive.k_i

    def limit_at(self, x: FloatArray) -> int:
        asked = float(self.row @ x) + self.drive.k_p * self.speed_reference
        return int(asked > self.drive.room(self.rig)) - int(asked < -self.drive.room(self.rig))

    def rows(self, limit: int) -> tuple[FloatArray, FloatArray]:
        """The rates of current and integral: what the states add to them, shape (2, 7), and what is constant."""
        p, drive = self.rig, self.drive
        by_state, constant = np.zeros((2, 7)), np.zeros(2)
        by_state[0, 5], by_state[1, 4] = -p.R / p.L, -1.0
        beyond = self.row, drive.k_p * self.speed_reference
        if limit == 0:
            by_state[0] += beyond[0] / p.L
            constant[:] = (beyond[1] + drive.voltage_offset) / p.L, self.speed_reference
        else:
            room = limit * drive.room(p)
            by_state[1] -= beyond[0] / drive.k_p
            constant[:] = (room + drive.voltage_offset) / p.L, self.speed_reference + (room - beyond[1]) / drive.k_p
        return by_state, constant

    def edges(self, limit: int) -> list[tuple[int, float, float, int]]:
        """The ends of a piece, as `_edges`."""
        room, asked = self.drive.room(self.rig), self.drive.k_p * self.speed_reference
        if room == inf:
            return []
        if limit == 0:
            return [(_LOOP, side * room - asked, side, side) for side in (-1, 1)]
        return [(_LOOP, limit * room - asked, -limit, 0)]


class _Press:
    """By which a tilted disc presses more than N_1 at a time t (s) and a state; 1 without a tilt."""

    def __init__(self, disc: Tilt | None, angle: float, speed_reference: float, state: FloatArray, time: float) -> None:
        self.disc, self.angle, self.speed_reference = disc, angle, speed_reference
        self.turned, self.time = state[0] + state[1] - state[6], time

    def factor(self, t: float, x: FloatArray) -> float:
        if self.disc is None:
            return 1.0
        turned = self.speed_reference * (t - self.time) + x[0] + x[1] - x[6] - self.turned
        return float(self.disc.factor(self.angle + turned))


class _Edge:
    """An event of `solve_ivp`: `row` @ states crosses a `level` in a `direction`, which ends the piece."""

    terminal = True

    def __init__(self, row: FloatArray, level: float, direction: float) -> None:
        self.row = row
        self.level = level
        self.direction = direction

    def __call__(self, _time: float, x: FloatArray) -> float:
        return float(self.row @ x) - self.level
