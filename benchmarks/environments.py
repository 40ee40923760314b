"""Environment steps a second, single and vectorised, beside Gymnasium's CartPole in the same run.

    python -m benchmarks.environments

Single environments come from `gym.make`, with its wrappers; resets, rewards, observations and info
are included, and a constant action spares the cost of sampling: the rig's holds the speed reference, so that
most rigs stick and slip, which is the dearest they can do. Medians of several runs.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

import drillrig_env
from benchmarks.measure import median_seconds, print_table, write_json


def single(name: str, action: Any, steps: int, repeats: int) -> float:
    """Steps a second of one environment, whole episodes with their resets."""
    env = gym.make(name)
    env.reset(seed=0)

    def work() -> None:
        for _ in range(steps):
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()

    return steps / median_seconds(work, repeats)


def vector(name: str, num_envs: int, action: Any, repeats: int) -> float:
    """Steps a second of a native vector environment over whole episodes and their autoresets."""
    env = gym.make_vec(name, num_envs=num_envs, vectorization_mode="vector_entry_point")
    env.reset(seed=0)
    actions = np.broadcast_to(np.asarray(action), env.action_space.shape).copy()  # type: ignore[arg-type]
    steps = 601

    def work() -> None:
        for _ in range(steps):
            env.step(actions)

    return steps * num_envs / median_seconds(work, repeats)


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5, help="runs of which the median counts (default: 5)")
    parser.add_argument(
        "--json", type=Path, default=Path("results/environments.json"), help="where to write the figures"
    )
    arguments = parser.parse_args()
    drillrig_env.register_envs()
    rate, push = np.array([0.0], dtype=np.float32), 1
    results = {
        "gym.make": (
            single("DrillRig-v0", rate, 20_000, arguments.repeats),
            single("CartPole-v1", push, 20_000, arguments.repeats),
        )
    }
    for num_envs in (64, 1024, 4096):
        results[f"gym.make_vec, {num_envs:,}"] = (
            vector("DrillRig-v0", num_envs, rate, arguments.repeats),
            vector("CartPole-v1", num_envs, push, arguments.repeats),
        )
    print_table(
        ["form", "DrillRig-v0, steps/s", "CartPole-v1, steps/s", "ratio"],
        [[form, f"{ours:,.0f}", f"{theirs:,.0f}", f"{ours / theirs:.2f}"] for form, (ours, theirs) in results.items()],
    )
    write_json(
        arguments.json,
        {form: {"DrillRig-v0": ours, "CartPole-v1": theirs} for form, (ours, theirs) in results.items()},
    )


if __name__ == "__main__":
    main()
