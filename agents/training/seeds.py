"""Train several seeds of one agent, each in a process and a folder of its own."""

from __future__ import annotations

import atexit
import gc
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing.connection import wait
from multiprocessing.context import SpawnProcess
from multiprocessing.synchronize import Event
from pathlib import Path
from types import FrameType

from rich.console import Console

from agents.policy.run_folder import is_finished, is_run, new_run, write_config
from agents.training.progress import bars, line, read_progress
from agents.training.settings import Training, checked_config
from agents.training.train import new_model, resume
from drillrig_env.command_line import FAILED, INTERRUPTED, Failed, Terminated, sigterm_as_exception
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.files import check_writable, owned
from drillrig_env.parameters import refuse

_LOOK = 0.2  # s between two looks at the processes
_LINES = 10.0  # s between two lines about each of them, where the output is no terminal
_GRACE, _HARD = 2.5, 3.5  # s after a stop: until then a rollout may end; then processes save at once; then they go


def train_seeds(training: Training, seeds: int, jobs: int = 1) -> Path:
    """Train the seeds `seed`, `seed` + 1, ... into `<run folder>/seed_<s>`, `jobs` at a time.

    Returns the folder of them all. Ctrl-C and SIGTERM stop all of them within 5 s, each keeps what it learnt, and
    `KeyboardInterrupt` is raised. Raises `ValueError` and `OSError` before anything is written, as `train` does, and
    `Failed` naming the seeds whose training failed.
    """
    for name, value in (("seeds", seeds), ("jobs", jobs)):
        if value < 1:
            raise refuse("train", name, value, "", ">= 1")
    chosen = range(training.seed, training.seed + seeds)
    configs = {seed: checked_config(replace(training, seed=seed)) for seed in chosen}
    new_model(configs[training.seed])
    check_writable(training.log_folder if training.run_folder is None else training.run_folder.parent)
    parent = new_run(training.log_folder, training.algorithm, training.run_folder)
    with owned(parent):
        for seed, config in configs.items():
            folder = new_run(parent, training.algorithm, parent / f"seed_{seed}")
            write_config(folder, {**config, "provenance": provenance()})
        _run([parent / f"seed_{seed}" for seed in configs], parent, jobs, training.threads, training.progress)
    return parent


def resume_seeds(parent: Path, jobs: int = 1, threads: int | None = None, progress: bool = True) -> Path:
    """Go on with every unfinished training in `parent`, also those that had not begun.

    `ValueError` where there is none, and `BlockingIOError` where another process is at it.
    """
    if jobs < 1:
        raise refuse("train", "jobs", jobs, "", ">= 1")
    runs = [path for path in sorted(parent.glob("seed_*")) if is_run(path)]
    if not runs:
        raise ValueError(f"{parent}: neither a run nor a folder of runs; allowed: one that `train.py` has made")
    folders = [path for path in runs if not is_finished(path)]
    if not folders:
        raise ValueError(f"{parent}: nothing to go on with: all its runs are finished")
    with owned(parent):
        _run(folders, parent, jobs, threads, progress)
    return parent


def _run(folders: Sequence[Path], parent: Path, jobs: int, threads: int | None, progress: bool) -> None:
    """Train what the folders' configs say in processes, `jobs` at a time, and show how far each is."""
    _end_quickly()
    os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OMP", "MKL", "OPENBLAS")})
    spawn = multiprocessing.get_context("spawn")
    stop = spawn.Event()
    waiting = {
        folder: spawn.Process(target=_train_one, args=(folder, 1 if jobs > 1 else threads, stop)) for folder in folders
    }
    running: dict[Path, SpawnProcess] = {}
    failed: list[str] = []
    asked: list[int] = []
    pressed: set[SpawnProcess] = set()
    shown = _Shown(folders, progress)
    try:
        with _signals_kept(asked):
            while running or (waiting and not asked):
                while waiting and len(running) < jobs and not asked:
                    folder, process = next(iter(waiting.items()))
                    _start(process)
                    running[folder] = waiting.pop(folder)
                wait([process.sentinel for process in running.values()], _LOOK)
                if asked and not stop.is_set():
                    stop.set()
                    stopped = time.monotonic()
                if asked:
                    _press(running.values(), pressed, time.monotonic() - stopped)
                for folder, process in list(running.items()):
                    if process.is_alive():
                        continue
                    del running[folder]
                    how = "done" if not process.exitcode else "stopped" if asked else "failed"
                    failed += [folder.name] if how == "failed" else []
                    shown.end(folder, how)
                shown.tell()
    finally:
        for process in running.values():
            process.kill()
        shown.close()
    if asked:
        end = Terminated() if asked[0] == signal.SIGTERM else KeyboardInterrupt()
        end.add_note(f"to go on: python train.py --resume {parent}")
        raise end
    if failed:
        raise Failed(f"training failed for {', '.join(failed)}; what it said is above")


def _train_one(folder: Path, threads: int | None, stop: Event) -> None:
    """In a process of its own: train what the folder's config says, until `stop` is set or the parent is gone.

    Ctrl-C in a terminal reaches this process too, and is left to the one that started it.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_quickly()
    parent = multiprocessing.parent_process()

    def asked() -> bool:
        return stop.is_set() or not (parent and parent.is_alive())

    try:
        with sigterm_as_exception():
            resume(folder, threads, progress=False, asked=asked)
    except KeyboardInterrupt as end:
        print("; ".join(getattr(end, "__notes__", [])[:1]), flush=True)
        sys.exit(INTERRUPTED)
    except (ValueError, OSError, ImportError, Failed) as error:
        print("; ".join([f"{folder}: error: {error}", *getattr(error, "__notes__", [])]), file=sys.stderr, flush=True)
        sys.exit(FAILED)


def _start(process: SpawnProcess) -> None:
    """Start a process that Ctrl-C in a terminal does not reach, also while it still imports what it needs."""
    if os.name == "nt":
        process.start()
        return
    earlier = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # the process inherits this
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, earlier)


def _end_quickly() -> None:
    """Let this process not look for cycles among all objects of PyTorch when it ends; on busy cores that takes 2 s."""
    atexit.unregister(gc.freeze)
    atexit.register(gc.freeze)


@contextmanager
def _signals_kept(asked: list[int]) -> Iterator[None]:
    """Put the number of each Ctrl-C and SIGTERM into `asked`; the second one is raised."""

    def keep(number: int, _frame: FrameType | None) -> None:
        asked.append(number)
        if len(asked) > 1:
            raise Terminated if number == signal.SIGTERM else KeyboardInterrupt

    earlier = {number: signal.signal(number, keep) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in earlier.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)


def _press(processes: Iterable[SpawnProcess], pressed: set[SpawnProcess], waited: float) -> None:
    """Make processes that were asked to stop `waited` s ago stop at once: first, and once, so that they save."""
    for process in processes:
        if waited > _HARD:
            process.kill()
        elif waited > _GRACE and process not in pressed:
            pressed.add(process)
            process.terminate()


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

    def end(self, folder: Path, how: str) -> None:
        """Tell how a training ended."""
        self.ended.add(folder)
        if self.lines:
            print(f"{folder.name}: {how}", flush=True)

    def close(self) -> None:
        """Give the terminal back."""
        if self.bars:
            self.bars.stop()
