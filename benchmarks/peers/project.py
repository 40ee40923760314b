"""DrillRig itself, as one of the solvers; `python -m benchmarks.peers.project` times what it compiles at first."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.case import ONE_RIG, RIG, SAMPLE_PERIOD, START, Rigs, sample_times
from benchmarks.measure import seconds_of
from benchmarks.peers.peer import BatchPeer, Library, Peer, Run, Setting
from drillrig_env import Friction
from drillrig_env.arrays import FloatArray
from drillrig_env.stepper.batch import advance_batch
from drillrig_env.stepper.tables import TOLERANCE

LIBRARY = Library("DrillRig", "drillrig_env", "drillrig")
LOOSE, DEFAULT, TIGHT = Setting(1e-3, 0.0), Setting(TOLERANCE, 0.0), Setting(1e-7, 0.0)
SETTINGS = (LOOSE, DEFAULT, TIGHT)


def prepare(rigs: Rigs, setting: Setting, times: FloatArray, threads: int = 1) -> Run:
    """`advance_batch` in periods of 0.1 s, on some threads; times may be further apart."""
    friction = rigs.friction
    starts = np.tile(START, (len(rigs), 1))
    periods = round(float(times[-1]) / SAMPLE_PERIOD)
    every = periods // (len(times) - 1)

    def run() -> FloatArray:
        states = advance_batch(
            RIG,
            friction,
            starts,
            rigs.speed_reference,
            periods=periods,
            every=every,
            threads=threads,
            tolerance=setting.rtol,
        )
        return np.concatenate([starts[:, None], states], axis=1)

    advance_batch(RIG, Friction(), starts[:1], 2.0, tolerance=setting.rtol)
    return run


def prepare_one(setting: Setting, times: FloatArray) -> Run:
    """One rig."""
    run = prepare(ONE_RIG, setting, times)
    return lambda: run()[0]


def compile_seconds() -> float:
    """Seconds that the first simulation after an installation takes: it compiles, and stores what it compiled."""
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "benchmarks.peers.project"]
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        place = Path(__file__).parents[2]
        answer = subprocess.run(command, cwd=place, env=environment, check=True, capture_output=True, text=True)
    return float(answer.stdout)


PEERS = (Peer(LIBRARY, "fast stepper", "its own tables and kernel, made for this model", SETTINGS, prepare_one),)
BATCH_PEERS = tuple(
    BatchPeer(LIBRARY, f"fast stepper, {cores}", PEERS[0].form, SETTINGS, prepare, one_core=cores == "one core")
    for cores in ("all cores", "one core")
)

if __name__ == "__main__":
    print(seconds_of(lambda: prepare_one(DEFAULT, sample_times(SAMPLE_PERIOD))))
