"""What happens beside learning: evaluation, checkpoints, and a stop that loses nothing.

All of it happens between two rollouts, so that a training which is cut there and resumed is the same.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from agents.policy.agent import Agent
from agents.policy.run_folder import BEST_MODEL, CHECKPOINT, EVALUATIONS
from agents.training.checkpoint import save_checkpoint, save_model
from agents.training.validation_rigs import validate
from drillrig_env.command_line import Terminated
from drillrig_env.files import read_arrays, written_whole


class Evaluate(BaseCallback):
    """Evaluate every `every` steps and at the end; write `evaluations.npz` and keep the best model.

    `config` is the run's, `arguments` are those of `EpisodeBatch`. The best model has the largest mitigated
    share, and among equals the highest mean return. Evaluations in the folder are kept up to the step
    with which this training begins; a damaged file of them is passed over.
    """

    def __init__(self, folder: Path, config: Mapping[str, Any], arguments: Mapping[str, Any], rigs: int, every: int):
        super().__init__()
        self.folder, self.config, self.arguments = folder, config, arguments
        self.rigs, self.every = rigs, every
        self.history: dict[str, list[Any]] = {"timesteps": [], "results": [], "mitigated": [], "ep_lengths": []}

    @property
    def mitigated(self) -> float | None:
        """The share that the last evaluation found mitigated."""
        return float(np.mean(self.history["mitigated"][-1])) if self.history["mitigated"] else None

    def _on_training_start(self) -> None:
        path = self.folder / EVALUATIONS
        if not path.is_file():
            return
        try:
            saved = read_arrays(path, "the evaluations before this one are left out")
        except ValueError as error:
            print(error, flush=True)
            return
        kept = saved["timesteps"] <= self.num_timesteps
        self.history = {name: list(saved[name][kept]) for name in self.history}

    def _on_rollout_start(self) -> None:
        last = self.history["timesteps"][-1] if self.history["timesteps"] else -1  # a curve begins at step 0
        if self.num_timesteps // self.every > last // self.every:
            self._evaluate()

    def _on_training_end(self) -> None:
        if self.num_timesteps not in self.history["timesteps"]:
            self._evaluate()

    def _on_step(self) -> bool:
        return True

    def _evaluate(self) -> None:
        validation = validate(Agent(self.model, self.config), self.arguments, self.rigs)
        rank = (float(validation.mitigated.mean()), float(validation.returns.mean()))
        earlier = zip(self.history["mitigated"], self.history["results"], strict=True)
        if all(rank > (float(m.mean()), float(r.mean())) for m, r in earlier):
            save_model(self.folder / BEST_MODEL, self.model)
        self.history["timesteps"].append(self.num_timesteps)
        self.history["results"].append(validation.returns)
        self.history["mitigated"].append(validation.mitigated)
        self.history["ep_lengths"].append(np.full(self.rigs, validation.steps))
        arrays: dict[str, Any] = {name: np.array(rows) for name, rows in self.history.items()}
        with written_whole(self.folder / EVALUATIONS) as new:
            np.savez(new, **arrays)
        self.logger.record("eval/mitigated", rank[0])
        self.logger.record("eval/mean_reward", rank[1])
        self.logger.dump(self.num_timesteps)


class Checkpoint(BaseCallback):
    """Write a checkpoint every `every` steps, and when asked to stop.

    Between `with` and its end, Ctrl-C and SIGTERM ask for a stop: the rollout and its update are finished,
    the checkpoint is written and `KeyboardInterrupt` (`Terminated` for SIGTERM) is raised. A second one stops at
    once, and while `at_once` is set the first does. Where `asked` is given, signals are left alone, and a stop is asked
    for when it returns True.
    """

    def __init__(self, folder: Path, every: int, asked: Callable[[], bool] | None = None):
        super().__init__()
        self.path, self.every, self.asked = folder / CHECKPOINT, every, asked
        self.at_once = False
        self._stop: KeyboardInterrupt | None = None
        self._next = every
        self._handlers: dict[int, Any] = {}

    def __enter__(self) -> Checkpoint:
        if self.asked is None and threading.current_thread() is threading.main_thread():
            self._handlers = {s: signal.signal(s, self._ask) for s in (signal.SIGINT, signal.SIGTERM)}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)

    def _ask(self, number: int, _frame: FrameType | None) -> None:
        now = self.at_once or self._stop is not None
        self._stop = Terminated() if number == signal.SIGTERM else KeyboardInterrupt()
        if now:
            raise self._stop

    def _on_training_start(self) -> None:
        self._next = self.num_timesteps + self.every

    def stop_if_asked(self) -> None:
        """Raise what a stop is to raise, where one was asked for; nothing is written."""
        if self._stopped():
            raise self._stop or KeyboardInterrupt

    def _stopped(self) -> bool:
        if self.asked is not None and self.asked():
            self._stop = KeyboardInterrupt()
        return self._stop is not None

    def _on_rollout_start(self) -> None:
        if self._stopped() or self.num_timesteps >= self._next:
            self._next = self.num_timesteps + self.every
            save_checkpoint(self.path, self.model)
        if self._stop:
            raise self._stop

    def _on_step(self) -> bool:
        return True
