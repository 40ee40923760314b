"""All that is said of a calibration: in a terminal, on its page and in calibration.json."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from drillrig_env.calibrate import cycles, judged
from drillrig_env.calibrate.agree import Disagreement, disagreement_words, disagreements
from drillrig_env.calibrate.beside import Beside, beside
from drillrig_env.calibrate.borders import Borders, borders, loads
from drillrig_env.calibrate.calibration import AT_BOUND, Calibration
from drillrig_env.calibrate.cycles import Cycles, cycle_rows
from drillrig_env.calibrate.fit import FARTHEST
from drillrig_env.calibrate.judged import Judged, judged_rows
from drillrig_env.calibrate.laws import LAW_HEADINGS, law_rows, law_words
from drillrig_env.calibrate.meaning import SPEEDS, Meaning, band, meanings_of
from drillrig_env.calibrate.misfit import Misfit, misfit_words, misfits
from drillrig_env.calibrate.sampled import draw_words
from drillrig_env.calibrate.unknowns import UNITS
from drillrig_env.engine import Engine
from drillrig_env.evaluation.provenance import provenance

_NOT_FOLLOWED = "Parameters of a model that does not follow the records: do not believe these intervals"


@dataclass(frozen=True, eq=False)
class Report:
    """A calibration, how well it follows the records, and what it means."""

    calibration: Calibration
    command: str
    parts: list[Beside]
    judged: list[Judged]
    cycles: list[Cycles]
    misfits: list[Misfit]
    borders: Borders | None  # None where the records have no load
    means: list[Meaning]
    disagreements: list[Disagreement]
    drawn: list[str]  # what is to be said of the joint draws

    @classmethod
    def of(
        cls,
        calibration: Calibration,
        command: str,
        told: Callable[[int, int], None] | None = None,
        draws: int | None = None,
        engine: Engine | str | None = None,
    ) -> Report:
        """The report of a calibration that a `command` line has made; `told`, `draws` and `engine` as for `borders`."""
        parts = beside(calibration)
        forces = loads(calibration)
        found = borders(calibration, forces, draws, told, engine) if len(forces) else None
        return cls(
            calibration,
            command,
            parts,
            judged.judged(calibration, parts),
            cycles.cycles(calibration, parts),
            misfits(calibration, parts),
            found,
            [] if found is None else meanings_of(found),
            disagreements(calibration),
            draw_words(calibration),
        )

    def tables(self) -> list[tuple[str, list[str], list[list[str]]]]:
        """A title, headings and rows for each table."""
        found = [
            (_NOT_FOLLOWED if self.misfits else "Parameters", PARAMETERS, parameter_rows(self.calibration)),
            ("How well the model follows the records", judged.HEADINGS, judged_rows(self.judged)),
            ("Cycles of vibration", cycles.HEADINGS, cycle_rows(self.cycles)),
        ]
        if self.calibration.laws:
            found.append(("Laws of friction, the best first", LAW_HEADINGS, law_rows(self.calibration.laws)))
        return [one for one in found if one[2]]

    def sentences(self) -> list[str]:
        """What the calibration means, and where the model does not follow the records."""
        load = f"at N_1 = {self.calibration.load:.4g} N: "
        laws = [law_words(self.calibration.laws)] if self.calibration.laws else []
        apart = disagreement_words(self.disagreements)
        unloaded = "no record has a load: friction, critical speed and end of stick-slip are not determined"
        means = [load + str(one) for one in self.means] or [unloaded]
        return [*misfit_words(self.misfits), *laws, *means, *apart, *_at_bounds(self.calibration), *self.drawn]

    def summary(self) -> dict[str, Any]:
        """What is known, for calibration.json."""
        calibration, best = self.calibration, self.calibration.best
        return {
            "parameters": {
                name: {"value": value, "low": low, "high": high, "known": told}
                for name, value, low, high, told in calibration.rows()
            },
            "probability": 0.9,
            "load": calibration.load,
            "means": {one.name: {**_fields(one), "determined": one.determined} for one in self.means},
            "map": None if self.borders is None else _map(self.borders),
            "misfits": [asdict(one) for one in self.misfits],
            "disagreements": [asdict(one) for one in self.disagreements],
            "judged": [asdict(one) for one in self.judged],
            "cycles": [asdict(one) for one in self.cycles],
            "sampling": calibration.sampling and asdict(calibration.sampling),
            "laws": [asdict(one) for one in calibration.laws],
            "cost": best.cost,
            "costs": best.costs.tolist(),
            "starts": best.starts,
            "stopped": best.stopped,
            "windows": calibration.spread.windows,
            "held_out": sum(map(len, calibration.held)),
            "records": [
                {"file": one.source, "sha256": one.digest, "notes": list(one.notes)} for one in calibration.records
            ],
            "seed": calibration.seed,
            "command": self.command,
            "made": provenance(),
        }


def _fields(one: Meaning) -> dict[str, Any]:
    return {name: value for name, value in asdict(one).items() if name != "name"}


def _map(borders: Borders) -> dict[str, Any]:
    """The speeds (rad/s) over the normal force (N) with their 90 % intervals, null where there is no number."""
    found: dict[str, Any] = {"normal_force": borders.normal_force.tolist()}
    for i, name in enumerate(SPEEDS):
        low, high = band(borders.draws[:, i])
        found[name] = {"value": borders.best[i].tolist(), "low": low.tolist(), "high": high.tolist()}
    return found


def _at_bounds(calibration: Calibration) -> list[str]:
    """A sentence for the parameters that stand at a bound of the fit, where there are any."""
    names = [row[0] for row in calibration.rows() if row[4] == AT_BOUND]
    if not names:
        return []
    why = "begin the fit nearer (--rig, --friction), fix or weigh it, or look for what else is wrong"
    return [f"At a bound, {np.exp(FARTHEST):.0f} times off where the fit began: {', '.join(names)}; {why}"]


PARAMETERS = ["parameter", "value", "unit", "90 % interval", "+-", "known"]


def parameter_rows(calibration: Calibration) -> list[list[str]]:
    """A row of text for each parameter, under `PARAMETERS`."""
    return [
        [name, f"{value:.4g}", UNITS[name], f"{low:.4g} to {high:.4g}", f"{50.0 * (high - low) / value:.1f} %", told]
        for name, value, low, high, told in calibration.rows()
    ]
