"""The 7-state model of the rig: state equations (4-17), Jacobian (4-19), steady state (4-16), energy.

States, in this order everywhere:

    x_1 twist_12       rad    theta_1 - theta_2, twist between disc 1 (bit) and disc 2 (collars)
    x_2 twist_23       rad    theta_2 - theta_3, twist between disc 2 and the motor's output
    x_3 bit_speed      rad/s  speed of disc 1
    x_4 collar_speed   rad/s  speed of disc 2
    x_5 top_speed      rad/s  speed of the motor's output, behind the gear
    x_6 current        A      armature current
    x_7 speed_error_integral  rad  integral of omega_ref - x_5, the state of the PI loop

Three lines of the printed chapter are slips, each settled by the equation that it comes from:
(4-5d) and (4-17) print -d_2 x_5 where (4-3b) gives +d_2 x_5; (4-20) prints J_52 = -k_2/J_3 where
(4-5e) gives +k_2/J_3; (4-2b) and (4-3b) print the acceleration of disc 1 where disc 2's is meant.

T_r2(x_4) is the chapter's dry friction of disc 2: T_r2 sign(x_4), and a straight line within the stick zone
|x_4| < omega_s, as (4-9) has it for disc 1.

Beyond the chapter discs 1 and 2 may lose C_1 x_3 and C_2 x_4 to what is around them, as its motor does.

In steady rotation nothing changes, the drive delivers what the bit takes, and all of its power is lost:

>>> from drillrig_env import Friction, Rig, model
>>> rig, friction = Rig(), Friction(normal_force=20.0)
>>> state = model.steady_state(rig, friction, speed=3.0)
>>> rates = model.state_equations(state, 3.0, float(friction.torque(rig, 3.0)), rig)
>>> bool(max(abs(rate) for rate in rates) < 1e-9)
True
>>> round(float(model.torque_into_string(rig, state)), 3), round(float(friction.torque(rig, 3.0)), 3)
(0.306, 0.306)
>>> round(float(model.motor_power(rig, state)), 3), round(float(model.dissipated_power(rig, friction, state)), 3)
(3.892, 3.892)
>>> round(float(model.stored_energy(rig, state)), 3)
0.473
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.drive import Drive, Limiting
from drillrig_env.friction import Friction
from drillrig_env.parameters import POSITIVE, Allowed, refuse
from drillrig_env.rig import Rig

STATE_NAMES = (
    "twist_12",
    "twist_23",
    "bit_speed",
    "collar_speed",
    "top_speed",
    "current",
    "speed_error_integral",
)
STATE_UNITS = ("rad", "rad", "rad/s", "rad/s", "rad/s", "A", "rad")


def state_equations(
    x: Sequence[float] | FloatArray, omega_ref: float, T_r1: float, rig: Rig, drive: Drive | None = None
) -> list[float]:
    """Time derivative of the 7 states, equations (4-17).

    `x` holds the 7 states, `omega_ref` is the speed reference (rad/s), `T_r1` the friction torque
    on disc 1 (N m), from (4-7) or (4-9) at x_3. `drive` takes the place of the rig's own.
    """
    x_1, x_2, x_3, x_4, x_5, x_6, x_7 = x
    p = rig
    T_r2 = 0.0 if p.T_r2 == 0.0 else p.T_r2 * min(max(x_4 / p.omega_s, -1.0), 1.0)
    if drive is None:
        u, wound = p.k_p * (omega_ref - x_5) + p.k_i * x_7, 0.0
    else:
        asked = drive.k_p * (omega_ref - x_5) + drive.k_i * x_7 + drive.compensation(rig) * x_5
        limited = min(max(asked, p.eta * p.K_E * x_5 - drive.room(rig)), p.eta * p.K_E * x_5 + drive.room(rig))
        u, wound = limited + drive.voltage_offset, (limited - asked) / drive.k_p if limited != asked else 0.0
    return [
        x_3 - x_4,
        x_4 - x_5,
        (-p.d_1 * x_3 + p.d_1 * x_4 - p.k_1 * x_1 - T_r1 - p.C_1 * x_3) / p.J_1,
        (p.d_1 * x_3 - (p.d_1 + p.d_2) * x_4 + p.d_2 * x_5 + p.k_1 * x_1 - p.k_2 * x_2 - T_r2 - p.C_2 * x_4) / p.J_2,
        (p.k_2 * x_2 + p.d_2 * x_4 - (p.eta**2 * p.C_m + p.d_2) * x_5 + p.eta * p.K_T * x_6 - p.eta * p.T_f) / p.J_3,
        (-p.R * x_6 - p.eta * p.K_E * x_5 + u) / p.L,
        omega_ref - x_5 + wound,
    ]


def armature_voltage(
    rig: Rig, drive: Drive | None, speed_reference: Quantity, top_speed: Quantity, speed_error_integral: Quantity
) -> FloatArray:
    """Voltage of the armature (V): what the speed loop (4-6) asks for, within the drive's limit, and its offset.

    `rig` has the loop's gains; `speed_reference` and `top_speed` are the speeds, `speed_error_integral` the integral.

    Speeds are in rad/s, the integral in rad; shapes broadcast. A `drive` of None is the rig's own.

    >>> from drillrig_env import Rig
    >>> rig = Rig()
    >>> round(float(armature_voltage(rig, None, 3.0, top_speed=2.5, speed_error_integral=1.0)), 3)  # V
    2.5
    """
    own = drive or Drive.of_rig(rig)
    asked = own.k_p * (np.asarray(speed_reference) - top_speed) + own.k_i * np.asarray(speed_error_integral)
    if drive is None:
        return np.asarray(asked)
    back_emf = rig.eta * rig.K_E * np.asarray(top_speed)
    asked = asked + drive.compensation(rig) * np.asarray(top_speed)
    return np.asarray(np.clip(asked, back_emf - drive.room(rig), back_emf + drive.room(rig)) + drive.voltage_offset)


def jacobian(rig: Rig, slope: float = 0.0, drive: Drive | Limiting | None = None) -> FloatArray:
    """Jacobian J* of the state equations, (4-19) with the entries (4-20); shape (7, 7).

    `slope` is the slope Delta T_r1 of the friction torque (N m s/rad, (4-21)); with 0 this is the
    linear part of the model, friction aside. `drive` takes the place of the rig's own. Disc 2 turns, so that T_r2
    is constant; where it sticks, the Jacobian is that of `with_stuck_collars(rig)`.

    >>> import numpy as np
    >>> from drillrig_env import Rig
    >>> float(np.linalg.eigvals(jacobian(Rig(), slope=-0.02)).real.max()) > 0.0  # too steep a fall
    True
    >>> float(np.linalg.eigvals(jacobian(Rig(), slope=-0.01)).real.max()) > 0.0
    False
    """
    p, (k_p, k_i, K_E) = rig, _speed_loop(rig, drive.drive if isinstance(drive, Limiting) else drive)
    J = np.zeros((7, 7))
    J[0, 2], J[0, 3] = 1.0, -1.0
    J[1, 3], J[1, 4] = 1.0, -1.0
    J[2, 0], J[2, 2], J[2, 3] = -p.k_1 / p.J_1, -(slope + p.d_1 + p.C_1) / p.J_1, p.d_1 / p.J_1
    J[3, 0], J[3, 1] = p.k_1 / p.J_2, -p.k_2 / p.J_2
    J[3, 2], J[3, 3], J[3, 4] = p.d_1 / p.J_2, -(p.d_1 + p.d_2 + p.C_2) / p.J_2, p.d_2 / p.J_2
    J[4, 1], J[4, 3] = p.k_2 / p.J_3, p.d_2 / p.J_3
    J[4, 4], J[4, 5] = -(p.eta**2 * p.C_m + p.d_2) / p.J_3, p.eta * p.K_T / p.J_3
    J[5, 4], J[5, 5], J[5, 6] = -(p.eta * K_E + k_p) / p.L, -p.R / p.L, k_i / p.L
    J[6, 4] = -1.0
    if isinstance(drive, Limiting):
        J[5, 4], J[5, 6], J[6, 4], J[6, 6] = 0.0, 0.0, p.eta * K_E / k_p, -k_i / k_p
    return J


def with_stuck_collars(rig: Rig) -> Rig:
    """The rig while disc 2 is in its stick zone, where T_r2 is a viscous loss of T_r2 / omega_s.

    >>> from drillrig_env import Rig
    >>> with_stuck_collars(Rig(T_r2=0.05)).C_2
    50.0
    """
    return replace(rig, T_r2=0.0, C_2=rig.C_2 + rig.T_r2 / rig.omega_s)


def torque_on_collars(rig: Rig, x_4: Quantity) -> FloatArray:
    """Friction torque T_r2(x_4) on disc 2 (N m) at speeds x_4 (rad/s); shape (...). `rig` has T_r2 and omega_s.

    >>> from drillrig_env import Rig
    >>> torque_on_collars(Rig(T_r2=0.05), [-2.0, 0.0, 0.0005, 2.0])
    array([-0.05 ,  0.   ,  0.025,  0.05 ])
    """
    return np.asarray(rig.T_r2 * np.clip(np.asarray(x_4) / rig.omega_s, -1.0, 1.0))


def friction_input(rig: Rig) -> FloatArray:
    """How the friction torque enters (4-17): the derivative of the 7 rates with respect to T_r1; shape (7,).

    `rig` has J_1.

    >>> from drillrig_env import Rig
    >>> [round(float(value), 2) for value in friction_input(Rig())]
    [0.0, 0.0, -34.72, 0.0, 0.0, 0.0, 0.0]
    """
    b = np.zeros(7)
    b[2] = -1.0 / rig.J_1
    return b


def steady_state(rig: Rig, friction: Friction, speed: Quantity) -> FloatArray:
    """Steady rotation at `speed` (rad/s, > 0), equation (4-16) with x_6 and x_7; shape (..., 7).

    `rig` is one rig; `friction` has one entry or many.

    Shapes of `speed` and the friction's fields broadcast. A torque T_r2 on disc 2 adds to the
    torque that the lower shaft and the motor carry.
    """
    omega = np.asarray(speed, dtype=float)
    return equilibrium(rig, np.asarray(friction.torque(rig, omega)), omega)


def frictionless_state(rig: Rig, speed: Quantity, drive: Drive | Limiting | None = None) -> FloatArray:
    """The state that (4-17) holds still at `speed` (rad/s) without friction on disc 1; shape (..., 7).

    At speed 0 this is the rig at rest: shafts untwisted, but for what T_r2 just holds, the motor just balancing its
    own friction (so that it does not creep backwards, where the model's constant T_f would be wrong). `drive`
    takes the place of the rig's own. One that limits its current turns the rig at another speed, where losses take all
    of its torque.

    >>> from drillrig_env import Rig
    >>> [round(float(value), 4) for value in frictionless_state(Rig(), 0.0)]  # at rest
    [-0.0, -0.0, 0.0, 0.0, 0.0, 0.9492, 0.3132]
    """
    omega = np.asarray(speed, dtype=float)
    if isinstance(drive, Limiting):
        return np.broadcast_to(_limited_state(rig, drive), (*omega.shape, 7))
    return equilibrium(rig, np.zeros(omega.shape), omega, drive)


def _limited_state(rig: Rig, limiting: Limiting) -> FloatArray:
    """The state that a drive holds still without friction on disc 1 while it limits its current; shape (7,)."""
    drive = limiting.drive
    torque = rig.eta * rig.K_T * (limiting.current + drive.voltage_offset / rig.R) - rig.eta * rig.T_f - rig.T_r2
    with np.errstate(divide="ignore", invalid="ignore"):  # a rig without losses has none
        omega = float(np.divide(torque, rig.eta**2 * rig.C_m + rig.C_1 + rig.C_2))
    x = equilibrium(rig, np.zeros(()), omega, drive)
    x[6] = (rig.R * limiting.current + rig.eta * drive.remaining_K_E(rig) * omega) / drive.k_i
    return x


def wound_up(rig: Rig, friction: Friction, speed_reference: Quantity) -> FloatArray:
    """Stuck rigs just before break-loose: discs still, shafts twisted by it, the drive as in steady rotation.

    `rig` is one rig; `friction` has one entry or many.

    Shapes of `speed_reference` (rad/s) and the friction's fields broadcast; the result has shape (..., 7).

    >>> from drillrig_env import Friction, Rig
    >>> rig, friction = Rig(), Friction(normal_force=20.0)
    >>> twist = wound_up(rig, friction, 2.0)[1]
    >>> round(float(-rig.k_2 * twist), 3), round(float(friction.break_loose(rig)), 3)  # N m
    (0.485, 0.485)
    """
    states = steady_state(rig, friction, speed_reference)
    torque = friction.break_loose(rig)
    states[..., 0] = -torque / rig.k_1
    states[..., 1] = -(torque + rig.T_r2) / rig.k_2
    states[..., 2] = states[..., 3] = 0.0
    return states


def _speed_loop(rig: Rig, drive: Drive | None) -> tuple[float, float, float]:
    """k_p, k_i, and K_E as the drive leaves it; the rig's own without a drive."""
    return (rig.k_p, rig.k_i, rig.K_E) if drive is None else (drive.k_p, drive.k_i, drive.remaining_K_E(rig))


def equilibrium(rig: Rig, T_r1: Quantity, omega: Quantity, drive: Drive | None = None) -> FloatArray:
    """The state that (4-17) holds still at `omega` (rad/s) under a torque T_r1 on disc 1 (N m); shape (..., 7).

    `rig` is one rig, with its own drive where `drive` is None.

    >>> from drillrig_env import Rig
    >>> [round(float(value), 3) for value in equilibrium(Rig(), T_r1=0.4, omega=2.0)]
    [-0.358, -1.093, 2.0, 2.0, 2.0, 1.369, 1.537]
    """
    T_r1, omega = np.broadcast_arrays(T_r1, omega)
    _, k_i, K_E = _speed_loop(rig, drive)
    T_12, T_r2 = T_r1 + rig.C_1 * omega, rig.T_r2 + rig.C_2 * omega
    x = np.empty((*omega.shape, 7))
    x[..., 0] = -T_12 / rig.k_1
    x[..., 1] = -(T_12 + T_r2) / rig.k_2
    x[..., 2] = x[..., 3] = x[..., 4] = omega
    x[..., 5] = (rig.eta**2 * rig.C_m * omega + T_12 + T_r2 + rig.eta * rig.T_f) / (rig.eta * rig.K_T)
    x[..., 6] = (rig.R * x[..., 5] + rig.eta * K_E * omega - (drive.voltage_offset if drive else 0.0)) / k_i
    return x


def check_state(rig: Rig, state: FloatArray | Sequence[float] | None, drive: Drive | None = None) -> FloatArray:
    """A state as a new array of shape (7,), or several of shape (n, 7); None is the rig at rest, on a drive.

    Raises `ValueError` for another shape or a number that is not finite.

    >>> from drillrig_env import Rig
    >>> check_state(Rig(), [0.0, -1.0, 0.0, 0.0, 2.0, 0.5, 0.0]).shape
    (7,)
    """
    array = frictionless_state(rig, 0.0, drive) if state is None else np.array(state, dtype=float)
    if array.ndim not in (1, 2) or array.shape[-1] != 7:
        raise refuse("initial_state", "shape", array.shape, "", f"(7,), or (n, 7): {', '.join(STATE_NAMES)}")
    for name, unit, values in zip(STATE_NAMES, STATE_UNITS, np.moveaxis(array, -1, 0), strict=True):
        if not np.all(np.isfinite(values)):
            raise refuse("initial_state", name, values, unit, Allowed())
    return array


def minimum_speed(rig: Rig, friction: Friction) -> Quantity:
    """omega_min of (4-15), in rad/s: below it a drive with the gain k_p alone does not break the bit loose.

    `rig` is one rig; `friction` has one entry or many.

    The chapter leaves out the integrator here. With it the drive winds up and always breaks away:
    standstill is no equilibrium of the 7-state model for a positive speed reference.
    Raises `ValueError` for k_p <= 0, where (4-15) has no meaning.

    >>> from drillrig_env import Friction, Rig
    >>> round(float(minimum_speed(Rig(), Friction(normal_force=20.0))), 3)  # rad/s
    0.157
    """
    if rig.k_p <= 0:
        raise refuse("minimum_speed", "k_p", rig.k_p, "V s/rad", POSITIVE)
    static = np.asarray(friction.normal_force) * rig.r_1 * friction.mu_s
    speed = (static + rig.eta * rig.T_f) * rig.R / (rig.eta * rig.K_T * rig.k_p)
    return float(speed) if np.ndim(speed) == 0 else np.asarray(speed)


def torque_into_string(rig: Rig, state: FloatArray) -> FloatArray:
    """Torque that the drive delivers into the string, -(k_2 x_2 + d_2 (x_4 - x_5)), in N m; shape (...).

    `rig` has the upper shaft; `state` has the shape (..., 7).

    In steady rotation it is T_r1 + T_r2, and what viscous discs lose.
    """
    x = np.asarray(state)
    return np.asarray(-(rig.k_2 * x[..., 1] + rig.d_2 * (x[..., 3] - x[..., 4])))


def estimate_of_torque(rig: Rig, nominal: Rig) -> tuple[float, float, float, float]:
    """What the drive of a rig makes of the torque into the string (N m) where it takes the rig for the nominal one.

    It is eta K_T x_6 - eta^2 C_m x_5 - eta T_f - J_3 dx_5/dt of the nominal rig: a gain times that torque, so much for
    each rad/s of x_5 (N m s/rad), for each rad/s^2 of its rate (N m s^2/rad), and an offset (N m). 1 and zeros where
    the rig is the nominal one.

    >>> from dataclasses import replace
    >>> from drillrig_env import Rig
    >>> gain, by_speed, by_rate, offset = estimate_of_torque(replace(Rig(), K_T=0.14), nominal=Rig())
    >>> round(gain, 3)  # a motor that is stronger than its drive believes seems to deliver less
    0.9
    """
    gain = (nominal.eta * nominal.K_T) / (rig.eta * rig.K_T)
    return (
        gain,
        gain * (rig.eta**2 * rig.C_m) - nominal.eta**2 * nominal.C_m,
        gain * rig.J_3 - nominal.J_3,
        gain * (rig.eta * rig.T_f) - nominal.eta * nominal.T_f,
    )


def stored_energy(rig: Rig, state: FloatArray) -> FloatArray:
    """Mechanical energy of discs, motor inertia and shafts, in J; `state` of shape (..., 7), result (...).

    `rig` is one rig.
    """
    x = np.asarray(state)
    kinetic = rig.J_1 * x[..., 2] ** 2 + rig.J_2 * x[..., 3] ** 2 + rig.J_3 * x[..., 4] ** 2
    elastic = rig.k_1 * x[..., 0] ** 2 + rig.k_2 * x[..., 1] ** 2
    return np.asarray(0.5 * (kinetic + elastic))


def motor_power(rig: Rig, state: FloatArray) -> FloatArray:
    """Power that the motor's field puts into the shaft, eta K_T x_6 x_5, in W; shape (...).

    `rig` has the motor; `state` has the shape (..., 7).
    """
    x = np.asarray(state)
    return np.asarray(rig.eta * rig.K_T * x[..., 5] * x[..., 4])


def dissipated_power(rig: Rig, friction: Friction, state: FloatArray) -> FloatArray:
    """Power lost in shafts, motor friction, brake pin, viscous discs, to T_r2, in W; `state` (..., 7), result (...).

    `rig` is one rig; `friction` has one entry or many.
    """
    x = np.asarray(state)
    shafts = rig.d_1 * (x[..., 2] - x[..., 3]) ** 2 + rig.d_2 * (x[..., 3] - x[..., 4]) ** 2
    motor = rig.eta**2 * rig.C_m * x[..., 4] ** 2 + rig.eta * rig.T_f * x[..., 4]
    discs = rig.C_1 * x[..., 2] ** 2 + rig.C_2 * x[..., 3] ** 2
    collars = torque_on_collars(rig, x[..., 3]) * x[..., 3]
    return np.asarray(shafts + motor + discs + collars + friction.torque(rig, x[..., 2]) * x[..., 2])
