"""What belongs to a rig and not to the code: the chapter rig's own numbers, and by what they grow on another rig.

Every number of the environment that has a unit was chosen on the chapter's rig. On another rig it is multiplied by
that rig's scale of its kind, which is exactly 1 on the chapter's:

| scale | rule |
|---|---|
| time | slowest torsional period, the top held still, over the chapter's 2.33 s |
| speed | largest speed reference over the chapter's 10 rad/s; where none is given, 1 / time: equal turns in a period |
| torque | speed times the impedance sqrt(k_2 (J_1 + J_2)) over the chapter's: a wave of that speed carries it |
| load | torque times the damping ratio of that mode over the chapter's, 1/10 to 1: what makes it as hard to calm |
| force | load over r_1, the friction coefficients being the chapter's |
| calming | time over that damping ratio: in which an oscillation dies |
| twist of a shaft | torque or load over its stiffness |
| current, voltage | of the motor amid the drawn speeds and loads; how far torque or viscous loss swings them |
| integral of the speed error | voltage over k_i; over that of a drive as stiff as the chapter's where one is given |

What a quantity is on average goes by load, by what it swings by torque. An episode is as long as (time + calming) / 2.

So a rig that is the chapter's with time running slower, torques scaled and angles scaled has exactly the environment
of the chapter's rig, scaled: bit for bit for powers of two.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from drillrig_env.allowed import POSITIVE
from drillrig_env.drive import Drive
from drillrig_env.friction import Friction
from drillrig_env.parameters import checked
from drillrig_env.rig import Rig, RigLike
from drillrig_env.slowest_mode import slowest_damping, slowest_period

CONTROL_PERIOD = 0.1
"""Length of a control step on the chapter's rig, over which the speed reference is held constant, s."""

SLEW_LIMIT = 2.0
"""Largest rate of the speed reference on the chapter's rig unless another is asked for, rad/s^2."""

LARGEST_REFERENCE = 10.0
"""Upper end of the speed reference on the chapter's rig, rad/s."""

DURATION = 60.0
"""Length of an episode on the chapter's rig unless another is asked for, s."""

_LEAST_DAMPING = 0.1  # of the chapter rig's damping ratio; a string without any would be loaded with nothing

_SPEED, _TORQUE = 3.0, 0.3  # rad/s and N m: the middle of what is drawn, for the motor's current and voltage
_SPEED_SWING, _CURRENT_SWING = 1.0, 0.5  # rad/s and A: by which speed and current of the motor swing
_TARGETS = 2.0  # rad/s: by which the targets that are drawn differ from the middle


_CHAPTER = Rig()


