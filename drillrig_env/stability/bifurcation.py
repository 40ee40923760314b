"""Bifurcation diagrams: e1, e2, p1 and p2 with their special points (figures 4.12 and 4.13), and beyond.

p1 and p2 are two branches that meet at the fold, where the orbit grazes the stick zone: walking p1
through that point would fail, since its multiplier jumps there. At heavy loads p1 turns back before it
gets there, at a higher speed. p1 is followed in the speed reference by shooting, each orbit from the
last; p2 in its depth by harmonic balance, which passes any turning point. The same is done in the normal
force at a fixed speed reference.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.parameters import POSITIVE, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stability.end_of_stick_slip import end_of_stick_slip
from drillrig_env.stability.equilibria import HopfPoint, equilibria, hopf_points
from drillrig_env.stability.fold import family_for, fold_speed, load_of
from drillrig_env.stability.limit_cycle import NoOrbitError, slipping_orbit_of_depth, stick_slip_orbit
from drillrig_env.stability.orbit import SIGNALS, PeriodicOrbit
from drillrig_env.stability.stable_sets import critical_speed

ORBIT = np.dtype(
    [
        ("speed_reference", "f8"),
        ("normal_force", "f8"),
        ("stable", "?"),
        ("period", "f8"),
        ("stuck", "f8"),
        *((f"lowest_{name}", "f8") for name in SIGNALS),
        *((f"highest_{name}", "f8") for name in SIGNALS),
        ("multipliers", "c16", 7),
    ]
)
"""A point of a branch of orbits: speeds in rad/s, current in A, period in s, `stuck` a share."""


_SHORT_OF_THE_FOLD = 1e-4
"""p1 is followed to this share before its end; closer to grazing, the stick phase is shorter than a millisecond."""

_WORDS = {
    "grazing": "the fold: the orbit's lowest bit speed reaches the stick zone's edge, and p2 begins",
    "fold": "a fold above that of p2: the orbit meets an unstable one that sticks as well",
    "other": "the orbit loses its stability",
}
"""Why p1 ends, in words."""


@dataclass(frozen=True, eq=False)
class Branch:
    """A branch of orbits as a table (records of ORBIT), and in words why it ends at either end.

    `label` is p1 or p2, `points` the table, `begins` and `ends` are the words.
    """

    label: str
    points: npt.NDArray[np.void]
    begins: str
    ends: str

    def table(self) -> dict[str, FloatArray]:
        """Columns by name, ready for `pandas.DataFrame`; multipliers as one column each."""
        columns = {name: self.points[name] for name in self.points.dtype.names or () if name != "multipliers"}
        return {**columns, **{f"multiplier_{i + 1}": self.points["multipliers"][:, i] for i in range(7)}}

    def to_csv(self, path: str | Path) -> None:
        """Write the table as CSV. `path` is the file, which is written over."""
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            table = self.table()
            writer.writerow(table)
            writer.writerows(zip(*(column.tolist() for column in table.values()), strict=True))


@dataclass(frozen=True, eq=False)
class Diagram:
    """A bifurcation diagram in the speed reference, for one friction.

    `rig` and `friction` are those that it is of, `hopf` the borders of stability, and p1 and p2 the orbits.

    `equilibria` are records of EQUILIBRIUM with the branches e1 and e2. `special` has H1, H2 and fold
    by name, rad/s, and end where p1 goes on above the fold (see `end_of_stick_slip`); it is empty, as are p1 and p2,
    where friction is too weak for stick-slip.
    """

    rig: Rig
    friction: Friction
    equilibria: npt.NDArray[np.void]
    p1: Branch
    p2: Branch
    hopf: list[HopfPoint]
    special: dict[str, float]


def bifurcation_diagram(
    rig: RigLike, friction: FrictionLike, points: int = 120, speeds: tuple[float, float] = (0.02, 5.0)
) -> Diagram:
    """The diagram of figures 4.12 and 4.13: `points` orbits on either branch, equilibria over `speeds` (rad/s).

    `rig` and `friction`, a single one, are given as `Rig.of` and `Friction.of` take them.

    Raises `ValueError` for fewer than 2 points or an impossible range.

    >>> from drillrig_env import Friction, Rig, stability
    >>> diagram = stability.bifurcation_diagram(Rig(), Friction(10.0), points=20)
    >>> {name: round(float(speed), 3) for name, speed in diagram.special.items()}  # rad/s
    {'H1': 0.001, 'H2': 1.995, 'fold': 2.901}
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    if points < 2:
        raise refuse("bifurcation_diagram", "points", points, "", ">= 2")
    if not POSITIVE.holds(np.array(speeds)) or speeds[0] >= speeds[1]:
        raise refuse("bifurcation_diagram", "speeds", speeds, "rad/s", "(low, high), > 0, low < high")
    friction = friction.single()
    hopf, end = hopf_points(rig, friction), end_of_stick_slip(rig, friction)
    grid = np.linspace(*speeds, 2 * points)
    if end.kind == "none":
        why = "no stick-slip: friction falls so slowly with speed that steady rotation is stable everywhere"
        nothing = np.zeros(0, dtype=ORBIT)
        p1, p2 = Branch("p1", nothing, why, why), Branch("p2", nothing, why, why)
        return Diagram(rig, friction, equilibria(rig, friction, grid), p1, p2, hopf, {})
    special = {point.label: point.speed_reference for point in hopf}
    special["fold"] = float(fold_speed(rig, friction) if friction.law == "exponential" else end.speed)
    if end.kind != "grazing" and friction.law == "exponential":
        special["end"] = float(end.speed)
    grid = np.unique(np.concatenate([grid, [point.speed_reference for point in hopf if point.label == "H2"]]))
    p1 = sticking_branch(rig, friction, _towards(speeds[0], float(end.speed), points))
    p2 = slipping_branch(rig, friction, points)
    return Diagram(rig, friction, equilibria(rig, friction, grid), p1, p2, hopf, special)


