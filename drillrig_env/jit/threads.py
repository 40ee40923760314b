"""Run a compiled kernel over slices of a batch, on as many threads as there are cores.

Kernels release the GIL and treat each rig by itself, so the slices change nothing in the result:
the same machine code sees the same numbers, whatever the number of threads.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from itertools import pairwise

from drillrig_env.allowed import COUNT
from drillrig_env.parameters import checked

_PERIODS_WORTH_A_THREAD = 192
"""Waking another thread takes as long as some hundred periods of 0.1 s of a rig."""


_most = [sys.maxsize]


def available_threads() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def use_threads(most: int) -> None:
    """Let kernels that are given no number of threads use at most so many, where other processes have their share."""
    _most[:] = [most]


def check_threads(threads: int | None) -> int:
    """The number of threads to use: `threads`, or all cores where it is None. `ValueError` for any other."""
    if threads is None:
        return min(available_threads(), *_most)
    return int(checked("threads", "threads", threads, "", COUNT))


def over_slices(kernel: Callable[[slice], object], rigs: int, threads: int, periods: int = 1) -> None:
    """Call `kernel` for slices that cover the `rigs` of a batch, side by side where that pays.

    `periods` is how many periods of about 0.1 s the kernel takes each rig through.
    """
    workers = min(threads, rigs, max(1, rigs * periods // _PERIODS_WORTH_A_THREAD))
    if workers == 1:
        kernel(slice(0, rigs))
        return
    edges = [rigs * i // workers for i in range(workers + 1)]
    slices = [slice(a, b) for a, b in pairwise(edges)]
    others = [_pool(os.getpid()).submit(kernel, part) for part in slices[1:]]
    kernel(slices[0])
    for other in others:
        other.result()


@lru_cache(maxsize=1)
def _pool(_process: int) -> ThreadPoolExecutor:
    """One pool a process: a forked child must not wait for its parent's threads."""
    return ThreadPoolExecutor(max_workers=available_threads(), thread_name_prefix="drillrig")
