"""Dry friction between brake pin and disc 1: the laws (4-7) and (4-9) and their slope (4-21), and others by name.

With a = |x_3| the discontinuous law is

    T_r1 = N_1 r_1 [mu_k + (mu_s - mu_k) f(v_b a)] sign(x_3),                                (4-7)

where f falls from 1 to 0:

| law | f(u) |
|---|---|
| exponential, the chapter's | exp(-u) |
| gaussian | exp(-u^2) |
| linear | 1 - u down to the floor 0, which it meets at the speed 1 / v_b: there the law has a kink |

The adopted law, the model of record, replaces it for a < omega_s by the straight line

    T_r1 = N_1 r_1 mu_s x_3 / omega_s.                                                       (4-9)

The chapter's line ends at mu_s, where the exponential has already fallen by a share v_b omega_s of its fall: a step
that is kept. The lines of all other laws lead to their value at omega_s, without a step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from drillrig_env.allowed import Made, OneARig
from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.friction.contact import EXPONENTIAL, LAWS
from drillrig_env.modules import is_place
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, check_fields, closest, describe, parameter, refuse
from drillrig_env.rig import Rig
from drillrig_env.toml import read_section, record_of, write_section

_TABLE = "table 4.1"
_LEAST_ZERO, _ABOVE_ZERO = OneARig(NOT_NEGATIVE), OneARig(POSITIVE)


_SHARES: dict[Any, Callable[[FloatArray], FloatArray]] = {
    "exponential": lambda u: np.exp(-u),
    "gaussian": lambda u: np.exp(-u * u),
    "linear": lambda u: np.maximum(1.0 - u, 0.0),
}
"""f(u) of the laws by name."""


def _law(law: Any) -> Any:
    """A law as a friction keeps it: a name, or a `Law`; of "file.py:name" that of the file."""
    if isinstance(law, str) and law in LAWS:
        return law
    from drillrig_env.friction.own import Law

    if is_place(law):
        return Law.from_file(law)
    if not isinstance(law, Law):
        raise ValueError(f"{law!r} is not known; {closest(law, (*LAWS, 'file.py:name', 'a Law'))}")
    return law


_ONE_OF = Made(_law, f"{', '.join(LAWS)}, file.py:name or a Law")


@dataclass(frozen=True, eq=False)
class Friction:
    """The contact of pin and disc. Each field is a number, or an array with one entry a rig.

    The default is the chapter's: table 4.1 at N_1 = 10 N. Raises `ValueError` for a value that is
    not allowed, for mu_s < mu_k, and for arrays whose shapes do not go together.

    >>> from drillrig_env import Friction, Rig
    >>> round(float(Friction(normal_force=20.0).torque(Rig(), 2.0)), 4)  # N m
    0.3223
    """

    normal_force: Quantity = parameter(10.0, "N", "normal force N_1 of the pin", "figures 4.8 to 4.13", _LEAST_ZERO)
    mu_s: Quantity = parameter(0.5, "", "static friction coefficient", _TABLE, _LEAST_ZERO)
    mu_k: Quantity = parameter(0.306, "", "kinetic friction coefficient", _TABLE, _LEAST_ZERO)
    v_b: Quantity = parameter(1.0, "s/rad", "decay factor of the friction with speed", _TABLE, _ABOVE_ZERO)
    _: KW_ONLY
    law: Any = parameter(LAWS[EXPONENTIAL], "", "how friction falls with speed", "(4-7)", _ONE_OF, optional=True)

    def __post_init__(self) -> None:
        check_fields(self)
        self.as_array()
        if np.any(np.asarray(self.mu_s) < np.asarray(self.mu_k)):
            raise refuse("Friction", "mu_s", self.mu_s, "", f">= mu_k = {self.mu_k}")

    def as_array(self, rigs: int | None = None) -> FloatArray:
        """The columns N_1, mu_s, mu_k, v_b as an array of shape (rigs, 4).

        `rigs` spreads single numbers over that many rigs; without it the fields' own length counts.
        """
        try:
            values = np.broadcast_arrays(
                *(np.atleast_1d(v) for v in (self.normal_force, self.mu_s, self.mu_k, self.v_b))
            )
            table = np.stack(values, axis=-1).astype(float)
            return table if rigs is None else np.ascontiguousarray(np.broadcast_to(table, (rigs, 4)))
        except ValueError as error:
            shapes = [np.shape(v) for v in (self.normal_force, self.mu_s, self.mu_k, self.v_b)]
            wanted = "one number, or one entry a rig" if rigs is None else f"one number, or {rigs} entries"
            raise ValueError(f"Friction: fields of shapes {shapes}; allowed for each: {wanted}") from error

    def single(self) -> Friction:
        """The friction of one rig with plain numbers as fields. `ValueError` for a batch of several."""
        table = self.as_array()
        if len(table) != 1:
            raise refuse("Friction", "number of rigs", len(table), "", "one here")
        return self.each()[0]

    def each(self) -> list[Friction]:
        """The friction of every rig of a batch, with plain numbers as fields."""
        return [Friction(*row, law=self.law) for row in self.as_array().tolist()]

    def contacts(self, rig: Rig, speed_reference: Quantity, rigs: int | None = None) -> np.ndarray:
        """The records of CONTACT for rigs that share `rig`, shape (rigs,); `rigs` as for `as_array`.

        `speed_reference` (rad/s) is one number, or one entry a rig.
        """
        from drillrig_env.friction.law import contacts_of, number_of

        normal_force, mu_s, mu_k, v_b = self.as_array(rigs).T
        return contacts_of(rig, normal_force, mu_s, mu_k, v_b, speed_reference, number_of(self.law))

    def break_loose(self, rig: Rig) -> Quantity:
        """The largest torque with which the bit sticks, at omega_s, in N m; N_1 r_1 mu_s, less the fall up to there.

        `rig` has r_1 and omega_s.
        """
        if self.law == LAWS[EXPONENTIAL]:
            return np.asarray(self.normal_force) * rig.r_1 * self.mu_s
        static: FloatArray = self._contacts(rig)["static"]
        return float(static) if static.ndim == 0 else static

    def torque(self, rig: Rig, bit_speed: Quantity) -> Quantity:
        """Torque of the adopted law (4-9) at a bit speed (rad/s), in N m; shapes broadcast.

        `rig` has r_1 and omega_s; `bit_speed` is of any shape.
        """
        return self._evaluate(rig, bit_speed)[0]

    def slope(self, rig: Rig, bit_speed: Quantity) -> Quantity:
        """Slope dT_r1/dx_3 of (4-9), the chapter's Delta T_r1 (4-21), in N m s/rad.

        `rig` has r_1 and omega_s; `bit_speed` (rad/s) is of any shape.
        """
        return self._evaluate(rig, bit_speed)[1]

    def curvature(self, rig: Rig, bit_speed: Quantity) -> Quantity:
        """Second derivative of (4-9) by x_3, in N m (s/rad)^2.

        `rig` has r_1 and omega_s; `bit_speed` (rad/s) is of any shape.
        """
        return self._evaluate(rig, bit_speed)[2]

    def torque_discontinuous(self, rig: Rig, bit_speed: Quantity) -> Quantity:
        """Torque of the discontinuous law (4-7), with the chapter's sign(0) = 1 (4-8), in N m; for laws by name.

        `rig` has r_1; `bit_speed` (rad/s) is of any shape.
        """
        x_3 = np.asarray(bit_speed, dtype=float)
        u = np.asarray(self.v_b) * np.abs(x_3)
        coefficient = self.mu_k + (np.asarray(self.mu_s) - self.mu_k) * _SHARES[self.law](u)
        torque = self.normal_force * rig.r_1 * coefficient * np.where(x_3 >= 0, 1.0, -1.0)
        return float(torque) if np.ndim(torque) == 0 else np.asarray(torque)

    def _evaluate(self, rig: Rig, bit_speed: Quantity) -> list[Quantity]:
        """Torque, slope and curvature."""
        from drillrig_env.friction.law import law_over

        x_3, contacts = np.broadcast_arrays(np.asarray(bit_speed, dtype=float), self._contacts(rig))
        found = [np.empty(x_3.shape) for _ in range(3)]
        law_over(np.array(x_3).ravel(), np.array(contacts).ravel(), *(each.reshape(-1) for each in found))
        return [float(each) if each.ndim == 0 else each for each in found]

    def _contacts(self, rig: Rig) -> np.ndarray:
        """Records of CONTACT in the shape that the fields have together."""
        from drillrig_env.friction.law import contacts_of, number_of

        fields = self.normal_force, self.mu_s, self.mu_k, self.v_b
        return contacts_of(rig, *fields, law=number_of(self.law))

    def falls_as(self, other: Friction) -> bool:
        """Whether another single friction is the same at any normal force. `other` is of one rig, as this one is."""
        own, its = ({**one.as_dict(), "normal_force": None} for one in (self, other))
        return own == its

    def as_dict(self) -> dict[str, Any]:
        """The fields of a single friction by name, plain numbers and the law's name; for files."""
        table = self.as_array()[0].tolist()
        return {**dict(zip(("normal_force", "mu_s", "mu_k", "v_b"), table, strict=True)), "law": str(self.law)}

    def describe(self) -> str:
        """A table of all fields with value, unit, meaning and source."""
        return describe(self)

    @classmethod
    def of(cls, friction: FrictionLike) -> Friction:
        """A friction as functions take it: None, a `Friction`, a dictionary of changes to the default, or a file.

        A file may stand for the folder with `friction.toml` in it. Raises as `Rig.of` does.
        """
        return record_of(cls, "friction", friction)

    @classmethod
    def from_toml(cls, path: str | Path) -> Friction:
        """Read a friction from the table `[friction]` of a TOML file; errors name file, key and range.

        `path` is the file.
        """
        return read_section(path, "friction", cls)

    def to_toml(self, path: str | Path) -> None:
        """Write a friction of single numbers as a TOML file that `from_toml` reads back unchanged, from any folder.

        `path` is the file, which is written over.

        Raises `ValueError` for a `Law` that was not read from a file, which no name leads back to.
        """
        if not isinstance(self.law, str) and not self.law.source:
            raise refuse("Friction", "law", self.law.name, "", 'in a file, a law of one: Law.from_file("file.py:name")')
        write_section(self if isinstance(self.law, str) else replace(self, law=self.law.placed()), path, "friction")


FrictionLike: TypeAlias = Friction | Mapping[str, Any] | str | Path | None
"""What `Friction.of` takes."""
