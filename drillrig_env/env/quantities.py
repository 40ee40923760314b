"""What the record of an episode says, by name: for rewards of the user's own and for what only a critic sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.model import STATE_NAMES, STATE_UNITS


@dataclass(frozen=True)
class Entry:
    """One number of an episode: where its record has it, as a field of `drillrig_env.env.episode.EPISODE`."""

    name: str
    unit: str
    meaning: str
    field: str
    index: int | None = None

    def of(self, episodes: np.ndarray) -> FloatArray:
        """The number in each of n records; shape (n,), a copy."""
        column = episodes[self.field] if self.index is None else episodes[self.field][:, self.index]
        return np.array(column, dtype=float)

    @property
    def expression(self) -> str:
        """The number as code that reads it from a record called `episode`."""
        place = "" if self.index is None else f"[{self.index}]"
        return f"float(episode.{self.field}{place})"


_OF_STATES = (
    *("twist between bit and collars", "twist between collars and the motor's output"),
    *("speed of the bit", "speed of the collars", "speed of the motor's output"),
    *("armature current", "integral of speed reference less top speed"),
)

ENTRIES = (
    *(
        Entry(name, unit, meaning, "state", i)
        for i, (name, unit, meaning) in enumerate(zip(STATE_NAMES, STATE_UNITS, _OF_STATES, strict=True))
    ),
    Entry("speed_reference", "rad/s", "speed reference, held over the step", "speed_reference"),
    Entry("speed_target", "rad/s", "what the operator wants", "speed_target"),
    Entry("normal_force", "N", "N_1 of the pin during the step", "normal_force"),
    Entry("mu_s", "", "coefficient of friction before slip", "mu_s"),
    Entry("mu_k", "", "coefficient of friction at high speed", "mu_k"),
    Entry("v_b", "s/rad", "how fast friction falls with speed", "v_b"),
    Entry("torque_into_string", "N m", "torque into the string", "torque_into_string"),
    Entry("bit_speed_mean", "rad/s", "running mean of the bit speed", "mean"),
    Entry("bit_speed_variance", "rad^2/s^2", "its running variance", "variance"),
    Entry("bit_speed_average", "rad/s", "mean of the bit speed over the step", "average"),
    Entry("bit_speed_lowest", "rad/s", "lowest bit speed within the step", "lowest"),
    Entry("bit_speed_highest", "rad/s", "highest bit speed within the step", "highest"),
    Entry("stuck", "", "share of the step in which the bit stood", "stuck"),
    Entry("string_torque", "N m", "the drive's estimate of the mean torque into the string", "string_torque"),
    Entry("string_torque_highest", "N m", "highest torque into the string within the step", "highest_torque"),
    Entry("string_torque_mean", "N m", "running mean of that estimate", "torque_mean"),
    Entry("string_torque_variance", "N^2 m^2", "its running variance about that", "torque_variance"),
    Entry("voltage", "V", "armature voltage", "voltage"),
    Entry("reward_variance", "", "the default reward's term of this name", "terms", 0),
    Entry("reward_tracking", "", "the default reward's term of this name", "terms", 1),
    Entry("reward_action", "", "the default reward's term of this name", "terms", 2),
    Entry("step", "control steps", "done in this episode", "step"),
    Entry("delay", "control steps", "by which measurements come late", "delay"),
    Entry("rig", "", "index of the rig of the fleet", "rig"),
)
"""Everything that a record says, at the end of a control step where nothing else is said."""

BY_NAME = {entry.name: entry for entry in ENTRIES}
