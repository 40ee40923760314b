"""What a run leaves behind: a row for each control step, and the CSV of it with units."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from drillrig_env.course import COLUMNS
from drillrig_env.model import STATE_NAMES, STATE_UNITS
from drillrig_env.room.given import UNITS
from drillrig_env.room.lane import Lane

_OF_RECORD = {
    "speed_reference": "rad/s",
    "torque_into_string": "N m",
    "voltage": "V",
    "lowest": "rad/s",
    "highest": "rad/s",
    "reward": "",
}
_SHOWN_AS = {"lowest": "bit_speed_lowest", "highest": "bit_speed_highest"}
_OF_LANE = len(STATE_NAMES) + len(_OF_RECORD) + 2
_FIRST = 1024


class Record:
    """The rows of a run of so many lanes, with control steps of `period` s."""

    def __init__(self, lanes: int, period: float) -> None:
        self._lanes, self._period, self._steps = lanes, period, 0
        self._rows: npt.NDArray[np.float64] = np.empty((_FIRST, len(COLUMNS) + lanes * _OF_LANE))

    def add(self, given: npt.NDArray[np.float64], lanes: Iterable[Lane]) -> None:
        """A row: what was given in a control step (in the order of COLUMNS), and the lanes at its end."""
        if self._steps == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        row = [*given]
        for lane in lanes:
            episode = lane.core.episodes[0]
            row += [lane.action, float(lane.hand is not None), *episode["state"][:7]]
            row += [episode[name] for name in _OF_RECORD]
        self._rows[self._steps] = row
        self._steps += 1

    @property
    def given(self) -> npt.NDArray[np.float64]:
        """What was given in every control step, shape (steps, 5), in the order of COLUMNS."""
        return self._rows[: self._steps, : len(COLUMNS)].copy()

    def actions(self, lane: int) -> npt.NDArray[np.float32]:
        """The actions of the lane at a place, shape (steps,)."""
        return self._rows[: self._steps, len(COLUMNS) + lane * _OF_LANE].astype(np.float32)

    def as_csv(self, names: Sequence[str]) -> str:
        """A header with units, then a line for each control step: its end in s, what was given, and each lane."""
        given = [_headed(name, unit) for name, unit in UNITS.items()]
        own = [("action", ""), ("by_hand", ""), *zip(STATE_NAMES, STATE_UNITS, strict=True)]
        own += [(_SHOWN_AS.get(name, name), unit) for name, unit in _OF_RECORD.items()]
        lanes = [_headed(f"{lane}_{name}", unit) for lane in names for name, unit in own]
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([_headed("time", "s"), *given, *lanes])
        for step, row in enumerate(self._rows[: self._steps].tolist()):
            writer.writerow([f"{(step + 1) * self._period:.6g}", *(f"{value:.10g}" for value in row)])
        return text.getvalue()


def _headed(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name
