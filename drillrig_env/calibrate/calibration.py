"""From records to a rig: one call that fits, and what comes out with how well it is known."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.beside_rig import check_records
from drillrig_env.calibrate.fit import FARTHEST, Best, fit
from drillrig_env.calibrate.followed import check_followed
from drillrig_env.calibrate.held_out import HELD_OUT, SHARE, split
from drillrig_env.calibrate.kept import Kept
from drillrig_env.calibrate.posterior import fleet_of
from drillrig_env.calibrate.projection import Problem
from drillrig_env.calibrate.records import Record
from drillrig_env.calibrate.search import Search
from drillrig_env.calibrate.spread import LEAST_WINDOWS, Spread, spread_of
from drillrig_env.calibrate.unknowns import OF_FRICTION, Unknowns
from drillrig_env.calibrate.windows import Windows
from drillrig_env.engine import Engine, used
from drillrig_env.fleet import Fleet
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.parameters import COUNT, POSITIVE, checked, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.scales import Scales

if TYPE_CHECKING:
    from drillrig_env.calibrate.laws import LawScore
    from drillrig_env.calibrate.sampled import Sampling

WINDOW, STEP = 3.0, 0.01
"""Length of a window, and shortest step of its grid, s on the chapter's rig."""

STARTS, DRAWS = 24, 64

BY_RECORDS, NOT_BY_RECORDS = "by the records", "not determined by these records"
AT_BOUND = "at a bound of the fit"
"""How a parameter is known."""

