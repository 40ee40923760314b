"""Train several seeds of one agent, each in a process and a folder of its own."""

from __future__ import annotations

import atexit
import gc
import os
import platform
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from rich.console import Console

from agents.policy.run_folder import is_finished, is_run, new_run, read_config, write_config
from agents.training.progress import bars, line, read_progress
from agents.training.settings import Training, checked_config
from agents.training.train import new_model, resume
from drillrig_env.command_line import Failed, interrupt_as_exception, sigterm_as_exception
from drillrig_env.engine import Engine, used
from drillrig_env.engine.worker import stop_asked
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.files import check_writable, owned
from drillrig_env.jit.threads import available_threads
from drillrig_env.parameters import refuse

_LINES = 10.0  # s between two lines about each of them, where the output is no terminal


def train_seeds(training: Training, seeds: int, engine: Engine | str | None = None) -> Path:
    """Train the seeds `seed`, `seed` + 1, ... into `<run folder>/seed_<s>`, one after another, or as `engine` does.

    `Local(2)` of `drillrig_env.engine` trains two at a time; on Ray, "ray", the run folder must be one that all
    machines share. Each training ends with the same bits as alone. Returns the folder of them all. Ctrl-C and SIGTERM
    stop all of them within 5 s, each keeps what it learnt, and `KeyboardInterrupt` is raised. Raises `ValueError` and
    `OSError` before anything is written, as `train` does, and `Failed` naming the seeds whose training failed.
    """
    if seeds < 1:
        raise refuse("train", "seeds", seeds, "", ">= 1")
    chosen = range(training.seed, training.seed + seeds)
    configs = {seed: checked_config(replace(training, seed=seed)) for seed in chosen}
    new_model(configs[training.seed])
    check_writable(training.log_folder if training.run_folder is None else training.run_folder.parent)
    parent = new_run(training.log_folder, training.algorithm, training.run_folder)
    with owned(parent):
        for seed, config in configs.items():
            folder = new_run(parent, training.algorithm, parent / f"seed_{seed}")
            write_config(folder, {**config, "provenance": provenance()})
        with used(engine) as at:
            _run([parent / f"seed_{seed}" for seed in configs], parent, at, training.threads, training.progress)
    return parent


def resume_seeds(
    parent: Path, engine: Engine | str | None = None, threads: int | None = None, progress: bool = True
) -> Path:
    """Go on with every unfinished training in `parent`, also those that had not begun, on any `engine`.

    `ValueError` where there is none, and `BlockingIOError` where another process is at it.
    """
    runs = [path for path in sorted(parent.glob("seed_*")) if is_run(path)]
    if not runs:
        raise ValueError(f"{parent}: neither a run nor a folder of runs; allowed: one that `train.py` has made")
    folders = [path for path in runs if not is_finished(path)]
    if not folders:
        raise ValueError(f"{parent}: nothing to go on with: all its runs are finished")
    with owned(parent), used(engine) as at:
        _run(folders, parent, at, threads, progress)
    return parent


def _run(folders: Sequence[Path], parent: Path, engine: Engine, threads: int | None, progress: bool) -> None:
    """Train what the folders' configs say, as many at a time as the engine does, and show how far each is."""
    _end_quickly()
    os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OMP", "MKL", "OPENBLAS")})
    alone = threads or available_threads() if engine.here else 1
    shown, failed = _Shown(folders, progress), list[str]()
    try:
        work = partial(_train_one, alone)
        pieces = [folder.resolve() for folder in folders]
        with interrupt_as_exception():
            for outcome in engine.outcomes(work, pieces, apart=True, meanwhile=shown.tell):
                folder = folders[outcome.number]
                if outcome.error is None:
                    shown.end(folder, *outcome.value())
                else:
                    failed.append(folder.name)
                    told = [f"{folder}: error: {outcome.error}", *getattr(outcome.error, "__notes__", [])]
                    print("; ".join(told), file=sys.stderr, flush=True)
                    shown.end(folder, "failed")
    except KeyboardInterrupt as stop:
        stop.add_note(f"to go on: python train.py --resume {parent}")
        raise
    finally:
        shown.close()
    if failed:
        raise Failed(f"training failed for {', '.join(failed)}; what it said is above")


def _train_one(threads: int, folder: Path) -> tuple[str, str]:
    """In a process of its own: train what the folder's config says, until a stop is asked for; how it ended, in words.

    Where an earlier try of it was lost it goes on from the checkpoint of that.
    """
    _end_quickly()
    if not is_run(folder):
        raise Failed(f"{platform.node()} does not see it; trainings need a folder that all machines of a cluster share")
    if is_finished(folder):
        return "done", ""
    _write_machine(folder)
    try:
        with sigterm_as_exception():
            resume(folder, threads, progress=False, asked=stop_asked)
    except KeyboardInterrupt as end:
        return "stopped", "; ".join(getattr(end, "__notes__", [])[:1])
    return "done", ""


def _write_machine(folder: Path) -> None:
    """Add this machine to the provenance of a run, where it is another one than that which began it."""
    config, machine = read_config(folder), provenance()["machine"]
    made = config.setdefault("provenance", {"machine": machine})
    if machine not in (made["machine"], *made.get("also_on", ())):
        made["also_on"] = [*made.get("also_on", ()), machine]
        write_config(folder, config)


def _end_quickly() -> None:
    """Let this process not look for cycles among all objects of PyTorch when it ends; on busy cores that takes 2 s."""
    atexit.unregister(gc.freeze)
    atexit.register(gc.freeze)


class _Shown:
    """How far the trainings are: bars in a terminal, lines elsewhere."""

    def __init__(self, folders: Sequence[Path], progress: bool) -> None:
        self.folders, self.ended = folders, set[Path]()
        self.bars = bars() if progress and Console().is_terminal else None
        self.lines = progress and self.bars is None
        self._line = time.monotonic()
        if self.bars:
            self.tasks = {folder: self.bars.add_task(folder.name, total=None, numbers={}) for folder in folders}
            self.bars.start()

    def tell(self) -> None:
        """Tell of every training that has begun and not ended."""
        if self.bars:
            for folder, task in self.tasks.items():
                if numbers := read_progress(folder):
                    self.bars.update(task, total=numbers["total"], completed=numbers["steps"], numbers=numbers)
        elif self.lines and time.monotonic() - self._line > _LINES:
            self._line = time.monotonic()
            for folder in self.folders:
                if folder not in self.ended and (numbers := read_progress(folder)):
                    print(f"{folder.name}: {line(numbers)}", flush=True)

    def end(self, folder: Path, how: str, said: str = "") -> None:
        """Tell how a training ended, and what it said."""
        self.ended.add(folder)
        if said:
            print(said, flush=True)
        if self.lines:
            print(f"{folder.name}: {how}", flush=True)

    def close(self) -> None:
        """Give the terminal back."""
        if self.bars:
            self.bars.stop()
