"""A start from standstill as a plan: how the bit is to move, and the speed reference that moves it so.

The chain from the bit up to the drive can be inverted one element after the other, since the friction torque
acts at its very end (the bit speed is a flat output of the rig). From a planned bit speed x_3(t) follow

    torque of the lower shaft   T_12 = J_1 x_3' + C_1 x_3 + T_r1(x_3)  (stuck: a planned ramp up to N_1 r_1 mu_s)
    twist of the lower shaft    d_1 x_1' + k_1 x_1 = -T_12,            x_4 = x_3 - x_1'
    torque of the upper shaft   T_23 = J_2 x_4' + C_2 x_4 + T_12 + T_r2
    twist of the upper shaft    d_2 x_2' + k_2 x_2 = -T_23,            x_5 = x_4 - x_2'
    current                     eta K_T x_6 = J_3 x_5' + eta^2 C_m x_5 + eta T_f + T_23
    voltage                     V = R x_6 + eta K_E x_5                (the inductance acts within 3 ms)
    speed loop                  k_p x_7' + k_i x_7 = V,                omega_ref = x_5 + x_7'

and the three differential equations are stable, so that they are simply solved forwards.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.scales import CONTROL_PERIOD

_SUBSTEPS = 50
_LEAST_STATIC = 1e-6  # N m; without a load there is nothing to wind up
_AFTERWARDS = 3.0
"""How long the plan goes on at its final speed, s: until the speed loop has nearly settled."""


@dataclass(frozen=True)
class Haste:
    """How fast a start is: `acceleration` of the bit (rad/s^2), which builds up and dies away within `build_up` (s).

    The torque of the lower shaft passes break-loose at the rate J_1 x_3'' that the build-up begins with.
    """

    acceleration: float
    build_up: float


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned start. Times (s) and bit speeds (rad/s) are fine samples; `references` has an entry a control step."""

    time: FloatArray
    bit_speed: FloatArray
    references: FloatArray  # rad/s, the mean over each control step


@lru_cache(maxsize=4096)
def startup_plan(
    rig: Rig,
    contact: tuple[float, float, float, float],
    torque: float,
    winding: float,
    speed: float,
    haste: Haste,
    period: float = CONTROL_PERIOD,
) -> Plan:
    """Plan a start of a stuck bit, with omega_ref = 0 so far, to `speed` (rad/s).

    The lower shaft is wound up to `torque` (N m), and the drive goes on winding it at `winding` (rad/s) while its
    integrator unloads. `contact` is N_1 (N), mu_s, mu_k and v_b (s/rad); `period` is that of a control step (s).
    """
    friction, step = Friction(*contact), period / _SUBSTEPS
    static = max(contact[0] * rig.r_1 * contact[1], _LEAST_STATIC)
    rate = rig.J_1 * haste.acceleration * np.pi / (2.0 * haste.build_up)
    stiffness = rig.k_1 * rig.k_2 / (rig.k_1 + rig.k_2)
    torque = min(torque, static)
    wind_up = _wind_up(torque, static, stiffness * (winding - rig.omega_s * torque / static), rate, step)
    acceleration = _acceleration(speed, haste, step)
    creep = rig.omega_s * wind_up / static  # the stuck bit of the adopted law (4-9)
    x_3 = np.concatenate([creep, rig.omega_s + np.cumsum(acceleration) * step])
    T_r1 = np.asarray(friction.torque(rig, x_3[len(wind_up) :]))
    T_12 = np.concatenate([wind_up, rig.J_1 * acceleration + T_r1 + rig.C_1 * x_3[len(wind_up) :]])
    missing = -len(x_3) % _SUBSTEPS
    x_3, T_12 = np.pad(x_3, (0, missing), mode="edge"), np.pad(T_12, (0, missing), mode="edge")
    references = _speed_reference(rig, x_3, T_12, step).reshape(-1, _SUBSTEPS).mean(axis=1)
    return Plan(step * np.arange(len(x_3), dtype=float), x_3, references)


def _wind_up(begin: float, end: float, first_rate: float, last_rate: float, step: float) -> FloatArray:
    """A cubic from torque `begin` to `end` (N m), with given rates (N m/s) at both."""
    duration = max(2.0 * (end - begin) / (first_rate + last_rate), 0.5)
    u = np.arange(0.0, 1.0, step / duration)
    by_rates = duration * u * (1.0 - u) * (first_rate * (1.0 - u) - last_rate * u)
    return np.asarray(begin + (end - begin) * u**2 * (3.0 - 2.0 * u) + by_rates)


def _acceleration(speed: float, haste: Haste, step: float) -> FloatArray:
    """Acceleration of the bit (rad/s^2) from break-loose to `speed`, then nothing for a while.

    It builds up as a quarter of a sine, stays level and dies away as half a cosine.
    """
    build_up = haste.build_up
    peak = min(haste.acceleration, speed / (build_up * (2.0 / np.pi + 0.5)))
    level = speed / peak - build_up * (2.0 / np.pi + 0.5)
    t = np.arange(0.0, 2.0 * build_up + level + _AFTERWARDS, step) + 0.5 * step
    up = np.sin(0.5 * np.pi * np.minimum(t / build_up, 1.0))
    down = np.clip((t - build_up - level) / build_up, 0.0, 1.0)
    return np.asarray(peak * up * 0.5 * (1.0 + np.cos(np.pi * down)))


def _speed_reference(rig: Rig, x_3: FloatArray, T_12: FloatArray, step: float) -> FloatArray:
    """The chain inverted, from bit speed and torque of the lower shaft to omega_ref, which is 0 at first."""
    rise = (T_12[1] - T_12[0]) / step
    x_4 = x_3 - _rate_of_lag(-T_12 / rig.k_1, rig.d_1 / rig.k_1, -rise / rig.k_1, step)
    T_23 = rig.J_2 * np.gradient(x_4, step) + T_12 + rig.T_r2 + rig.C_2 * x_4
    x_5 = x_4 - _rate_of_lag(-T_23 / rig.k_2, rig.d_2 / rig.k_2, -rise / rig.k_2, step)
    inertia = rig.J_3 * np.gradient(x_5, step)
    bearing = rig.eta**2 * rig.C_m * x_5 + rig.eta * rig.T_f + T_23
    volts = rig.R / (rig.eta * rig.K_T)
    voltage = volts * (inertia + bearing) + rig.eta * rig.K_E * x_5
    lag = rig.k_p / rig.k_i
    x_7 = (voltage[0] - volts * inertia[0]) / rig.k_i + lag * x_5[0]  # what omega_ref = 0 has left
    return np.asarray(x_5 + _rate_of_lag(voltage / rig.k_i, lag, (voltage[0] / rig.k_i - x_7) / lag, step))


def _rate_of_lag(aim: FloatArray, time_constant: float, first: float, step: float) -> FloatArray:
    """Rate x' of the lag `time_constant` x' + x = aim, which is `first` at first."""
    if time_constant < step:
        return np.asarray(np.gradient(aim, step))
    from scipy.signal import lfilter  # a second, which whoever looks for a policy need not wait

    half = 0.5 * step  # Tustin's rule, exact on a ramp
    forced = lfilter([1.0, -1.0], [time_constant + half, half - time_constant], aim - aim[0])
    return np.asarray(forced + first * np.exp(-step * np.arange(len(aim)) / time_constant))
