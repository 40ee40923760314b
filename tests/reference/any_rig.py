"""Stored speeds of 200 rigs of all kinds, drawn at random, by the independent solution of `benchmarks.radau9`.

`python -m tests.reference.any_rig` makes the file again, in a quarter of a minute; a slow test checks that it would
come out the same.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.any_rig import Case, draw, reference
from drillrig_env.arrays import FloatArray

FILE = Path(__file__).with_name("any_rig.npz")
RIGS, SEED = 200, 14


def stored() -> list[tuple[Case, FloatArray]]:
    """Every run with its speeds (discs 1 and 2, motor) every 0.5 s over 10 s, rad/s; shape (21, 3)."""
    with np.load(FILE) as file:
        return [(Case.of(row), speeds) for row, speeds in zip(file["cases"], file["speeds"], strict=True)]


if __name__ == "__main__":
    drawn, cases, speeds = draw(RIGS + 20, SEED), [], []
    for case in drawn:
        found = reference(case)
        if found is not None:
            cases.append(case.numbers())
            speeds.append(found)
    np.savez_compressed(FILE, cases=np.array(cases[:RIGS]), speeds=np.array(speeds[:RIGS]))
    print(f"{FILE}: {RIGS} runs")
