"""A fleet: rigs of which every episode has one, given one by one, or drawn around a nominal rig.

Nobody knows a rig exactly. A policy that is to hold on the rig as it is, and not as the nameplate has it, is trained
and judged on many. Drawn parameters lie within a factor f of the nominal ones: the nominal value times f^(2 u - 1),
u uniform, so that doubled and halved values are as frequent.

The drive is a setting, not a part of the rig: k_p and k_i are the nominal rig's on every rig of a fleet. Rigs that
such a drive cannot hold still without friction are left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np

from drillrig_env.allowed import Allowed, Made
from drillrig_env.arrays import FloatArray
from drillrig_env.model import jacobian
from drillrig_env.parameters import POSITIVE, check_fields, checked, closest, parameter, refuse
from drillrig_env.rig import Rig, RigLike

GROUPS = {
    "string": ("k_1", "k_2", "d_1", "d_2"),
    "inertias": ("J_1", "J_2", "J_3"),
    "motor": ("L", "R", "K_T", "K_E", "C_m", "T_f"),
    "friction": ("mu_k", "mu_s - mu_k", "v_b"),
}
"""Names that stand for several parameters, each of which gets a factor of its own."""

_OF_THE_DRIVE = ("k_p", "k_i")
_OF_RIGS = tuple(item.name for item in fields(Rig) if item.name not in _OF_THE_DRIVE)
_NAMES = (*_OF_RIGS, *GROUPS["friction"])
_BESIDE = tuple(item.name for item in fields(Rig) if item.metadata["optional"])
_FIRST = tuple(name for name in _NAMES if name not in _BESIDE)
_FACTOR = Allowed(1.0, 1e3)
_LARGEST = Allowed(1, 1 << 16, whole=True)
_TRIES = 100
"""Draws for each rig that is wanted, of which at least one must be stable."""


@dataclass(frozen=True, eq=False)
class Members:
    """The rigs of a fleet around one nominal rig, the drive's gains being the nominal ones."""

    rigs: tuple[Rig, ...]
    friction: FloatArray  # (rigs, 3): factors of mu_k, of mu_s - mu_k and of v_b
    left_out: int  # draws that were left out

    def __len__(self) -> int:
        return len(self.rigs)


def _read_rigs(rigs: Any) -> tuple[Rig, ...]:
    if isinstance(rigs, str | Mapping) or not isinstance(rigs, Sequence):
        raise ValueError(f"{rigs!r} is not allowed; allowed: a list of rigs")
    return tuple(Rig.of(rig) for rig in rigs)


def _read_friction(friction: Any) -> tuple[tuple[float, float, float], ...]:
    rows = np.asarray(friction, dtype=float)
    if rows.size and (rows.ndim != 2 or rows.shape[1] != 3 or not POSITIVE.holds(rows)):
        raise ValueError(f"friction = {friction!r} is not allowed; allowed: three factors > 0 for each rig")
    return tuple((float(row[0]), float(row[1]), float(row[2])) for row in rows)


def _read_spread(spread: Any) -> dict[str, float]:
    """Factors by parameter, the names of groups resolved; what is named by itself goes before its group."""
    if not isinstance(spread, Mapping):
        raise ValueError(f"{spread!r} is not allowed; allowed: a dictionary of factors by name, as {{'string': 2.0}}")
    found: dict[str, float] = {}
    for name, factor in sorted(spread.items(), key=lambda item: item[0] not in GROUPS):
        if name in _OF_THE_DRIVE:
            raise ValueError(f"{name} is a setting of the drive, which is the nominal rig's; it cannot be spread")
        if name not in GROUPS and name not in _NAMES:
            raise ValueError(f"unknown parameter {name!r}; {closest(name, (*GROUPS, *_NAMES))}")
        for member in GROUPS.get(name, (name,)):
            found[member] = checked("spread", name, factor, "", _FACTOR)
    return {name: found[name] for name in _NAMES if name in found}


