"""numbalsoda: LSODA and DOP853 in machine code, driven from machine code; no Python inside a run.

The right-hand side is a C callback that Numba compiles. LSODA's absolute tolerances are those that
were found to serve it best. A batch runs on a pool of threads, each of which holds no lock of Python's
and takes the next few rigs when it is done with some. DOP853 is explicit and tells on standard output
that the problem is stiff, which it is; the benchmark sends that nowhere.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import pairwise
from typing import Any

import numba
import numpy as np

from benchmarks.case import ONE_RIG, START, Rigs, compiled_rates
from benchmarks.peers.peer import BatchPeer, Library, Peer, Run, Setting, settings
from drillrig_env.arrays import FloatArray

os.environ.setdefault("GFORTRAN_UNBUFFERED_PRECONNECTED", "y")  # else DOP853's remarks come when Python ends

LIBRARY = Library("numbalsoda", "numbalsoda", "numbalsoda")
STEPS = 10_000_000
PARTS = 16  # of a batch, for each thread


def kernel(method: str) -> tuple[Callable[..., bool], Any]:
    """A compiled loop over rigs, and the address of the right-hand side: `loop(address, contacts, ..., result)`."""
    import numbalsoda
    from numba import carray  # type: ignore[attr-defined,unused-ignore]

    solve, rates = getattr(numbalsoda, method), compiled_rates()

    @numba.cfunc(numbalsoda.lsoda_sig)
    def right_hand_side(_t: float, x: Any, out: Any, contact: Any) -> None:
        rates(carray(x, 7), carray(contact, 4), carray(out, 7))

    @numba.njit(nogil=True, error_model="numpy")
    def loop(
        address: int,
        contacts: FloatArray,
        start: FloatArray,
        times: FloatArray,
        rtol: float,
        atol: float,
        result: FloatArray,
    ) -> bool:
        done = True
        for n in range(len(contacts)):
            states, success = solve(address, start, times, contacts[n], rtol, atol, STEPS)
            result[n] = states
            done = done and success
        return done

    return loop, right_hand_side.address


def prepare_batch(rigs: Rigs, setting: Setting, times: FloatArray, threads: int = 1, method: str = "lsoda") -> Run:
    """Many rigs on a pool of threads."""
    loop, address = kernel(method)
    contacts, pool = rigs.contacts, ThreadPoolExecutor(threads)
    edges = np.unique(np.linspace(0, len(rigs), threads * PARTS + 1).round().astype(int)).tolist()

    def part(first: int, last: int, times: FloatArray, result: FloatArray) -> None:
        if not loop(address, contacts[first:last], START, times, setting.rtol, setting.atol, result[first:last]):
            raise RuntimeError(f"numbalsoda: {method} gave up")

    def run() -> FloatArray:
        result = np.empty((len(rigs), len(times), 7))
        if len(edges) == 2:
            part(0, len(rigs), times, result)
        else:
            parts = [pool.submit(part, a, b, times, result) for a, b in pairwise(edges)]
            for each in parts:
                each.result()
        return result

    part(0, 1, 0.01 * times[:2], np.empty((1, 2, 7)))
    return run


def prepare_lsoda(setting: Setting, times: FloatArray) -> Run:
    """One rig with LSODA."""
    run = prepare_batch(ONE_RIG, setting, times)
    return lambda: np.asarray(run()[0])


def prepare_dop853(setting: Setting, times: FloatArray) -> Run:
    """One rig with DOP853."""
    with silent():
        run = prepare_batch(ONE_RIG, setting, times, method="dop853")

    def quiet() -> FloatArray:
        with silent():
            return np.asarray(run()[0])

    return quiet


@contextmanager
def silent() -> Iterator[None]:
    """Send nowhere what compiled code writes to standard output."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


FORM = "compiled right-hand side"
PEERS = (
    Peer(
        LIBRARY,
        "LSODA",
        FORM,
        (
            *settings(1e-4, 4e-5, 2e-5, ratio=1e-2),
            Setting(2e-5, 6e-7),
            *settings(1e-5, 1e-6, 1e-7, 2e-8, 1e-8, ratio=0.1),
            *settings(7e-9, 5e-9, 1e-9, 1e-10, ratio=1.0),
        ),
        prepare_lsoda,
    ),
    Peer(LIBRARY, "DOP853", FORM, settings(1e-3, 1e-4, 1e-6, 1e-8, 1e-10), prepare_dop853),
)
BATCH_PEERS = (
    BatchPeer(
        LIBRARY,
        "LSODA, all cores",
        FORM,
        (Setting(4e-5, 4e-7), Setting(1e-6, 1e-7), Setting(7e-9, 7e-9)),
        prepare_batch,
    ),
)
