"""Histories over time of a few rigs, kept beside the results so that they can be drawn without running.

Which rigs are kept is decided by the physics alone and not by what any policy made of them: of each
suite the rig of median hardness below the critical speed, and that of median hardness between critical
speed and fold.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.evaluation.results import Scores
from drillrig_env.evaluation.suites import LARGE, PIECE
from drillrig_env.evaluation.tables import best_first
from drillrig_env.scales import CONTROL_PERIOD

REGIONS = ("below", "bistable")
ACTION_ZERO = "constant"
"""The policy whose action is always 0."""

TRACES = ("lowest", "highest", "average", "top_speed", "speed_reference", "torque_into_string")
"""What is kept of each control step: bit speed and speeds (rad/s), string torque (N m)."""

History = dict[str, npt.NDArray[np.float32]]


@dataclass
class Histories:
    """Histories by suite, policy and region; each a dictionary of TRACES with an entry a control step."""

    kept: dict[tuple[str, str, str], History] = field(default_factory=dict)

    def keep(
        self,
        suite: str,
        policy: str,
        traces: Callable[[int], npt.NDArray[np.float32]],
        scores: Mapping[str, npt.NDArray[Any]],
    ) -> None:
        """Keep the typical rigs of a policy in a suite; `traces` gives TRACES of a rig, shape (traces, steps)."""
        for region, rig in typical_rigs(scores).items():
            self.kept[suite, policy, region] = dict(zip(TRACES, traces(rig), strict=True))

    def arrange(self, policies: Sequence[str]) -> None:
        """Put the policies into this order within each suite, whichever was done first."""
        suites = list(dict.fromkeys(suite for suite, _, _ in self.kept))
        places = {name: place for place, name in enumerate(policies)}
        last = len(places)
        keys = sorted(self.kept, key=lambda key: (suites.index(key[0]), places.get(key[1], last)))
        self.kept = {key: self.kept[key] for key in keys}

    def of(self, suite: str, region: str) -> dict[str, History]:
        """Histories of the typical rig of a region, by policy."""
        return {policy: kept for (where, policy, at), kept in self.kept.items() if (where, at) == (suite, region)}

    def packed(self) -> bytes:
        """All histories as the content of one file; the same histories give the same file."""
        buffer = io.BytesIO()
        arrays = {"|".join(key): np.stack([kept[name] for name in TRACES]) for key, kept in self.kept.items()}
        np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]  # the stub takes a name for a flag
        return buffer.getvalue()

    @classmethod
    def unpacked(cls, content: bytes) -> Histories:
        """The histories that `packed` gave."""
        histories = cls()
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            for key in arrays.files:
                suite, policy, region = key.split("|")
                histories.kept[suite, policy, region] = dict(zip(TRACES, arrays[key], strict=True))
        return histories


def typical_rigs(scores: Scores | Mapping[str, npt.NDArray[Any]]) -> dict[str, int]:
    """Of each region that has rigs, the one of median hardness, by its number; of a large suite in the first piece."""
    found, seeds = {}, scores["seed"]
    rigs_of_all = int(np.count_nonzero(seeds == seeds[0]))
    first = slice(PIECE if rigs_of_all > LARGE else rigs_of_all)
    hardness, where = scores["hardness"][first], scores["region"][first]
    for region in REGIONS:
        rigs = np.flatnonzero(where == region)
        if len(rigs):
            order = np.argsort(hardness[rigs], kind="stable")
            found[region] = int(rigs[order[len(order) // 2]])
    return found


def worth_showing(results: Mapping[str, Scores], kept: Iterable[str], most: int = 4) -> list[str]:
    """The policies whose histories are drawn: `constant`, which shows what nobody's help is, and then the best ones."""
    there = set(kept)
    first = [ACTION_ZERO] if ACTION_ZERO in there else []
    return [*first, *(name for name in best_first(results) if name in there - {ACTION_ZERO})][:most]


def times(history: History, time_scale: float = 1.0) -> npt.NDArray[np.float64]:
    """The ends of a history's control steps, s; `time_scale` is the rig's scale of times."""
    return np.arange(1, len(history["average"]) + 1, dtype=np.float64) * (CONTROL_PERIOD * time_scale)