@dataclass(frozen=True)
class Fleet:
    """Rigs of which every episode draws one, all equally likely.

    Either `rigs` are given one by one, or `count` of them are drawn around a rig: see `around`. Raises `ValueError`
    for a value that is not allowed.

    >>> from drillrig_env import Fleet
    >>> fleet = Fleet.around(spread={"string": 2.0, "motor": 1.1}, count=8, seed=0)
    >>> len(fleet.members().rigs)
    8
    """

    rigs: tuple[Rig, ...] = parameter((), meaning="rigs given one by one", allowed=Made(_read_rigs, "a list of rigs"))
    friction: tuple[tuple[float, float, float], ...] = parameter(
        (),
        meaning="factors of mu_k, mu_s - mu_k and v_b on each of these rigs",
        allowed=Made(_read_friction, "three factors > 0 for each rig"),
    )
    rig: Rig | None = parameter(
        None, meaning="the rig that others are drawn around", allowed=Made(Rig.of, "a rig"), none="the nominal rig"
    )
    spread: dict[str, float] = parameter(
        factory=dict,
        meaning="factor within which each parameter is drawn, by its name or by that of a group",
        allowed=Made(_read_spread, f"factors {_FACTOR} by name: {', '.join(GROUPS)}, or single parameters"),
    )
    count: int = parameter(256, meaning="how many are drawn", allowed=_LARGEST)
    seed: int = parameter(0, meaning="seed of the draws", allowed=Allowed(0, whole=True))

    def __post_init__(self) -> None:
        check_fields(self)
        if self.rigs and self.spread:
            raise ValueError("Fleet: both rigs and a spread are given; allowed: one of them")
        if self.friction and len(self.friction) != len(self.rigs):
            raise refuse("Fleet", "rows of friction", len(self.friction), "", f"{len(self.rigs)}, one for each rig")
        if not self.rigs and not self.spread:
            raise ValueError("Fleet: neither rigs nor a spread is given; allowed: one of them")

    @classmethod
    def around(cls, rig: RigLike = None, *, spread: Mapping[str, float], count: int = 256, seed: int = 0) -> Fleet:
        """Rigs drawn around one: log-uniform factors within 1/f and f for each parameter named, all independent.

        `rig` is the one in the middle, the nominal rig of the environment where none is given. `spread` has the
        factor f by parameter, a name of `Rig` (but for k_p and k_i), "mu_k", "mu_s - mu_k" or "v_b", or by group:
        "string", "inertias", "motor", "friction". `count` rigs are drawn with `seed`; rigs without a stable drive are
        left out, and counted in `members(...).left_out`. A parameter's draws do not depend on which others are spread.

        >>> fleet = Fleet.around(spread={"string": 2.0, "motor": 1.1}, count=3)
        >>> [round(rig.k_2, 3) for rig in fleet.members().rigs]
        [0.565, 0.429, 0.315]
        """
        return cls(rig=None if rig is None else Rig.of(rig), spread=dict(spread), count=count, seed=seed)

    @classmethod
    def of(cls, fleet: FleetLike) -> Fleet | None:
        """A fleet as scenarios take it: a `Fleet`, a list of rigs, or a dictionary of the arguments of `around`.

        None stays None. Raises `ValueError` for anything else.
        """
        if fleet is None or isinstance(fleet, cls):
            return fleet
        if isinstance(fleet, Mapping):
            known = [item.name for item in fields(cls)]
            for name in fleet:
                if name not in known:
                    raise ValueError(f"fleet: unknown field {name!r}; {closest(name, known)}")
            return cls(**fleet)
        if isinstance(fleet, Sequence) and not isinstance(fleet, str):
            return cls(rigs=_read_rigs(fleet))
        allowed = "a Fleet, a list of rigs, or a dictionary with spread, count and seed"
        raise refuse("fleet", "rigs", repr(fleet), "", allowed)

    def members(self, nominal: RigLike = None) -> Members:
        """The rigs of the fleet where `nominal` (None: the chapter's) is the nominal rig.

        Raises `ValueError` where none of many draws is stable, and for a given rig that is not.
        """
        nominal = Rig.of(nominal)
        if self.rigs:
            return _given(self.rigs, self.friction, nominal)
        return _drawn(self.rig or nominal, nominal, tuple(self.spread.items()), self.count, self.seed)

    def __str__(self) -> str:
        if self.rigs:
            return f"{len(self.rigs)} rigs"
        spreads = ", ".join(f"{name} {factor:g}" for name, factor in self.spread.items())
        middle = "the nominal one" if self.rig is None else "a rig"
        return f"{self.count} rigs around {middle} (seed {self.seed}; {spreads})"


