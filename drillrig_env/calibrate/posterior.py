"""A calibration read back from its folder: the rig, its friction, and joint draws of what they may be.

The draws make two fleets that have no rig in common: one to train and tune on, one to be judged on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.unknowns import OF_FRICTION, OF_RIGS, values_of
from drillrig_env.env.scenario import Scenario
from drillrig_env.files import digest, read_arrays, read_json
from drillrig_env.fleet import Fleet, is_stable_without_friction, with_gains_of
from drillrig_env.friction import Friction
from drillrig_env.parameters import POSITIVE, checked, refuse
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales

TRAINING, JUDGED = slice(0, None, 2), slice(1, None, 2)
"""Which of the draws are trained and tuned on, and on which others is judged."""

FILES = ("rig.toml", "friction.toml", "calibration.json", "draws.npz")
"""What a calibration is read from."""

_LEAST_STABLE = 0.5
"""Share of the draws whose drive must turn steadily."""

_DEFAULT = Scenario()
_SAME = 1e-9
_REMEDY = "make the folder anew with `drillrig calibrate ... --output`"


@dataclass(frozen=True, eq=False)
class Posterior:
    """What records say of a rig: the best fit, intervals, and joint draws, which go on into scenarios.

    `folder` is where they were read.

    `rig` and `friction` are the best fit, the friction at `load`, the largest normal force (N) of the records.
    `names` are the parameters that the fit looked for, `values` their joint draws, shape (draws, names), and
    `intervals` their value, low and high end of the 90 % interval. `digest` is the SHA-256 of the file of draws.
    """

    folder: Path
    rig: Rig
    friction: Friction
    load: float
    names: tuple[str, ...]
    values: FloatArray
    intervals: Mapping[str, tuple[float, float, float]]
    digest: str

    @classmethod
    def from_folder(cls, folder: str | Path) -> Posterior:
        """Read the folder that `drillrig calibrate --output` has written.

        Raises `FileNotFoundError` for a file that is missing, and `ValueError` for one that is damaged or does not
        go with the others, each naming the file.
        """
        folder = Path(folder)
        for name in FILES:
            if not (folder / name).is_file():
                raise FileNotFoundError(
                    f"{folder} is no folder of a calibration: {name} is missing; allowed: one that "
                    "`drillrig calibrate ... --output` has written"
                )
        rig, friction = Rig.from_toml(folder / "rig.toml"), Friction.from_toml(folder / "friction.toml").single()
        load, intervals = _read_intervals(folder / "calibration.json")
        own = values_of(rig, friction)
        for name, (value, _, _) in intervals.items():
            if abs(own[name] - value) > _SAME * abs(value):
                file = "friction.toml" if name in OF_FRICTION else "rig.toml"
                allowed = f"{value:.9g}, of which calibration.json and the draws are; or the file by itself, --rig FILE"
                raise refuse(str(folder / file), name, f"{own[name]:.9g}", "", allowed)
        names, values = _read_draws(folder / "draws.npz")
        if names != tuple(intervals):
            raise ValueError(
                f"{folder / 'draws.npz'} is damaged: its names are not those of calibration.json; {_REMEDY}"
            )
        return cls(folder, rig, friction, load, names, values, intervals, digest(folder / "draws.npz"))

    @property
    def name(self) -> str:
        """The folder's own name."""
        return self.folder.resolve().name

    @property
    def origin(self) -> dict[str, str]:
        """The folder's name and the digest of its draws, by which results tell where their rigs are from."""
        return {"folder": self.name, "draws": self.digest}

    @property
    def training(self) -> Fleet:
        """The rigs to train and tune on; `ValueError` where the drive turns too few of them steadily."""
        return self._fleet(TRAINING)

    @property
    def judged(self) -> Fleet:
        """The rigs to be judged on, none of which is of `training`; raises likewise."""
        return self._fleet(JUDGED)

    def scenario(
        self, rigs: Fleet | None, base: str | Mapping[str, Any] | Scenario = "default", scales: Scales | None = None
    ) -> Scenario:
        """A scenario on these rigs, with the friction of the calibration and its load: see `scenario_on`.

        `base` is what `Scenario.named` takes, with numbers of a rig with these `scales` (None: this rig's own).
        `ValueError` where no record had a load, so that nothing is known of the friction.
        """
        self.check_load()
        scales = Scales.of(self.rig) if scales is None else scales
        return scenario_on(rigs, self.friction, self.load, base, scales)

    def check_load(self) -> None:
        """Raise `ValueError` where no record had a load."""
        if not self.load > 0.0:
            raise ValueError(
                f"{self.folder}: no record had a load, so that nothing is known of the friction; allowed: a "
                "calibration to records with a normal force above 0 N"
            )

    def _fleet(self, part: slice) -> Fleet:
        values = self.values[part]
        fleet = fleet_of(self.rig, self.friction, self.names, values)
        if len(fleet.rigs) < _LEAST_STABLE * len(values):
            told = f"{len(fleet.rigs)} of {len(values)} draws"
            raise ValueError(
                f"{self.folder}: the drive turns {told} steadily; allowed: half of them at least; records that "
                "determine the rig better, or more that is fixed"
            )
        return fleet


