"""What a reward of the user's own costs: the default, terms that are compiled, the same terms in Python; in turns.

    python -m benchmarks.own_reward
    python -m benchmarks.own_reward --sizes 1 64 4096 --repeats 9

The terms are two that read four numbers of the episode. Rigs hold their speed reference, so that most stick and slip;
one copy is `DrillRigEnv`, more are one vector environment on one thread. Medians of the runs count; a first call, which
compiles, does not.
"""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np

from benchmarks.measure import note, print_table, seconds_of
from drillrig_env import Reward, RewardTerms
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.flags import of_kind

SIZES, REPEATS = (1, 64, 4096), 7
_WORK, _MOST = 40_000, 500  # environment steps of a run, and most control steps
_NAMES = ("torque", "effort")


def terms(string_torque_highest: Any, speed_reference: Any, speed_target: Any, action: Any) -> Any:
    """Two terms, for numbers as for arrays."""
    return -(string_torque_highest**2), -0.1 * ((speed_reference - speed_target) / speed_target) ** 2 - 0.01 * action**2


def rewards() -> dict[str, Reward]:
    """The rewards that are compared, by name."""
    compiled, python = (RewardTerms(_NAMES, terms, compiled=compiled) for compiled in (True, False))
    return {"default": Reward(), "compiled terms": Reward(own=compiled), "terms in Python": Reward(own=python)}


def microseconds(sizes: Sequence[int], repeats: int) -> dict[int, dict[str, float]]:
    """Median time of a control step of all copies, in microseconds, by number of copies and by reward."""
    found = {}
    for size in sizes:
        steps = min(max(5, _WORK // size), _MOST)
        envs = {name: _made(size, reward) for name, reward in rewards().items()}
        runs: dict[str, list[float]] = {name: [] for name in envs}
        for turn in range(repeats):
            note(f"{size:,} {'copy' if size == 1 else 'copies'}: run {turn + 1} of {repeats}")
            for name, env in envs.items():
                runs[name].append(1e6 * _seconds(env, steps) / steps)
        found[size] = {name: statistics.median(times) for name, times in runs.items()}
    return found


def _made(size: int, reward: Reward) -> Any:
    if size == 1:
        return gym.make("DrillRig-v0", reward=reward).unwrapped
    return gym.make_vec("DrillRig-v0", num_envs=size, reward=reward, threads=1)


def _seconds(env: Any, steps: int) -> float:
    """Time of some control steps at the start of an episode, s."""
    actions = np.zeros(env.action_space.shape, dtype=np.float32)
    env.reset(seed=0)
    env.step(actions)

    def play() -> None:
        for _ in range(steps):
            env.step(actions)

    return seconds_of(play)


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print the table."""
    parser = Parser(prog="python -m benchmarks.own_reward", description=__doc__)
    add = parser.add_argument
    add("--sizes", type=of_kind(COUNT), nargs="+", default=SIZES, metavar="N", help=f"copies (default: {SIZES})")
    add("--repeats", type=of_kind(COUNT), default=REPEATS, help=f"runs of which the median counts (default: {REPEATS})")
    chosen = parser.parse_args(arguments)
    rows = [
        [f"{size:,}", name, f"{time:,.1f}", f"{size / time * 1e6:,.0f}", f"{time / times['default']:.2f}"]
        for size, times in microseconds(chosen.sizes, chosen.repeats).items()
        for name, time in times.items()
    ]
    print_table(["copies", "reward", "us a step of all", "steps/s", "times the default"], rows)


if __name__ == "__main__":
    raise SystemExit(main())