FleetLike: TypeAlias = Fleet | Mapping[str, Any] | Sequence[RigLike] | None
"""What `Fleet.of` takes."""


def side_by_side(rigs: Sequence[Rig]) -> Any:
    """The parameters of rigs with the attributes of a `Rig`, each an array of shape (rigs,).

    The functions of `drillrig_env.model` take them, and what is chosen of them by index, as they take a rig.
    """
    names = [item.name for item in fields(Rig)]
    rows = [tuple(getattr(rig, name) for name in names) for rig in rigs]
    return np.array(rows, dtype=[(name, "f8") for name in names]).view(np.recarray)


def with_gains_of(rig: Rig, nominal: Rig) -> Rig:
    """The rig with the gains of the nominal one's drive."""
    return replace(rig, **{name: getattr(nominal, name) for name in _OF_THE_DRIVE})


@lru_cache(maxsize=64)
def of_one(rig: Rig) -> Members:
    """A rig by itself."""
    return Members((rig,), np.ones((1, 3)), 0)


@lru_cache(maxsize=16)
def _given(rigs: tuple[Rig, ...], friction: tuple[tuple[float, float, float], ...], nominal: Rig) -> Members:
    driven = tuple(with_gains_of(rig, nominal) for rig in rigs)
    for number, rig in enumerate(driven):
        if not is_stable_without_friction(rig):
            raise ValueError(
                f"Fleet: rig {number} does not turn steadily with the nominal drive, even without friction"
            )
    return Members(driven, np.array(friction) if friction else np.ones((len(rigs), 3)), 0)


@lru_cache(maxsize=16)
def _drawn(rig: Rig, nominal: Rig, spread: tuple[tuple[str, float], ...], count: int, seed: int) -> Members:
    random, found, friction, left_out = np.random.default_rng(seed), list[Rig](), list[list[float]](), 0
    beside = np.random.default_rng([seed, 1])  # so that a parameter that few rigs have changes no fleet without it
    while len(found) < count:
        if left_out + len(found) == _TRIES * count:
            raise ValueError(
                f"Fleet: of {_TRIES * count} draws {len(found)} turn steadily with the nominal drive; allowed: a "
                "smaller spread, or another rig"
            )
        uniform = dict(zip(_FIRST, random.random(len(_FIRST)).tolist(), strict=True))
        uniform |= dict(zip(_BESIDE, beside.random(len(_BESIDE)).tolist(), strict=True))
        factors = {name: factor ** (2.0 * uniform[name] - 1.0) for name, factor in spread}
        changes = {name: getattr(rig, name) * factors[name] for name in _OF_RIGS if name in factors}
        drawn = with_gains_of(replace(rig, **changes), nominal)
        if not is_stable_without_friction(drawn):
            left_out += 1
            continue
        found.append(drawn)
        friction.append([factors.get(name, 1.0) for name in GROUPS["friction"]])
    return Members(tuple(found), np.array(friction), left_out)


def is_stable_without_friction(rig: Rig) -> bool:
    """Whether the rig turns steadily without friction."""
    return bool(np.linalg.eigvals(jacobian(rig)).real.max() < 0.0)
