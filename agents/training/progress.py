"""Live progress of a training: reward, mitigated share and steps a second, in the terminal and in TensorBoard."""

from __future__ import annotations

import json
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Column
from rich.text import Text
from stable_baselines3.common.callbacks import BaseCallback

from agents.policy.run_folder import PROGRESS
from agents.training.callbacks import Evaluate
from drillrig_env.files import write_text

_SECONDS = 1.0  # between two tellings
_SECONDS_OF_LINES = 30.0  # where the output is a file


class Numbers(ProgressColumn):
    """What a training's latest episodes were like."""

    def render(self, task: Task) -> Text:
        """The numbers of a task as one line."""
        return Text(line(task.fields["numbers"]))


def line(numbers: dict[str, Any]) -> str:
    """The numbers of a training, as one line; those that are not known yet are left out."""
    if "imitated" in numbers and not numbers.get("steps"):
        return f"imitates: {numbers['imitated']:,} steps, {numbers['seconds']:.0f} s"
    parts = [f"{numbers.get('steps', 0):,} steps"]
    for name, text in (
        ("reward", "reward {:.3f}"),
        ("mitigated", "mitigated {:.2f}"),
        ("evaluated", "evaluated {:.3f}"),
        ("steps_per_second", "{:,.0f} steps/s"),
    ):
        if numbers.get(name) is not None:
            parts.append(text.format(numbers[name]))
    return "  ".join(parts)


def bars(console: Console | None = None) -> Progress:
    """An empty display of bars, one a training, each on one line of the console (default: the terminal)."""
    words = [Column(no_wrap=True, overflow="ellipsis") for _ in range(4)]  # cut, not wrapped, in a narrow terminal
    return Progress(
        TextColumn("{task.description}", table_column=words[0]),
        BarColumn(20),
        TextColumn("{task.percentage:3.0f} %", table_column=words[1]),
        Numbers(table_column=words[2]),
        TimeRemainingColumn(compact=True, table_column=words[3]),
        refresh_per_second=2,
        console=console,
    )


def read_progress(folder: Path) -> dict[str, Any]:
    """What the training in a folder last told; empty where it has told nothing yet."""
    try:
        numbers: dict[str, Any] = json.loads((folder / PROGRESS).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return numbers


class ShowProgress(BaseCallback):
    """Tell how a training does: bars in a terminal, lines elsewhere, `progress.json`, and `drillrig/...` curves.

    Reward (mean of a step) and mitigated share are those of the episodes that ended last, with
    exploration; `evaluated` is the mitigated share of the last evaluation, without. `seconds` is the wall
    time of the training so far, evaluations and what was done before a stop counted in.
    """

    def __init__(self, folder: Path, total: int, evaluate: Evaluate | None = None, show: bool = True):
        super().__init__()
        self.folder, self.total, self.evaluate = folder, total, evaluate
        self.console = Console()
        self.bars = bars() if show and self.console.is_terminal else None
        self.lines = show and self.bars is None
        self._task = TaskID(0)
        self._ended: list[dict[str, Any]] = []
        self._numbers: dict[str, Any] = {}
        self._told = self._line = self._since = self._learning = self._earlier = 0.0
        self._done = 0

    def imitates(self, steps: int) -> None:
        """Tell that the agent imitates, and for how many steps by now."""
        self._begin()
        self._numbers["imitated"] = steps
        self._tell()

    def _begin(self) -> None:
        if self._since:
            return
        self._since = time.monotonic()
        self._line = self._since - _SECONDS_OF_LINES  # the first line comes at once
        self._earlier = read_progress(self.folder).get("seconds", 0.0)
        if self.bars:
            self._task = self.bars.add_task(self.folder.name, total=self.total, numbers={})
            self.bars.start()

    def _on_training_start(self) -> None:
        self._begin()
        self._learning, self._done = time.monotonic(), self.num_timesteps
        self._tell(at_once=True)

    def _on_rollout_start(self) -> None:
        self._tell()

    def _on_step(self) -> bool:
        if np.any(self.locals["dones"]):
            self._ended += [info for info in self.locals["infos"] if "episode" in info]
        self._tell()
        return True

    def _on_rollout_end(self) -> None:
        if self._ended:
            self._numbers["reward"] = float(
                np.mean([info["episode"]["r"] / info["episode"]["l"] for info in self._ended])
            )
            self._numbers["mitigated"] = float(np.mean([info["is_success"] for info in self._ended]))
            self._ended = []
            self.logger.record("drillrig/mitigated", self._numbers["mitigated"])
            self.logger.record("drillrig/cost", -self._numbers["reward"])

    def close(self) -> None:
        """Tell where the training ended, and give the terminal back."""
        self._begin()  # it may have been stopped before it had told anything
        self._tell(at_once=True)
        if self.bars:
            self.bars.stop()

    def _tell(self, at_once: bool = False) -> None:
        now = time.monotonic()
        if now - self._told < _SECONDS and not at_once:
            return
        self._told = now
        self._numbers["steps"], self._numbers["total"] = self.num_timesteps, self.total
        self._numbers["seconds"] = round(self._earlier + now - self._since, 1)
        if self._learning and now - self._learning > _SECONDS:
            self._numbers["steps_per_second"] = (self.num_timesteps - self._done) / (now - self._learning)
        if self.evaluate:
            self._numbers["evaluated"] = self.evaluate.mitigated
        with suppress(OSError):  # a disk that is full for a moment must not end the training
            write_text(self.folder / PROGRESS, json.dumps(self._numbers) + "\n")
        if self.bars:
            self.bars.update(self._task, completed=self.num_timesteps, numbers=dict(self._numbers))
        if self.lines and now - self._line >= _SECONDS_OF_LINES:
            self._line = now
            print(f"{self.folder.name}: {line(self._numbers)}", flush=True)