def scenario_on(
    rigs: Fleet | None,
    friction: Friction,
    load: float,
    base: str | Mapping[str, Any] | Scenario,
    scales: Scales,
) -> Scenario:
    """A scenario on some rigs, with a friction and loads of their own; what else it draws is that of `base`.

    `base` is what `Scenario.named` takes, with numbers of a rig with these `scales`. Its normal forces become such that
    the largest of the default draws is `load` (N). What it spreads beyond the default draws stays: what those spread
    stands for not knowing the friction, and here `rigs` have the friction as far as it is known. In a dictionary, what
    it gives of all these itself is kept.
    """
    scenario, factor = Scenario.named(base, scales), force_factor(load, scales)
    found: dict[str, Any] = {
        "rigs": rigs,
        "friction": friction,
        "spread": max(0.0, scenario.spread - _DEFAULT.spread),
        "normal_force": _grown(scenario.normal_force, factor),
        "load_force": scenario.load_force and _grown(scenario.load_force, factor),
    }
    given = base if isinstance(base, Mapping) else ()
    return replace(scenario, **{name: value for name, value in found.items() if name not in given})


def force_factor(load: float, scales: Scales) -> float:
    """By what the normal forces of scenarios in such `scales` are multiplied, for the default draws to reach `load`."""
    return load / (_DEFAULT.normal_force[1] * scales.force)


def fleet_of(rig: Rig, friction: Friction, names: Sequence[str], values: FloatArray) -> Fleet:
    """Joint draws as rigs of a fleet around the best fit `rig` and `friction`; `values` has shape (draws, names).

    The drive's gains are settings: in an environment they are those of its nominal rig, which is to be `rig`. Draws
    whose drive does not turn steadily are left out; `ValueError` where none does.
    """
    best, rigs, factors = values_of(rig, friction), [], []
    for row in values.tolist():
        drawn = dict(zip(names, row, strict=True))
        one = replace(rig, **{name: value for name, value in drawn.items() if name in OF_RIGS})
        one = with_gains_of(one, rig)
        if is_stable_without_friction(one):
            rigs.append(one)
            mu_k, fall, v_b = (drawn.get(name, best[name]) / best[name] for name in OF_FRICTION)
            factors.append((mu_k, fall, v_b))
    if not rigs:
        raise ValueError(f"calibrate: the drive turns none of {len(values)} draws steadily; allowed: one at least")
    return Fleet(rigs=tuple(rigs), friction=tuple(factors))


def _read_intervals(path: Path) -> tuple[float, dict[str, tuple[float, float, float]]]:
    """Load (N), and value, low and high end of each parameter's interval."""
    content = read_json(path, _REMEDY)
    try:
        rows = {name: (row["value"], row["low"], row["high"]) for name, row in content["parameters"].items()}
        numbers = [content["load"], *(number for row in rows.values() for number in row)]
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{path} is damaged: parameters or load are missing ({error}); {_REMEDY}") from error
    if not all(isinstance(number, int | float) and np.isfinite(number) and number >= 0.0 for number in numbers):
        raise ValueError(f"{path} is damaged: load or parameters are no numbers >= 0; {_REMEDY}")
    for name in rows:
        if name not in (*OF_RIGS, *OF_FRICTION):
            raise ValueError(f"{path} is damaged: it has a parameter {name!r}, which no rig has; {_REMEDY}")
    return float(content["load"]), rows


def _read_draws(path: Path) -> tuple[tuple[str, ...], FloatArray]:
    """Names and joint draws, shape (draws, names)."""
    arrays = read_arrays(path, _REMEDY)
    if not {"names", "values"} <= set(arrays):
        raise ValueError(f"{path} is damaged: it has no arrays names and values; {_REMEDY}")
    names, values = tuple(str(name) for name in np.atleast_1d(arrays["names"])), arrays["values"]
    if values.dtype.kind != "f" or values.ndim != 2 or values.shape[1] != len(names) or len(values) < 2:
        told = f"values of shape {values.shape} for {len(names)} names"
        raise ValueError(f"{path} is damaged: {told}; {_REMEDY}")
    for name, column in zip(names, values.T, strict=True):
        for value in column:
            checked(str(path), name, float(value), "", POSITIVE)
    return names, values


def _grown(span: tuple[float, float], factor: float) -> tuple[float, float]:
    return span[0] * factor, span[1] * factor