_NEAR = 0.99
"""Of the way to a bound: there a parameter stands at it."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """A rig as records tell it: the best fit, how well it is known, and joint draws of what it may be.

    `records` are what was fitted, and `best` is the fit; `spread` says how far the parameters' logarithms may be off,
    `draws` are the joint draws, made with `seed` and, where by emcee, by `sampling`. `held` are windows that the fit
    has not seen, `laws` the scores of laws of friction, where one was chosen.
    """

    records: tuple[Record, ...]
    best: Best
    spread: Spread
    draws: FloatArray  # (DRAWS, names): logarithms of the parameters, joint
    seed: int
    held: tuple[Windows, ...] = ()  # of each record those that the fit has not seen
    sampling: Sampling | None = None  # how the draws were made, where by emcee
    laws: tuple[LawScore, ...] = ()  # of friction that were fitted, the best first, where it was chosen

    @property
    def unknowns(self) -> Unknowns:
        """What was looked for."""
        return self.best.problem.unknowns

    @property
    def rig(self) -> Rig:
        """The rig that fits best."""
        return self.unknowns.at(self.best.logs)[0]

    @property
    def friction(self) -> Friction:
        """Its friction, at the `load`; without any, at the normal force of the one that the fit began with."""
        friction = self.unknowns.at(self.best.logs)[1]
        return replace(friction, normal_force=self.load) if self.load > 0.0 else friction

    @property
    def load(self) -> float:
        """The largest normal force of the records, N."""
        return float(max(one.forces.max() for one in self.best.problem.windows))

    def interval(self, name: str, share: float = 0.9) -> tuple[float, float]:
        """Between which values a parameter lies with a probability, by its name.

        `name` is that name, `share` the probability, 0 to 1.
        """
        k = self.unknowns.names.index(name)
        value = self.unknowns.values(self.best.logs)[name]
        away = float(np.exp(self.spread.interval(share)[k]))
        return value / away, value * away

    def rigs(self) -> list[tuple[Rig, Friction]]:
        """The joint draws as rigs and their frictions."""
        return [self.unknowns.at(logs) for logs in self.draws]

    def fleet(self, part: slice = slice(None)) -> Fleet:
        """The joint draws as rigs of a fleet, for `Scenario(rigs=...)` with the best `friction`; or a `part` of them.

        The drive's gains are settings: in an environment they are those of its nominal rig, which is to be `rig`. Draws
        whose drive does not turn steadily are left out; `ValueError` where none does. `TRAINING` and `JUDGED` of
        `drillrig_env.calibrate.posterior` are the two halves.
        """
        unknowns = self.unknowns
        values = np.array([list(unknowns.values(logs).values()) for logs in self.draws[part]])
        return fleet_of(self.rig, self.friction, unknowns.names, values)

    def rows(self) -> list[tuple[str, float, float, float, str]]:
        """A row for each parameter that was looked for: name, value, 90 % interval, and how it is known."""
        found = []
        for name, log, determined in zip(self.unknowns.names, self.best.logs, self.spread.determined, strict=True):
            low, high = self.interval(name)
            told = AT_BOUND if abs(log) > _NEAR * FARTHEST else BY_RECORDS if determined else NOT_BY_RECORDS
            found.append((name, self.unknowns.values(self.best.logs)[name], low, high, told))
        return found


def calibrate(
    records: Sequence[Record],
    rig: RigLike = None,
    friction: FrictionLike = None,
    *,
    fix: Mapping[str, float | None] | None = None,
    weigh: Mapping[str, float] | None = None,
    starts: int = STARTS,
    seed: int = 0,
    window: float | None = None,
    held_out: float = HELD_OUT,
    told: Callable[[int, float], None] | None = None,
    begin: FloatArray | None = None,
    engine: Engine | str | None = None,
    kept: Kept | None = None,
) -> Calibration:
    """Fit a rig and its friction to records of it, each with speed reference and normal force.

    The fit begins from `rig` and `friction` and from `starts` places around them, drawn by `seed`. `fix` holds
    parameters at a value, or with None where they are; `weigh` has the relative standard deviation of what has been
    measured by itself, such as {"J_1": 0.02}. Speeds, currents and voltages leave one common scale of all torques open,
    which one weighed disc, K_T, or the torque into the string closes. `window` (s) is the length of the pieces that a
    record is cut into, each with a start of its own, by default 1.3 of the rig's slowest periods. The share `held_out`
    of each record's windows is not fitted, and tells afterwards how good the fit is. `told` hears how many starts are
    done and the best cost so far. `begin`, the `best.logs` of another fit of the same parameters, is where it begins in
    their place. `engine` does the starts, such as `Local(4)`, four processes, or "ray" (`drillrig_env.engine`), to
    the same result, to the last bit, as this process, the default. `kept` keeps the starts that are done in its file,
    and has those of a search that was stopped.

    Raises `ValueError` for a record without inputs, too short, or of no rig like the one that the fit begins with, an
    unknown parameter, fewer than 4 windows, and a best model that is nowhere near the records; `NotFiniteError` where
    the model runs away from every start.
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    starts = checked("calibrate", "starts", starts, "", COUNT)
    unknowns = Unknowns.of(rig, friction, fix, weigh)
    windows = windows_of(records, rig, window)
    count = sum(map(len, windows))
    if count < LEAST_WINDOWS:
        length = windows[0].period * windows[0].data.shape[1]
        sources = ", ".join(one.source for one in records)
        allowed = f">= {LEAST_WINDOWS}, here of {length:.3g} s; longer records, or shorter windows"
        raise refuse(sources, "number of windows", count, "", allowed)
    check_records(list(records), windows, rig, unknowns.friction)
    windows, held = split(windows, checked("calibrate", "held_out", held_out, "", SHARE))
    if not any(np.any(one.forces > 0.0) for one in windows):  # nothing presses: friction cannot be seen
        weigh = {name: share for name, share in (weigh or {}).items() if name not in OF_FRICTION}
        unknowns = Unknowns.of(rig, friction, {**dict.fromkeys(OF_FRICTION), **(fix or {})}, weigh)
    with used(engine) as at:
        search = Search(at, kept)
        best = fit(Problem(windows, unknowns, [one.noise for one in windows]), starts, seed, told, search, begin)
    check_followed(records, best)
    spread = spread_of(best)
    return Calibration(tuple(records), best, spread, best.logs + spread.draws(DRAWS, seed), seed, tuple(held))


def windows_of(records: Sequence[Record], rig: Rig, window: float | None) -> list[Windows]:
    """The windows of each record, of `window` s or by the rig's slowest period."""
    if not records:
        raise ValueError("calibrate: no record is given; allowed: at least one")
    time = Scales.of(rig).time
    length = WINDOW * time if window is None else checked("calibrate", "window", window, "s", POSITIVE)
    return [Windows.of(one, max(one.sample_period, STEP * time), length) for one in records]
