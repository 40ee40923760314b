"""A run that was kept, as a suite: every policy faces what its rig faced, with the same start, noise and delay."""

from __future__ import annotations

from pathlib import Path

from drillrig_env.env.recorded import Recorded
from drillrig_env.evaluation.suites import Suite
from drillrig_env.scales import Scales
from drillrig_env.verdict import WINDOW


def suite_of(path: str | Path, lane: str = "A") -> tuple[Recorded, Suite]:
    """A run from a file that the control room has kept, and the suite of its one rig.

    Noise and delay are those of a `lane`. A policy that controlled it alone does what it did then, bit for bit.
    Raises as `Recorded.read` does, and `ValueError` for a run that is too short to be judged.
    """
    run = Recorded.read(path)
    own = run.environment(lane)
    scales = Scales.of(run.rig)
    least = WINDOW * scales.time
    if own["duration"] < least * (1.0 - 1e-9):
        raise ValueError(f"{path}: a run of {own['duration']:.4g} s is not judged; allowed: {least:.4g} s or more")
    taken = {name: own[name] for name in ("noise", "delay", "slew_limit", "duration")}
    groups = ((1, {"start": run.start}),)
    about = f"the run of {Path(path).name}, {run.steps} control steps"
    return run, Suite("run", about, own["scenario"], groups, taken, run.seed, scales)
