"""The verdict on a lane as it runs: stick-slip index, calm, mitigated, and since when it has been calm.

The definitions are those of every score (`drillrig_env.verdict`), over the window that ends now.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.env.task import Task
from drillrig_env.evaluation.scores import TRAILING
from drillrig_env.verdict import CALM_INDEX, WINDOW, is_calm, is_mitigated, stick_slip_index


@dataclass(frozen=True)
class Verdict:
    """What the window that ends now tells; `full` is whether so much time has passed at all."""

    index: float  # SSI; infinite where the bit does not turn on
    mean: float  # rad/s
    calm: bool
    mitigated: bool
    calm_since: float | None  # s since the start of the run; by the shorter window that "time to calm" looks at
    stuck: float  # share of the time in which the bit stood
    full: bool


class RunningVerdict:
    """Lowest, highest and mean bit speed of the last control steps, and what follows from them."""

    def __init__(self, task: Task) -> None:
        time = task.scales.time
        self._period, self._speed_scale = task.control_period, task.scales.speed
        self._window = round(WINDOW * time / self._period)
        self._trailing = round(TRAILING * time / self._period)
        self._past: FloatArray = np.zeros((4, 2 * self._window))  # each entry twice, so that every window is a slice
        self._steps, self._calm_from = 0, -1

    def add(self, lowest: float, highest: float, average: float, stuck: float) -> None:
        """Take in a control step: lowest, highest and average bit speed (rad/s), and share of it that the bit stood."""
        place = self._steps % self._window
        self._past[:, place] = self._past[:, place + self._window] = lowest, highest, average, stuck
        self._steps += 1
        low, high, mean, _ = self._over(self._trailing)
        if self._steps < self._trailing or not stick_slip_index(low, high, mean) < CALM_INDEX:
            self._calm_from = -1
        elif self._calm_from < 0:
            self._calm_from = self._steps

    def now(self, target: float) -> Verdict:
        """The verdict at a speed target (rad/s)."""
        low, high, mean, stuck = self._over(self._window)
        full = self._steps >= self._window
        return Verdict(
            index=float(stick_slip_index(low, high, mean)),
            mean=mean,
            calm=full and bool(is_calm(low, high, mean, self._speed_scale)),
            mitigated=full and bool(is_mitigated(low, high, mean, target, self._speed_scale)),
            calm_since=None if self._calm_from < 0 else self._calm_from * self._period,
            stuck=stuck,
            full=full,
        )

    def _over(self, steps: int) -> tuple[float, float, float, float]:
        """Lowest, highest and mean bit speed, and share of standing, of the last `steps` control steps."""
        steps = min(steps, self._steps)
        if steps == 0:
            return 0.0, 0.0, 0.0, 0.0
        end = (self._steps - 1) % self._window + self._window + 1
        low, high, mean, stuck = self._past[:, end - steps : end]
        return float(low.min()), float(high.max()), float(mean.mean()), float(stuck.mean())
