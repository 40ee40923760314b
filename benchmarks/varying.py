"""What it costs that force, friction and target vary within an episode: control steps of each scenario, in turns.

    python -m benchmarks.varying
    python -m benchmarks.varying --rigs 512 --repeats 9

Rigs move their speed references at random. "at rest" is the machinery alone, with friction and force as they would be
without it; otherwise steeper friction, and a force that changes within a step, need shorter steps besides. Medians of
the runs on one thread count, by the processor's time; a first call, which compiles, does not.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.measure import note, print_table
from drillrig_env import Course, Scenario, Tilt, Wandering
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.flags import of_kind

RIGS, REPEATS, STEPS = 2048, 7, 100
_FORCE = 15.0  # N, of all rigs, so that a course can have the same


def scenarios() -> dict[str, Scenario]:
    """The scenarios that are compared, by name."""
    plain, times = Scenario(normal_force=(_FORCE, _FORCE), load_step=0.0), np.arange(0.0, 60.0, 0.1)
    course = Course(times, normal_force=np.full(len(times), _FORCE))
    return {
        "nothing varies": plain,
        "course of N_1, at rest": replace(plain, course=course),
        "wandering, at rest": replace(plain, wandering=Wandering(1e-9)),
        "wandering by 0.2": replace(plain, wandering=Wandering(0.2)),
        "tilt, at rest": replace(plain, tilt=Tilt(1e-9, (1, 2))),
        "tilt of 0.1, m = 1 and 2": replace(plain, tilt=Tilt(0.1, (1, 2))),
    }


def nanoseconds(rigs: int, repeats: int) -> dict[str, float]:
    """Median time of a control step of one rig by scenario, in nanoseconds."""
    batches = {name: EpisodeBatch(rigs, scenario=scenario, threads=1) for name, scenario in scenarios().items()}
    runs: dict[str, list[float]] = {name: [] for name in batches}
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (STEPS, rigs, 1)).astype(np.float32)
    for turn in range(repeats + 1):
        note(f"run {turn} of {repeats}" if turn else "compiling")
        for name, batch in batches.items():
            batch.reset(np.arange(rigs), first_uniforms(0, rigs))
            begun = time.process_time()
            for action in actions:
                batch.step(action)
            if turn:
                runs[name].append((time.process_time() - begun) / (rigs * STEPS) * 1e9)
    return {name: statistics.median(times) for name, times in runs.items()}


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print the table."""
    parser = Parser(prog="python -m benchmarks.varying", description=__doc__)
    add = parser.add_argument
    add("--rigs", type=of_kind(COUNT), default=RIGS, help=f"side by side (default: {RIGS})")
    add("--repeats", type=of_kind(COUNT), default=REPEATS, help=f"runs of which the median counts (default: {REPEATS})")
    chosen = parser.parse_args(arguments)
    times = nanoseconds(chosen.rigs, chosen.repeats)
    plain = times["nothing varies"]
    rows = [[name, f"{found:,.0f}", f"{found / plain:.2f}"] for name, found in times.items()]
    print_table(["scenario", "ns a step", "times the plain one"], rows)


if __name__ == "__main__":
    raise SystemExit(main())
