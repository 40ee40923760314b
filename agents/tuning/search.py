"""The search itself: tries one after another in this process, or side by side on Ray, until the budget is spent."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

from agents.tuning.shown import Shown
from agents.tuning.study import Study, optuna_module
from agents.tuning.trial import Question
from agents.tuning.tries import STEPS, steps_of, worth
from drillrig_env.command_line import Failed
from drillrig_env.engine import Engine
from drillrig_env.engine.tune_on_ray import Tries, is_ray, tune
from drillrig_env.files import check_writable, owned
from drillrig_env.parameters import refuse

_FAILURES = 5
"""Tries that fail one after another before the search does."""


def search(
    folder: Path,
    question: Question,
    steps: int,
    hours: float | None,
    engine: Engine,
    say: Callable[[str], object] = print,
    progress: bool = True,
) -> Study:
    """Search until all tries of the study have taken `steps` steps, or `hours` are over; its files are written.

    A study that is in the folder is gone on with, tries that were cut first. Ctrl-C keeps what is done. Raises
    `ValueError` for a question that is not allowed or another than the folder's, and `Failed` where tries only fail.
    """
    if not (engine.here or is_ray(engine)):
        raise refuse("train", "jobs", engine.jobs, "", "1 on this machine; --on ray does tries side by side")
    for name, value, unit in (("budget", steps, "steps"), ("hours", hours, "h")):
        if value is not None and not value > 0:
            raise refuse("tune", name, value, unit, "> 0")
    if steps < question.steps:
        raise ValueError(
            f"tune: a budget of {steps:,} steps is less than one try; allowed: >= {question.steps:,} steps, or shorter "
            "tries by --n-timesteps"
        )
    check_writable(folder)
    with owned(folder), Shown(progress) as shown:
        study = Study(folder, question)
        if cut := study.take_up_cut():
            say(f"{cut} {'try that was cut is' if cut == 1 else 'tries that were cut are'} begun again")
        running = _Search(study, steps, hours, say, shown)
        try:
            if is_ray(engine):
                with engine:
                    tune(engine, running, Tries(question.ask, question.steps, question.first_look))
                running.end_open()
            else:
                running.here()
            if running.failures >= _FAILURES:
                raise Failed(f"{running.failures} tries failed one after another; the last: {running.last_error}")
        except KeyboardInterrupt as stop:
            stop.add_note(f"{folder} keeps {len(study.done)} tries of {study.spent:,} steps; the same command goes on")
            raise
        finally:
            study.write()
    return study


class _Search:
    """Asks the study for tries, tells it of them, and says when there are enough."""

    def __init__(
        self, study: Study, steps: int, hours: float | None, say: Callable[[str], object], shown: Shown
    ) -> None:
        self.study, self.steps, self.say, self.shown = study, steps, say, shown
        self.begun, self.seconds = time.monotonic(), inf if hours is None else 3600.0 * hours
        self.failures, self.last_error = 0, ""
        self._open: dict[int, Any] = {}
        self._spent = study.spent
        self._of: dict[int, int] = {}

    def enough(self) -> bool:
        """Whether the budget of steps or time is spent, or tries only fail."""
        return self._share() >= 1.0 or self.failures >= _FAILURES

    def _share(self) -> float:
        """The share of the budget that is spent, of steps or of time."""
        return max(self._steps() / self.steps, (time.monotonic() - self.begun) / self.seconds)

    def _steps(self) -> int:
        return self._spent + sum(self._of.values())

    def ask(self) -> tuple[int, dict[str, Any]]:
        """The next try."""
        trial = self.study.optuna.ask(self.study.question.space.distributions())
        self._open[trial.number], self._of[trial.number] = trial, 0
        self.shown.tell(trial.number, "begins", self._share())
        return trial.number, dict(trial.params)

    def told(self, number: int, steps: int, worth: float) -> None:
        """Keep how a try does."""
        if steps > self._of[number]:
            trial = self._open[number]
            trial.report(worth, steps)
            trial.set_user_attr(STEPS, steps)
            self._of[number] = steps
            of = self.study.question.steps
            self.shown.tell(number, f"is worth {worth:.4f} after {steps:,} of {of:,} steps", self._share())

    def ended(self, number: int, error: str | None = None) -> None:
        """Keep how a try ended."""
        states = optuna_module().trial.TrialState
        trial = self._open.pop(number)
        held = self.study.optuna.get_trials(deepcopy=False)[number]
        steps = self._of.pop(number)
        if error is not None or not held.intermediate_values:
            self.failures += 1
            self.study.optuna.tell(trial, state=states.FAIL)
            self.last_error = error or "it told nothing"
            print(f"try {number} failed: {self.last_error}", file=sys.stderr, flush=True)
            return
        self.failures = 0
        self._spent += steps
        if self.study.is_full(held):
            self.study.optuna.tell(trial, worth_now := worth(held))
            how = f"{worth_now:.4f}"
        else:
            self.study.optuna.tell(trial, state=states.PRUNED)
            how = f"{worth(held):.4f}, ended early after {steps_of(held):,} steps"
        self.say(f"try {number}: {how}; {self._steps():,} of {self.steps:,} steps")
        self.study.write(picture=False)

    def end_open(self) -> None:
        """End tries that were on their way when there was enough, also one to be begun again: their steps were taken.

        One that told nothing stays cut.
        """
        for number in [number for number, steps in self._of.items() if steps]:
            self.ended(number)

    def here(self) -> None:
        """Tries one after another in this process; Optuna's own pruner ends those early that fall behind."""
        while not self.enough():
            number, drawn = self.ask()
            try:
                self.study.question.ask(drawn, partial(self._falls_behind, number))
            except (ValueError, Failed, FloatingPointError) as error:
                self.ended(number, str(error))
            else:
                self.ended(number)

    def _falls_behind(self, number: int, steps: int, worth: float) -> bool:
        self.told(number, steps, worth)
        late = time.monotonic() - self.begun > self.seconds
        return late or (steps < self.study.question.steps and bool(self._open[number].should_prune()))
