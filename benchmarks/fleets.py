"""A fleet beside one rig: memory of a rig, time to build all, environment steps a second; in turns, on one thread.

    python -m benchmarks.fleets
    python -m benchmarks.fleets --quick

Every batch is a vector environment with as many episodes, in the midst of which it goes on: of the chapter's rig, of
fleets around it, every parameter of which is drawn within a factor, and of some of the fleets' rigs, each in a batch by
itself. That tells what a fleet costs from what its rigs cost: rigs that move faster take more steps of the solver. Rigs
hold their speed reference, so that most stick and slip. Times are those of the processor, for which other work on the
machine counts less than for a clock's; medians of the runs count, for ratios those of the turns.
Building is drawing the rigs and making their tables. Tables of the shortest steps are made only when a rig needs them;
how many did is told.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np

from benchmarks.measure import note, print_table
from drillrig_env import Fleet, Scenario
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.flags import of_kind
from drillrig_env.fleet import GROUPS
from drillrig_env.scales import CONTROL_PERIOD
from drillrig_env.stepper.ladder import DEPTH, RUNG
from drillrig_env.stepper.tables import build_tables

FACTORS = {
    "within a factor of 1.1": dict.fromkeys(GROUPS, 1.1),
    "within a factor of 2, motors 1.1": {**dict.fromkeys(GROUPS, 2.0), "motor": 1.1},
}
"""Factors of the fleets, by what their rigs are."""

ONE = "the chapter's alone"
RIGS, EPISODES, ALONE, STEPS, REPEATS = 256, 16, 16, 10, 9
QUICK = {"rigs": 32, "alone": 2, "repeats": 2}


def fleet_of(rigs: str, count: int, seed: int = 0) -> Fleet:
    """A fleet by what its rigs are."""
    return Fleet.around(spread=FACTORS[rigs], count=count, seed=seed)


def seconds_to_build(rigs: str, count: int, repeats: int) -> float:
    """Median time to draw a fleet and make its tables, s; every time another one."""
    fleets = [fleet_of(rigs, count, seed=1 + turn) for turn in range(repeats)]
    return statistics.median(
        processor_seconds(lambda fleet=fleet: build_tables(fleet.members().rigs, CONTROL_PERIOD))  # type: ignore[misc]
        for fleet in fleets
    )


def processor_seconds(work: Callable[[], object]) -> float:
    """Processor time of one call of `work`, s."""
    begin = time.process_time()
    work()
    return max(time.process_time() - begin, 1e-9)  # a coarse clock shows none of a short one


@dataclass(frozen=True)
class Batch:
    """Episodes of one fleet, at a moment to come back to."""

    env: Any
    moment: Any

    @classmethod
    def of(cls, episodes: int, fleet: Fleet | None) -> Batch:
        """Episodes of a fleet, or of the chapter's rig, after their first control step."""
        env: Any = gym.make_vec("DrillRig-v0", num_envs=episodes, scenario=Scenario(rigs=fleet), threads=1)
        env.reset(seed=0)
        env.step(np.zeros((episodes, 1), dtype=np.float32))
        return cls(env, env.get_state())

    def seconds(self, steps: int) -> float:
        """Time of some control steps of all episodes, from the moment on, s."""
        self.env.set_state(self.moment)
        return processor_seconds(self._play(steps))

    def _play(self, steps: int) -> Callable[[], None]:
        actions = np.zeros((self.env.num_envs, 1), dtype=np.float32)

        def play() -> None:
            for _ in range(steps):
                self.env.step(actions)

        return play

    @property
    def bytes_per_rig(self) -> float:
        """Memory of a rig's tables, without those of the shortest steps."""
        tables = self.env.core.bank.tables
        return float(tables.ladders.nbytes / len(tables.rigs))

    @property
    def with_shortest(self) -> int:
        """How many rigs have needed the shortest steps, and have tables of them."""
        return int(np.count_nonzero(self.env.core.bank.tables.ladders["shortest"]))


def measure(rigs: int, episodes: int, alone: int, repeats: int) -> list[list[str]]:
    """Rows of the table: what, memory a rig, rigs with the shortest steps, time to build, steps a second, and ratio."""
    note(f"{rigs * episodes:,} episodes of each kind begin")
    one, fleets = Batch.of(rigs * episodes, None), {}
    for kind in FACTORS:
        fleet = fleet_of(kind, rigs)
        some = fleet.members().rigs[:: max(1, rigs // alone)][:alone]
        singles = [Batch.of(rigs * episodes, Fleet(rigs=(rig,))) for rig in some]
        fleets[kind] = Batch.of(rigs * episodes, fleet), singles
    times: dict[str, list[float]] = {name: [] for name in (ONE, *FACTORS, *map(by_itself, FACTORS))}
    for turn in range(repeats):
        note(f"run {turn + 1} of {repeats}")
        times[ONE].append(one.seconds(STEPS))
        for kind, (together, singles) in fleets.items():
            times[kind].append(together.seconds(STEPS))
            times[by_itself(kind)].append(statistics.mean(single.seconds(STEPS) for single in singles))
    rows = []
    for kind, found in times.items():
        rate = rigs * episodes * STEPS / statistics.median(found)
        ratio = statistics.median(mine / its for mine, its in zip(times[ONE], found, strict=True))
        beside = ["", "", ""]
        if kind in FACTORS:
            batch, build = fleets[kind][0], seconds_to_build(kind, rigs, repeats)
            beside = [f"{batch.bytes_per_rig / 1e3:.1f} kB", f"{batch.with_shortest:,}", f"{build:.2f} s"]
        rows.append([kind, *beside, f"{rate:,.0f}", f"{ratio:.2f}"])
    return rows


def by_itself(kind: str) -> str:
    """The name of the rigs of a fleet in batches of their own."""
    return f"{kind}, each by itself"


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print the table."""
    parser = Parser(prog="python -m benchmarks.fleets", description=__doc__)
    add = parser.add_argument
    add("--rigs", type=of_kind(COUNT), help=f"of a fleet (default: {RIGS}; quick: {QUICK['rigs']})")
    add("--episodes", type=of_kind(COUNT), default=EPISODES, help=f"of each rig, in the mean (default: {EPISODES})")
    add("--alone", type=of_kind(COUNT), help=f"rigs by themselves (default: {ALONE}; quick: {QUICK['alone']})")
    add("--repeats", type=of_kind(COUNT), help=f"runs that count (default: {REPEATS}; quick: {QUICK['repeats']})")
    add("--quick", action="store_true", help="a first look: few rigs, few runs")
    chosen = parser.parse_args(arguments)
    usual = QUICK if chosen.quick else {"rigs": RIGS, "alone": ALONE, "repeats": REPEATS}
    rigs = chosen.rigs or usual["rigs"]
    rows = measure(rigs, chosen.episodes, chosen.alone or usual["alone"], chosen.repeats or usual["repeats"])
    build = f"{rigs} drawn and built"
    print_table(["rigs", "memory a rig", "with shortest steps", build, "steps/s", "times the chapter's"], rows)
    print(f"\nThe shortest steps of a rig take {DEPTH * RUNG.itemsize / 1e3:.1f} kB more.")
    print(f"{rigs * chosen.episodes:,} episodes. {provenance()['machine']}, {provenance()['date']}.")


if __name__ == "__main__":
    raise SystemExit(main())
