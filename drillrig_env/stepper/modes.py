"""Modes of a rig: linear systems that take turns, each a ladder of its own, with the edges at which it hands over.

A rig without T_r2 has one. With it disc 2 turns forwards, sticks, or turns backwards: T_r2 is a constant torque against
it, or within the stick zone |x_4| < omega_s a viscous one. A mode counts its states from an equilibrium of its own,
and says what it goes by: a quantity linear in the states, the edges between which the mode holds, and the mode
beyond each. `drillrig_env.stepper.switching` leads a step across an edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drillrig_env.drive import Drive
from drillrig_env.model import frictionless_state, with_stuck_collars
from drillrig_env.rig import Rig


def further_modes(rig: Rig) -> list[Rig]:
    """The rigs whose tables the modes of a rig have, beside its own."""
    return [with_stuck_collars(rig), rig] if rig.T_r2 > 0.0 else []


def join_modes(ladders: np.ndarray, rigs: Sequence[Rig], drive: Drive | None) -> None:
    """Say of the ladders of some rigs, and of those of their further modes after them, when each holds."""
    ladders["low"], ladders["high"] = -np.inf, np.inf
    sticks = len(rigs)
    for turns, rig in enumerate(rigs):
        if not further_modes(rig):
            continue
        turns_back, omega_s = sticks + 1, rig.omega_s
        for mode, low, high, below, above in (
            (turns, omega_s, np.inf, sticks, turns),
            (sticks, -omega_s, omega_s, turns_back, turns),
            (turns_back, -np.inf, -omega_s, turns_back, sticks),
        ):
            ladder = ladders[mode]
            ladder["has_modes"], ladder["below"], ladder["above"] = True, below, above
            ladder["low"], ladder["high"], ladder["kept"][3], ladder["kept_per_speed"] = low, high, 1.0, 1.0  # x_4
            ladder["kept_rate"][:7] = ladder["rate_from_state"][:, 3]
        untwisted = frictionless_state(replace(rig, T_r2=0.0), 0.0, drive)
        ladders["at_rest"][turns_back, :7] = 2.0 * untwisted - ladders["at_rest"][turns, :7]
        ladders["torque_at_rest"][turns_back] = -rig.T_r2
        sticks += 2
