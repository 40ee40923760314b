"""Stored reference trajectories: 30 runs of 20 s with steps of speed reference and normal force.

Each is an event-split Radau solution (relative tolerance 1e-11). `python -m tests.reference` makes
the file again, in about a minute and a half; a slow test checks that it would come out the same.
"""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.simulation import simulate

FILE = Path(__file__).with_name("trajectories.npz")
CASES = list(product((2.0, 10.0, 20.0, 30.0, 40.0), (0.3, 1.0, 2.0, 3.5, 6.0, 9.0)))
"""Normal force (N) and speed reference (rad/s) of each run."""


def arguments(normal_force: float, speed: float) -> dict[str, Any]:
    """The arguments of `simulate` for a run, method and sample period aside."""
    return {
        "friction": Friction(normal_force),
        "initial_state": (0.0, 0.0, speed, speed, speed, 0.5, 0.0),
        "duration": 20.0,
        "speed_reference": [(0, speed), (8, min(1.3 * speed, 10.0)), (14, speed)],
        "normal_force": [(0, normal_force), (5, 0.6 * normal_force), (11, normal_force)],
    }


def solve(case: tuple[float, float]) -> FloatArray:
    """The reference speeds of a run (discs 1 and 2, motor) every 0.1 s, rad/s; shape (201, 3)."""
    return simulate(method="radau", sample_period=0.1, **arguments(*case)).state[:, 2:5]


def stored() -> dict[tuple[float, float], FloatArray]:
    """The stored speeds of every run."""
    with np.load(FILE) as file:
        return dict(zip(CASES, file["speeds"], strict=True))
