"""A disc that does not turn true: the normal force varies with its angle, N_1 (1 + a cos(m theta_1 + phi))."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from drillrig_env.allowed import SHARE, Allowed, Made
from drillrig_env.arrays import Quantity
from drillrig_env.parameters import check_fields, checked, parameter, refuse
from drillrig_env.toml import record_of

_TURNS = Allowed(0, 64, whole=True)


def _read_turns(turns: Any) -> tuple[int, ...]:
    """How often a turn, as a tuple; one number stands for itself."""
    given = list(turns) if isinstance(turns, tuple | list) else [turns]
    if not given:
        raise ValueError("none is not allowed; allowed: one number or several")
    return tuple(int(checked("Tilt", "turns", one, "", _TURNS)) for one in given)


@dataclass(frozen=True)
class Tilt:
    """N_1(theta_1) = N_1 (1 + a cos(m theta_1 + phi)), with theta_1 the angle of disc 1.

    Of several numbers m each episode of an environment draws one, and the angle at which it begins; where m is 0 the
    disc turns true, and the force is N_1. Raises `ValueError` for a value that is not allowed.

    >>> from drillrig_env import Tilt, simulate
    >>> run = simulate(speed_reference=3.0, duration=10.0, tilt=Tilt(0.1, 2))
    >>> bool(run.normal_force.max() > 10.9)  # N, and 10 N in the mean
    True
    """

    share: float = parameter(0.1, "", "a: how far the force varies, as a share of it", allowed=SHARE)
    turns: tuple[int, ...] = parameter(
        (1,),
        "",
        "m: how often a turn of the disc; 0: not at all",
        allowed=Made(_read_turns, f"{_TURNS}; one, or several"),
    )
    phase: float = parameter(0.0, "rad", "phi")

    def __post_init__(self) -> None:
        check_fields(self)

    @classmethod
    def of(cls, tilt: Any) -> Tilt:
        """A tilt as users give it: itself, changes to the default, or a TOML file with the table [tilt]."""
        return record_of(cls, "tilt", tilt)

    def of_one_disc(self) -> Tilt:
        """Itself. `ValueError` where there are several numbers m."""
        if len(self.turns) != 1:
            raise refuse("Tilt", "turns", self.turns, "", "one number here; an environment draws one of several")
        return self

    def factor(self, angle: Quantity) -> Quantity:
        """By which the disc presses more than N_1 at an angle theta_1 (rad); for one number m."""
        share = self.share if self.turns[0] else 0.0
        return np.asarray(1.0 + share * np.cos(self.turns[0] * np.asarray(angle) + self.phase))

    def put_on(self, contacts: np.ndarray, angle: float) -> None:
        """Tilt the disc of some records of CONTACT, with theta_1 = `angle` (rad) at the start; for one number m.

        `contacts` are changed in place.
        """
        contacts["tilt"], contacts["turns"] = self.share if self.turns[0] else 0.0, self.turns[0]
        contacts["angle"] = self.turns[0] * angle + self.phase
