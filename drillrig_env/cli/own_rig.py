"""What a command takes on a rig where it is not told: the numbers of the chapter's rig, in the scales of that one."""

from __future__ import annotations

from dataclasses import dataclass

from drillrig_env.friction import Friction
from drillrig_env.rig import Rig, RigLike
from drillrig_env.scales import DURATION, Scales

SPEED_REFERENCE = 2.0
"""Speed reference of a run on the chapter's rig, rad/s."""

SAMPLE_PERIOD = 0.01
"""Sample period of a run on the chapter's rig, s."""

USUAL_FRICTION = "the chapter's, in the scales of the rig"
"""What a command's `--friction` is without a file, in words."""


@dataclass(frozen=True)
class Usual:
    """Friction, speed reference (rad/s), duration and sample period (s) of a run; `whose` says in words where from.

    Speed and times have three digits, so that what is printed is what is run.
    """

    friction: Friction
    speed_reference: float
    duration: float
    sample_period: float
    whose: str

    @classmethod
    def of(cls, rig: RigLike) -> Usual:
        """What is usual on a rig; on one that has no scales, and so cannot be an environment, what is on the chapter's.

        >>> usual = Usual.of(None)
        >>> usual.speed_reference, usual.duration, usual.sample_period, usual.friction.normal_force
        (2.0, 60.0, 0.01, 10.0)
        """
        rig = Rig.of(rig)
        try:
            return cls._at(Scales.of(rig), "the chapter's" if rig == Rig() else USUAL_FRICTION)
        except ValueError:
            return cls._at(Scales(), "the chapter's")

    @classmethod
    def _at(cls, scales: Scales, whose: str) -> Usual:
        numbers = SPEED_REFERENCE * scales.speed, DURATION * scales.duration, SAMPLE_PERIOD * scales.time
        speed, duration, period = (float(f"{number:.3g}") for number in numbers)
        return cls(scales.friction, speed, duration, period, whose)