@dataclass(frozen=True)
class Scales:
    """By what the numbers of a rig grow beside the chapter's, each with a unit of its own kind; see the module.

    `speed` is that of its speeds. `Scales.of` finds it. `drive_given` tells that another drive than the rig's own turns
    it, one that is as stiff here as on the chapter's rig.
    """

    rig: Rig = field(default=_CHAPTER)
    speed: float = 1.0
    drive_given: bool = False

    @classmethod
    def of(cls, rig: RigLike = None, largest_reference: float | None = None) -> Scales:
        """The scales of a rig whose speed reference goes up to `largest_reference` (rad/s; None: by its period).

        >>> Scales.of(Rig()).time, Scales.of(Rig(), largest_reference=20.0).speed
        (1.0, 2.0)
        """
        rig = Rig.of(rig)
        if largest_reference is None:
            return cls(rig, 1.0 / cls(rig).time)
        largest = checked("Scales", "largest_reference", largest_reference, "rad/s", POSITIVE)
        return cls(rig, largest / LARGEST_REFERENCE)

    @property
    def time(self) -> float:
        """Of times: periods, time constants, windows."""
        return slowest_period(self.rig) / slowest_period(_CHAPTER)

    @property
    def rate(self) -> float:
        """Of accelerations."""
        return self.speed / self.time

    @property
    def duration(self) -> float:
        """Of the length of an episode."""
        return 0.5 * (self.time + self.calming)

    @property
    def torque(self) -> float:
        """Of torques."""
        return self.rig.impedance / _CHAPTER.impedance * self.speed

    @property
    def damping(self) -> float:
        """Of the damping ratio of the slowest mode, as far as loads go by it."""
        own, chapter = (slowest_damping(rig) / rig.impedance for rig in (self.rig, _CHAPTER))
        return min(max(own / chapter, _LEAST_DAMPING), 1.0)

    @property
    def load(self) -> float:
        """Of torques in steady rotation."""
        return self.torque * self.damping

    @property
    def calming(self) -> float:
        """Of the times in which an oscillation dies."""
        return self.time / self.damping

    @property
    def force(self) -> float:
        """Of normal forces."""
        return self.load / (self.rig.r_1 / _CHAPTER.r_1)

    @property
    def twist_12(self) -> float:
        """Of the twist between disc 1 and disc 2 in steady rotation."""
        return self.load / (self.rig.k_1 / _CHAPTER.k_1)

    @property
    def twist_12_swing(self) -> float:
        """Of changes of that twist."""
        return self.torque / (self.rig.k_1 / _CHAPTER.k_1)

    @property
    def twist_23(self) -> float:
        """Of the twist between disc 2 and motor in steady rotation."""
        return self.load / (self.rig.k_2 / _CHAPTER.k_2)

    @property
    def twist_23_swing(self) -> float:
        """Of changes of that twist."""
        return self.torque / (self.rig.k_2 / _CHAPTER.k_2)

    @property
    def current(self) -> float:
        """Of the current in steady rotation."""
        return self._current / _OWN._current

    @property
    def current_swing(self) -> float:
        """Of changes of the current, with the torque or, where viscous losses take more, with the speed."""
        rig = self.rig
        with_torque = self.torque / (rig.eta * rig.K_T / (_CHAPTER.eta * _CHAPTER.K_T))
        lost = (rig.eta * rig.eta * rig.C_m + rig.C_1 + rig.C_2) * _TARGETS * self.speed
        return max(with_torque, lost / (rig.eta * rig.K_T) / _CURRENT_SWING)

    @property
    def voltage(self) -> float:
        """Of the voltage in steady rotation."""
        return self._voltage / _OWN._voltage

    @property
    def voltage_swing(self) -> float:
        """Of changes of the voltage."""
        return self._voltage_swing / _OWN._voltage_swing

    @property
    def speed_error(self) -> float:
        """Of the integral of the speed error in steady rotation."""
        return self.voltage / self._integral_gain

    @property
    def speed_error_swing(self) -> float:
        """Of changes of that integral."""
        return self.voltage_swing / self._integral_gain

    @property
    def angle(self) -> float:
        """Of angles that the rig turns."""
        return self.speed * self.time

    @property
    def counted(self) -> Rig:
        """The rig with its parameters counted in these scales: one of about the size of the chapter's.

        Its angles are counted in `angle`, its currents and voltages in `current_swing` and `voltage_swing`. For a rig
        that is the chapter's scaled, it is the chapter's.
        """
        return self.count(self.rig)

    def count(self, rig: Rig) -> Rig:
        """Another rig, one of a fleet around this one, with its parameters counted in these scales."""
        stiffness, volt = self.torque / self.angle, self.voltage_swing
        damping, inertia = stiffness * self.time, stiffness * self.time**2
        return replace(
            rig,
            J_1=rig.J_1 / inertia,
            J_2=rig.J_2 / inertia,
            J_3=rig.J_3 / inertia,
            k_1=rig.k_1 / stiffness,
            k_2=rig.k_2 / stiffness,
            d_1=rig.d_1 / damping,
            d_2=rig.d_2 / damping,
            omega_s=rig.omega_s / self.speed,
            T_r2=rig.T_r2 / self.torque,
            r_1=rig.r_1 / (self.torque / self._force),
            L=rig.L / (volt * self.time / self.current_swing),
            R=rig.R / (volt / self.current_swing),
            K_T=rig.K_T / (self.torque / self.current_swing),
            K_E=rig.K_E / (volt / self.speed),
            C_m=rig.C_m / damping,
            C_1=rig.C_1 / damping,
            C_2=rig.C_2 / damping,
            T_f=rig.T_f / self.torque,
            k_p=rig.k_p / (volt / self.speed),
            k_i=rig.k_i / (volt / self.angle),
        )

    @property
    def units(self) -> dict[str, float]:
        """What `counted` counts in, by unit."""
        return {
            "rad": self.angle,
            "rad/s": self.speed,
            "A": self.current_swing,
            "V": self.voltage_swing,
            "N m": self.torque,
            "N": self._force,
            "s/rad": 1.0 / self.speed,
            "": 1.0,
        }

    def drive(self, drive: Drive, other: Scales) -> Drive:
        """The setting of this rig's drive that is as stiff, counted so, as `drive` is on a rig with `other` scales."""
        volts = _volts_per_torque(self.rig) / _volts_per_torque(other.rig)
        stiffness = (self.torque / self.angle) / (other.torque / other.angle)
        damping = stiffness * (self.time / other.time)
        limit = drive.current_limit
        return Drive(
            drive.k_p * damping * volts,
            drive.k_i * stiffness * volts,
            drive.back_emf_share,
            voltage_offset=drive.voltage_offset * (self.voltage_swing / other.voltage_swing),
            current_limit=None if limit is None else limit * (self.current_swing / other.current_swing),
        )

    @property
    def friction(self) -> Friction:
        """The chapter's friction on this rig, at the force that corresponds to 10 N."""
        chapter = Friction().single()
        return Friction(chapter.normal_force * self.force, chapter.mu_s, chapter.mu_k, chapter.v_b / self.speed)

    @property
    def _force(self) -> float:
        """What normal forces are counted in, so that the pin presses at the chapter's radius."""
        return self.torque / (self.rig.r_1 / _CHAPTER.r_1)

    @property
    def _integral_gain(self) -> float:
        """Of the integral gain of the drive that turns the rig."""
        if self.drive_given:
            return self.drive(Drive(_CHAPTER.k_p, _CHAPTER.k_i), _OWN).k_i / _CHAPTER.k_i
        return self.rig.k_i / _CHAPTER.k_i

    @property
    def _current(self) -> float:
        """Current (A) of the motor at the middle of what is drawn."""
        rig = self.rig
        resistance = rig.eta * rig.T_f + rig.eta * rig.eta * rig.C_m * _SPEED * self.speed
        discs = (rig.C_1 + rig.C_2) * _SPEED * self.speed
        return (_TORQUE * self.load + resistance + discs) / (rig.eta * rig.K_T)

    @property
    def _voltage(self) -> float:
        """Voltage (V) of the motor there."""
        return self.rig.R * self._current + self.rig.eta * self.rig.K_E * _SPEED * self.speed

    @property
    def _voltage_swing(self) -> float:
        """By what the voltage (V) changes with the torque and the speed."""
        rig = self.rig
        return rig.R * _CURRENT_SWING * self.current_swing + rig.eta * rig.K_E * _SPEED_SWING * self.speed


_OWN = Scales()


def _volts_per_torque(rig: Rig) -> float:
    """Voltage (V) that the motor needs for a torque behind the gear (N m)."""
    return rig.R / (rig.eta * rig.K_T)