def sticking_branch(rig: Rig, friction: Friction, speeds: FloatArray) -> Branch:
    """p1 at the given speed references (rad/s), each orbit found from the last."""
    friction = friction.single()
    orbits: list[PeriodicOrbit] = []
    begins, ends = "the lowest speed asked for", "the highest speed asked for"
    for speed in speeds:
        guess = orbits[-1].state + (speed - orbits[-1].speed_reference) * np.eye(7)[2] if orbits else None
        try:
            orbits.append(stick_slip_orbit(rig, friction, float(speed), guess))
        except NoOrbitError as error:
            if orbits:
                ends = f"{error}"
                break
            begins = f"the lowest of the speeds asked for with such an orbit; {error}"
    end = end_of_stick_slip(rig, friction)
    if orbits and orbits[-1].speed_reference > float(end.speed) * (1.0 - 2.0 * _SHORT_OF_THE_FOLD):
        ends = _WORDS[str(end.kind)]
    return Branch("p1", _records(orbits), begins, ends)


def slipping_branch(rig: Rig, friction: Friction, points: int = 120) -> Branch:
    """p2 from the Hopf point H2 to the fold, equally spaced in its depth; empty where there is no fold."""
    friction = friction.single()
    fold, why = np.nan, "not followed: orbits that slip all the time are known for the exponential law alone"
    if friction.law == "exponential":
        fold, why = (
            float(fold_speed(rig, friction)),
            "no orbit slips all the time: friction falls within the stick zone",
        )
    if np.isnan(fold):
        return Branch("p2", np.zeros(0, dtype=ORBIT), why, why)
    deepest = float(friction.v_b) * (fold - rig.omega_s)
    depths = np.linspace(0.0, deepest, points + 1)[1:]
    family = family_for(rig, friction)
    orbits = [slipping_orbit_of_depth(family, friction, float(depth)) for depth in depths]
    return Branch(
        "p2", _records(orbits), "the Hopf point H2, with amplitude 0", "the fold: the orbit grazes the stick zone"
    )


