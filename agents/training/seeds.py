"""Train several seeds of one agent, each in a process and a folder of its own."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from multiprocessing.context import SpawnProcess
from pathlib import Path

from rich.console import Console
from rich.progress import TaskID

from agents.policy.run_folder import CHECKPOINT, new_run
from agents.training.progress import bars, read_progress
from agents.training.train import Training, checked_config, resume, train
from drillrig_env.parameters import refuse

_LOOK = 0.5  # seconds between two looks at the processes


def train_seeds(training: Training, seeds: int, jobs: int = 1) -> Path:
    """Train the seeds `seed`, `seed` + 1, ... into `<run folder>/seed_<s>`, `jobs` at a time.

    Returns the folder of them all. Ctrl-C stops all of them, and each keeps what it learnt. Raises
    `ValueError` before anything is written, and `RuntimeError` naming the seeds whose training failed.
    """
    for name, value in (("seeds", seeds), ("jobs", jobs)):
        if value < 1:
            raise refuse("train", name, value, "", ">= 1")
    chosen = [replace(training, seed=training.seed + i) for i in range(seeds)]
    for one in chosen:
        checked_config(one)
    parent = new_run(training.log_folder, training.algorithm, training.run_folder)
    threads = 1 if jobs > 1 else training.threads
    tasks = {
        parent / f"seed_{one.seed}": partial(
            train, replace(one, run_folder=parent / f"seed_{one.seed}", threads=threads, progress=False)
        )
        for one in chosen
    }
    _run(tasks, jobs, training.progress)
    return parent


def resume_seeds(parent: Path, jobs: int = 1, threads: int | None = None, progress: bool = True) -> Path:
    """Go on with every unfinished training in `parent`. `ValueError` where there is none."""
    folders = sorted(path.parent for path in parent.glob(f"seed_*/{CHECKPOINT}"))
    if not folders:
        raise ValueError(f"{parent}: neither a run nor a folder of runs with a {CHECKPOINT} to go on from")
    threads = 1 if jobs > 1 else threads
    _run({folder: partial(resume, folder, threads, progress=False) for folder in folders}, jobs, progress)
    return parent


def _run(tasks: Mapping[Path, Callable[[], object]], jobs: int, progress: bool) -> None:
    """Run the tasks in processes, `jobs` at a time, and show how far each is."""
    os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OMP", "MKL", "OPENBLAS")})
    spawn = multiprocessing.get_context("spawn")
    waiting = {folder: spawn.Process(target=task) for folder, task in tasks.items()}
    running: dict[Path, SpawnProcess] = {}
    failed: list[str] = []
    shown = bars() if progress and Console().is_terminal else None
    lines: dict[Path, TaskID] = {}
    if shown:
        lines = {folder: shown.add_task(folder.name, total=None, numbers={}) for folder in tasks}
        shown.start()
    earlier = signal.signal(signal.SIGTERM, partial(_pass_on, running))
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                folder, process = next(iter(waiting.items()))
                process.start()
                running[folder] = waiting.pop(folder)
            time.sleep(_LOOK)
            for folder, process in list(running.items()):
                numbers = read_progress(folder)
                if shown and numbers:
                    shown.update(lines[folder], total=numbers["total"], completed=numbers["steps"], numbers=numbers)
                if not process.is_alive():
                    del running[folder]
                    failed += [folder.name] if process.exitcode else []
                    if progress and not shown:
                        print(f"{folder.name}: {'failed' if process.exitcode else 'done'}", flush=True)
    except KeyboardInterrupt:  # the processes were interrupted too, and save
        for process in running.values():
            process.join()
    finally:
        signal.signal(signal.SIGTERM, earlier)
        if shown:
            shown.stop()
    if failed:
        raise RuntimeError(f"training failed for {', '.join(failed)}; what it said is above")


def _pass_on(running: dict[Path, SpawnProcess], _number: int, _frame: object) -> None:
    """On SIGTERM: ask the processes to stop and to save, and wait for them."""
    for process in running.values():
        process.terminate()
    raise KeyboardInterrupt
