"""How a simulated run ends: the range of its bit speed, and whether that is stick-slip or calm."""

from __future__ import annotations

from dataclasses import dataclass

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.simulation import Simulation, simulate
from drillrig_env.verdict import STUCK_SPEED, WINDOW, is_calm


@dataclass(frozen=True)
class Ending:
    """Lowest, highest and mean bit speed (rad/s) over the last seconds of a run; as text: the verdict and the range."""

    lowest: float
    highest: float
    mean: float

    @property
    def calm(self) -> bool:
        """Whether the bit rotates calmly, as everywhere in this package."""
        return bool(is_calm(self.lowest, self.highest, self.mean))

    @property
    def sticks(self) -> bool:
        """Whether the bit comes to a stop and is not calm."""
        return self.lowest < STUCK_SPEED and not self.calm

    def __str__(self) -> str:
        if self.calm:
            return f"calm at {self.mean:.3f} rad/s"
        word = "stick-slip" if self.sticks else "vibration without sticking"
        return f"{word}, bit speed {self.lowest:.3f} to {self.highest:.3f} rad/s"


def ending_of(run: Simulation) -> Ending:
    """The ending of a run."""
    tail = run.bit_speed[run.time > run.time[-1] - WINDOW]
    return Ending(float(tail.min()), float(tail.max()), float(tail.mean()))


def ending(rig: Rig, friction: Friction, state: FloatArray, speed_reference: float) -> Ending:
    """The ending of 300 s from a state at a constant speed reference (rad/s)."""
    return ending_of(simulate(rig, friction, state, speed_reference, duration=300.0))
