"""What the benchmarks share: medians of timings, memory, new processes and JSON files."""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import statistics
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from drillrig_env import markdown
from drillrig_env.command_line import deaf_to_interrupt
from drillrig_env.engine.likeness import processor
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.files import check_writable_file, json_text, write_text

LEAST_SECONDS = 0.02
"""Shorter work is repeated within one timing until it takes about this long, s."""


def median_seconds(work: Callable[[], object], repeats: int, *, warm: bool = False) -> float:
    """Median wall time of `work` over `repeats` runs after one that is not counted, unless `work` is warm already."""
    if not warm:
        work()
    return statistics.median(timing(work) for _ in range(repeats))


def timing(work: Callable[[], object]) -> float:
    """Wall time of one call of warm `work`, s.

    Work of less than `LEAST_SECONDS` is called several times in a row, so that neither the clock nor one
    interruption by the system counts.
    """
    once = seconds_of(work)
    if once >= LEAST_SECONDS:
        return once
    calls = math.ceil(LEAST_SECONDS / max(once, 1e-9))
    begin = time.perf_counter()
    for _ in range(calls):
        work()
    return (time.perf_counter() - begin) / calls


def seconds_of(work: Callable[[], object]) -> float:
    """Wall time of one call of `work`, s."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def use_one_core() -> None:
    """Bind this process, and the threads that it will start, to one core, where the system can do that."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def memory_growth(work: Callable[[], object]) -> int:
    """By how much the process's resident memory grows at its peak while `work` runs, bytes.

    Linux forgets the peak so far on request; elsewhere growth below an earlier peak is not seen.
    """
    forget = Path("/proc/self/clear_refs")
    if forget.exists():
        forget.write_text("5", encoding="ascii")
    before = peak_memory()
    work()
    return peak_memory() - before


def peak_memory() -> int:
    """Largest resident memory of this process so far, bytes."""
    status = Path("/proc/self/status")
    if status.exists():
        line = next(line for line in status.read_text(encoding="ascii").splitlines() if line.startswith("VmHWM"))
        return 1024 * int(line.split()[1])
    import resource  # not there on Windows

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


def in_new_process(work: Callable[..., Any], *arguments: Any, timeout: float | None = None) -> Any:
    """The result of `work(*arguments)` in a Python process of its own, which starts from nothing.

    Raises `TimeoutError` after `timeout` s, and `RuntimeError` with the reason where `work` fails.
    """
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_answer, args=(sender, work, arguments), daemon=True)
    with deaf_to_interrupt():
        process.start()
    sender.close()
    try:
        if not receiver.poll(timeout):
            raise TimeoutError(f"no result within {timeout:g} s")
        failure, result = receiver.recv()
    except EOFError:
        process.join()
        raise RuntimeError(f"the process ended with status {process.exitcode}") from None
    finally:
        process.kill()
        process.join()
    if failure:
        raise RuntimeError(failure)
    return result


def _answer(sender: Connection, work: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # where it is not inherited, as on Windows
    try:
        sender.send((None, work(*arguments)))
    except Exception as error:
        sender.send((f"{type(error).__name__}: {error}", None))


@contextmanager
def kept(path: Path, report: Callable[[], object]) -> Iterator[None]:
    """Measure within the block: when it ends, and when it is stopped, `report` prints and writes what there is.

    `OSError`, before anything is measured, where `path` cannot be written.
    """
    check_writable_file(path)
    try:
        yield
    except KeyboardInterrupt as stop:
        report()
        stop.add_note("what was measured is kept")
        raise
    report()


def note(line: str) -> None:
    """Tell on standard error how far a benchmark is."""
    print(line, file=sys.stderr, flush=True)


def print_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a Markdown table."""
    print(markdown.table(headings, rows, words=len(headings)))


def write_json(path: Path, results: dict[str, Any], *, announce: bool = True) -> None:
    """Write results beside machine, versions and date; `announce` prints where."""
    write_text(path, json_text({"machine": processor(), "provenance": provenance(), "results": results}))
    if announce:
        print(f"\n{processor()}; written to {path}")