def force_diagram(
    rig: RigLike, friction: FrictionLike, speed_reference: float, points: int = 60
) -> tuple[Branch, Branch]:
    """p1 and p2 over the normal force at one speed reference (rad/s); `friction`'s own N_1 is the largest.

    `rig` is given as `Rig.of` takes it; there are `points` orbits on either branch.

    p2 runs from the N_1 at which `speed_reference` is the fold up to that at which it is the critical
    speed; p1 ends at the former, or at the N_1 with which stick-slip ends at this speed. Raises
    `NoOrbitError` where the largest N_1 brings no stick-slip.

    >>> from drillrig_env import Friction, Rig
    >>> loads, _ = force_diagram(Rig(), Friction(), speed_reference=2.5, points=4)
    >>> loads.label, loads.points.dtype.names[:2]
    ('p1', ('speed_reference', 'normal_force'))
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    largest, load = float(friction.normal_force), float(load_of(rig, friction))
    fold = float(fold_speed(rig, friction))
    if not speed_reference < fold:
        raise NoOrbitError(f"no orbit up to {largest:g} N at {speed_reference:g} rad/s: the fold is {fold:.6g} rad/s")
    v_b = float(friction.v_b)
    family = family_for(rig, friction)
    depths = np.linspace(0.0, v_b * (speed_reference - rig.omega_s), points + 1)[1:]
    excess = load - v_b * (speed_reference - rig.omega_s)
    forces = largest * np.exp(family.guess(depths)[:, 0] - excess)
    slipping = [
        slipping_orbit_of_depth(family, replace(friction, normal_force=float(force)), float(depth))
        for force, depth in zip(forces, depths, strict=True)
    ]
    p2 = Branch(
        "p2", _records(slipping), "the Hopf point, with amplitude 0", "the fold: the orbit grazes the stick zone"
    )
    sticking = [stick_slip_orbit(rig, friction, speed_reference)]
    for force in _towards(largest, _least_force(rig, friction, speed_reference, float(forces[-1])), points)[1:]:
        guess = sticking[-1].state
        sticking.append(stick_slip_orbit(rig, replace(friction, normal_force=float(force)), speed_reference, guess))
    p1 = Branch("p1", _records(sticking), "the largest normal force asked for", "the fold: p2 begins")
    return p1, p2


def _least_force(rig: Rig, friction: Friction, speed_reference: float, at_grazing: float) -> float:
    """The normal force (N) at which stick-slip ends at a speed reference; `at_grazing` is that of the fold."""

    def excess(force: float) -> float:
        end = end_of_stick_slip(rig, replace(friction, normal_force=force))
        return float(end.speed) - speed_reference if end.kind != "grazing" or force < at_grazing else 0.0

    return float(brentq(excess, 0.5 * at_grazing, at_grazing, rtol=1e-9)) if excess(at_grazing) else at_grazing


def hopf_and_fold_curves(rig: RigLike, friction: FrictionLike, normal_forces: FloatArray) -> dict[str, FloatArray]:
    """Two-parameter curves: critical speed, fold and end of stick-slip (rad/s; NaN: none) over the normal force (N).

    `rig` and `friction`, of which the coefficients count, are given as `Rig.of` and `Friction.of` take them;
    `normal_forces` (N) have the shape (n,), and so has each curve.

    >>> import numpy as np
    >>> from drillrig_env import Friction, Rig, stability
    >>> curves = stability.hopf_and_fold_curves(Rig(), Friction(), np.array([10.0, 20.0]))
    >>> sorted(curves)
    ['critical_speed', 'end_of_stick_slip', 'fold_speed', 'normal_force']
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    frictions = replace(friction, normal_force=np.asarray(normal_forces, dtype=float))
    return {
        "normal_force": np.asarray(normal_forces, dtype=float),
        "critical_speed": np.asarray(critical_speed(rig, frictions)),
        "fold_speed": np.asarray(fold_speed(rig, frictions)),
        "end_of_stick_slip": np.asarray(end_of_stick_slip(rig, frictions).speed),
    }


def _towards(first: float, border: float, points: int) -> FloatArray:
    """Values from `first` to just short of `border`, closer together near it."""
    share = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, points))
    return first + (border - first) * (1.0 - _SHORT_OF_THE_FOLD) * share


def _records(orbits: Iterable[PeriodicOrbit]) -> npt.NDArray[np.void]:
    rows: list[tuple[Any, ...]] = [
        (
            orbit.speed_reference,
            float(orbit.friction.normal_force),
            orbit.stable,
            orbit.period,
            orbit.stuck,
            *orbit.lowest,
            *orbit.highest,
            orbit.multipliers,
        )
        for orbit in orbits
    ]
    return np.array(rows, dtype=ORBIT)
