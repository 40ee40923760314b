"""What intervals of calibrated twins held: kept in a file twin by twin, and the page made of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from drillrig_env import markdown
from drillrig_env.evaluation.provenance import in_words, provenance
from drillrig_env.evaluation.statistics import Estimate, over_rigs, rate
from drillrig_env.files import json_text, read_json, write_text

USUAL = 0.5
"""A parameter that is determined in fewer of the twins is no candidate for the worst."""

Twin: TypeAlias = tuple[str, int]
"""A kind of twin and the seed of one."""


@dataclass(frozen=True)
class Coverage:
    """What the intervals of one twin held, by name, and whether its report told of a misfit."""

    parameters: dict[str, bool]  # of those that the fit calls determined
    speeds: dict[str, bool]
    misfit: bool


@dataclass
class Results:
    """What has been found so far, in its file."""

    path: Path
    found: dict[Twin, Coverage] = field(default_factory=dict)
    made: dict[str, Any] = field(default_factory=provenance)

    @classmethod
    def read(cls, path: Path, anew: bool = False) -> Results:
        """What a file holds; nothing where there is none, or `anew`. `ValueError` where it is damaged."""
        if anew or not path.exists():
            return cls(path)
        remedy = "take another one with --results, or begin anew with --overwrite"
        content = read_json(path, remedy)
        try:
            found = {(kind, int(seed)): Coverage(**one) for kind, seed, one in content["twins"]}
            return cls(path, found, dict(content["provenance"]))
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path} does not hold the twins of this benchmark ({error}); {remedy}") from error

    def add(self, twin: Twin, coverage: Coverage) -> None:
        """Keep what a twin gave, at once."""
        self.found[twin] = coverage
        twins = [[kind, seed, asdict(one)] for (kind, seed), one in sorted(self.found.items())]
        write_text(self.path, json_text({"provenance": self.made, "twins": twins}))


def page(results: Results, twins: Sequence[Twin]) -> str:
    """The page, of those of the `twins` that have been fitted."""
    of_kind = {kind: [results.found[one] for one in twins if one[0] == kind and one in results.found]
               for kind in dict.fromkeys(kind for kind, _ in twins)}  # fmt: skip
    of_kind = {kind: found for kind, found in of_kind.items() if found}
    seeds = sorted({seed for _, seed in twins})
    return _PAGE.format(
        kinds=markdown.table(_KINDS, [_row(kind, found) for kind, found in of_kind.items()]),
        parameters=markdown.table(("parameter", *of_kind), _parameter_rows(of_kind.values())),
        seeds=f"{seeds[0]} to {seeds[-1]}" if seeds else "none",
        made=in_words(results.made),
    )


_KINDS = ("rig", "twins", "determined parameters", "95 %", "worst of them", "critical speed", "end of stick-slip",
          "told of a misfit")  # fmt: skip

_PAGE = """\
# Do the intervals hold?

A 90 % interval is worth its name when nine of ten hold the truth. Here the truth is known: the records are made by the
simulator, with rigs that the fit does not know, and written as a logger writes them, with noise, speeds in steps,
glitches, a gap, and references that jump between samples. Each twin has 40 s without load, a sweep of 60 s under load,
and 30 s of stick-slip, at 100 Hz; the fit begins 15 % off (a standard deviation) in every parameter. How intervals are
made was chosen on other seeds.

- `chapter`: the chapter's rig.
- `other`: 2.5 times slower and 20 times as strong.
- `gaussian`: friction that falls as a Gaussian, fitted with that law.
- `untrue`: the disc turns untrue, so that the normal force varies by 5 % over a turn, **which the fit does not know**.

{kinds}

"Determined parameters" is the share of true values within their 90 % intervals, over all parameters that the fit calls
determined by the records, with the 95 % interval of that share over twins. "Worst" is the parameter that is held least
often, of those that are determined in half of the twins. Critical speed and end of stick-slip are at the records' load.

Parameter by parameter, the share of twins whose interval holds it, of those in which it is determined:

{parameters}

`python -m benchmarks.calibration`, seeds {seeds}; {made}.
"""


def _row(kind: str, found: Sequence[Coverage]) -> list[str]:
    """A kind's row of the table."""
    parameters, speeds = _by_name(one.parameters for one in found), _by_name(one.speeds for one in found)
    usual = [name for name, held in parameters.items() if len(held) >= USUAL * len(found)]
    worst = min(usual, key=lambda name: float(np.mean(parameters[name])))
    pooled = _pooled(found, lambda one: one.parameters)
    return [
        f"`{kind}`",
        str(len(found)),
        f"{pooled.value:.3f}",
        f"{pooled.low:.3f} to {pooled.high:.3f}",
        f"{np.mean(parameters[worst]):.2f} (`{worst}`)",
        *(f"{np.mean(speeds[name]):.2f}" for name in speeds),
        f"{np.mean([one.misfit for one in found]):.2f}",
    ]


def _pooled(found: Sequence[Coverage], part: Callable[[Coverage], dict[str, bool]]) -> Estimate:
    """Share of all that was held, with its interval over twins."""
    held = np.array([one for twin in found for one in part(twin).values()], dtype=bool)
    twins = np.repeat(np.arange(len(found)), [len(part(twin)) for twin in found])
    return over_rigs(held, twins) if len(found) > 1 else rate(held)


def _parameter_rows(kinds: Iterable[Sequence[Coverage]]) -> list[list[str]]:
    tables = [_by_name(one.parameters for one in found) for found in kinds]
    names = dict.fromkeys(name for table in tables for name in table)
    return [[f"`{name}`", *(_share(table.get(name, [])) for table in tables)] for name in names]


def _share(held: Sequence[bool]) -> str:
    return f"{np.mean(held):.2f} of {len(held)}" if held else "not determined"


def _by_name(twins: Iterable[dict[str, bool]]) -> dict[str, list[bool]]:
    """What was held, twin by twin, by its name."""
    found: dict[str, list[bool]] = {}
    for one in twins:
        for name, held in one.items():
            found.setdefault(name, []).append(held)
    return found
