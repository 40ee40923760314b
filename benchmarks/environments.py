"""Environment steps a second, one copy and many side by side, beside other environments in the same run.

    python -m benchmarks.environments
    python -m benchmarks.environments --quick

Two ways, both with wrappers, rewards, observations, info and resets:

- random actions: Gymnasium's own `benchmark_step` and `benchmark_vector_step`. Drawing the actions is in the
  time (and timed apart), and for a batch of long episodes the time may be over before the first one ends;
- a fixed action: whole episodes and nothing but `step` and `reset`. The rig's holds the speed reference, so that most
  rigs stick and slip, which is the dearest they can do; random actions shake the reference about.

A step is one step of one copy; the one with which a copy begins its next episode is not counted. The
environments take turns, a short run each, and medians of their runs count. Memory per rig is the growth of a fresh
process's resident memory from a small to a large vector environment, after a reset and a few steps.
"""

from __future__ import annotations

import os
import statistics
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import performance

from benchmarks.environment_peers import LARGEST, OURS, Environment, Peer, peers
from benchmarks.measure import in_new_process, kept, note, print_table, write_json
from drillrig_env.allowed import COUNT, POSITIVE
from drillrig_env.command_line import Parser, command
from drillrig_env.flags import of_kind
from drillrig_env.jit.threads import available_threads

SIZES = (1, 64, 256, 1024, 4096, 16_384, LARGEST)
QUICK_SIZES = (1, 64, 1024)
MEMORY_SIZES, QUICK_MEMORY_SIZES = (1024, LARGEST), (1024, 16_384)
_BLOCK = 600  # steps of environments whose episodes end by their state
_FIRST_RESETS = 8  # of one copy, ahead of all timing: a start in stick-slip has kernels of its own

Rates = dict[str, Any]


def random_rate(env: Environment, count: int, seconds: float) -> float | None:
    """Steps a second under random actions, by Gymnasium's own functions; `None` where it has none for many copies."""
    if count == 1:
        return float(performance.benchmark_step(env, seconds, seed=0))  # type: ignore[arg-type]
    benchmark = getattr(performance, "benchmark_vector_step", None)
    return None if benchmark is None else float(benchmark(env, seconds, seed=0))


def fixed_rate(env: Environment, peer: Peer, count: int, seconds: float) -> float:
    """Steps a second under the peer's fixed action, over whole episodes for `seconds` s or longer."""
    env.reset(seed=0)
    play = _play_one(env, peer) if count == 1 else _play_many(env, peer, count)
    steps, begin = 0, time.perf_counter()
    while True:
        steps += play()
        passed = time.perf_counter() - begin
        if passed >= seconds:
            return steps / passed


def fixed_actions(env: Environment, peer: Peer) -> Any:
    """The peer's fixed action, once for each copy of the environment."""
    shape = env.action_space.shape
    return np.resize(peer.action, shape) if shape else peer.action


def _play_one(env: Environment, peer: Peer) -> Callable[[], int]:
    block, action = peer.episode or _BLOCK, fixed_actions(env, peer)

    def play() -> int:
        for _ in range(block):
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
        return block

    return play


def _play_many(env: Environment, peer: Peer, count: int) -> Callable[[], int]:
    calls = (peer.episode or _BLOCK) + 1  # the last call begins the next episode
    actions = fixed_actions(env, peer)

    def play() -> int:
        resets = 0
        for _ in range(calls):
            _, _, terminated, truncated, _ = env.step(actions)
            resets += int(np.count_nonzero(terminated | truncated))
        return calls * count - resets

    return play


def seconds_per_draw(env: Environment, seconds: float = 0.05) -> float:
    """Time to draw one random action for all copies, s."""
    draws, begin = 0, time.perf_counter()
    while (passed := time.perf_counter() - begin) < seconds:
        env.action_space.sample()
        draws += 1
    return passed / draws


def measure(found: Iterable[Peer], count: int, repeats: int, seconds: float) -> Iterator[Rates]:
    """Runs and medians of `count` copies of each environment, by name, after each run; they take turns."""
    envs = {}
    for peer in found:
        if peer.smallest <= count <= peer.largest:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # some make their spaces in another precision, and say so
                    envs[peer.name] = peer, peer.make(count)
            except Exception as error:  # a peer's trouble must not end the run
                if peer.package is None:
                    raise
                note(f"{peer.name} is left out, it does not run here: {error}")
    for peer, env in envs.values():  # compiled code is loaded, or made
        for seed in range(_FIRST_RESETS if count == 1 else 1):
            env.reset(seed=seed)
            env.step(fixed_actions(env, peer))
    runs: dict[str, dict[str, list[float]]] = {name: {"fixed": [], "random": [], "draw": []} for name in envs}
    for turn in range(repeats):
        note(f"{count:,} {'copy' if count == 1 else 'copies'} of each environment: run {turn + 1} of {repeats}")
        for name, (peer, env) in envs.items():
            runs[name]["fixed"].append(fixed_rate(env, peer, count, seconds))
            if (rate := random_rate(env, count, seconds)) is not None:
                runs[name]["random"].append(rate)
            runs[name]["draw"].append(seconds_per_draw(env))
            yield {name: summary(ways) for name, ways in runs.items() if ways["fixed"]}
    for _, env in envs.values():
        env.close()


def summary(runs: dict[str, list[float]]) -> Rates:
    """Medians of an environment's runs, and the runs themselves."""
    keys = {"fixed": "steps_per_second_fixed", "random": "steps_per_second_random", "draw": "seconds_per_draw"}
    medians = {keys[way]: statistics.median(found) for way, found in runs.items() if found}
    return {**medians, **{f"runs_{way}": list(found) for way, found in runs.items() if way != "draw"}}


def resident_bytes(count: int) -> int:
    """Resident memory of this process with `count` rigs after a reset and a few steps, bytes; Linux only."""
    env = gym.make_vec(OURS, num_envs=count, vectorization_mode="vector_entry_point")
    kept: Any = env.reset(seed=0)
    for _ in range(5):
        kept = env.step(np.zeros((count, 1), dtype=np.float32))
    assert kept is not None
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def memory(small: int, large: int, repeats: int) -> dict[str, Any]:
    """Resident bytes of fresh processes with few and many rigs, and what a rig more takes."""
    resident: dict[int, list[int]] = {small: [], large: []}
    for _ in range(repeats):
        for count, found in resident.items():
            found.append(in_new_process(resident_bytes, count))
    growth = statistics.median(resident[large]) - statistics.median(resident[small])
    return {
        "bytes_per_rig": growth / (large - small),
        "resident_bytes": {str(count): statistics.median(found) for count, found in resident.items()},
    }


def tabulate(results: dict[str, Any]) -> None:
    """Print every measurement, and how often faster or slower the project's environment is."""

    def cells(rates: Rates, ours: Rates, way: str) -> list[str]:
        rate, own = rates.get(f"steps_per_second_{way}"), ours.get(f"steps_per_second_{way}")
        return ["-" if rate is None else f"{rate:,.0f}", "-" if rate is None or own is None else f"{own / rate:.2f}"]

    rows = []
    for size, found in results["rates"].items():
        ours = found.get(OURS, {})
        for name, rates in found.items():
            per_step = f"{1e9 / rates['steps_per_second_fixed']:,.0f}"
            ways = (*cells(rates, ours, "fixed"), *cells(rates, ours, "random"))
            rows.append([f"{int(size):,}", name, *ways, per_step])
    ratio = f"{OURS} / it"
    heads = ("fixed action, steps/s", ratio, "random actions, steps/s", ratio, "ns a step, fixed action")
    print_table(["copies", "environment", *heads], rows)
    if "memory" in results:
        print(f"\nmemory: {results['memory']['bytes_per_rig']:,.0f} bytes per rig in the vector environment")


@command
def main(arguments: list[str] | None = None) -> None:
    """Measure, write the figures after every size, and print the table."""
    parser = Parser(prog="python -m benchmarks.environments", description=__doc__)
    parser.add_argument("--repeats", type=of_kind(COUNT), help="runs of which the median counts (default: 5; quick: 1)")
    parser.add_argument(
        "--seconds", type=of_kind(POSITIVE, "s"), help="shortest length of a run, s (default: 1; quick: 0.2)"
    )
    parser.add_argument(
        "--sizes", type=of_kind(COUNT), nargs="+", metavar="N", help=f"numbers of copies (default: {SIZES})"
    )
    parser.add_argument("--quick", action="store_true", help=f"a first look: sizes {QUICK_SIZES}, one short run each")
    parser.add_argument(
        "--json", type=Path, default=Path("results/benchmarks/environments.json"), help="where to write"
    )
    chosen = parser.parse_args(arguments)
    repeats = chosen.repeats or (1 if chosen.quick else 5)
    seconds = chosen.seconds or (0.2 if chosen.quick else 1.0)
    sizes = chosen.sizes or (QUICK_SIZES if chosen.quick else SIZES)
    found = peers()
    left_out = [hint for peer in found if (hint := peer.missing())]
    for hint in left_out:
        note(hint)
    found = [peer for peer in found if peer.missing() is None]
    if not hasattr(performance, "benchmark_vector_step"):
        note(
            f"Gymnasium {gym.__version__} has no benchmark_vector_step: many copies under random actions "
            "are left out; install a newer one with: pip install --upgrade gymnasium"
        )
    results: dict[str, Any] = {
        "quick": chosen.quick,
        "cores": available_threads(),
        "left_out": left_out,
        "repeats": repeats,
        "seconds_per_run": seconds,
        "environments": {peer.name: peer.about for peer in found},
        "versions": {peer.package[1]: version(peer.package[1]) for peer in found if peer.package},
        "rates": {},
    }

    def tell() -> None:
        tabulate(results)
        write_json(chosen.json, results)

    with kept(chosen.json, tell):
        for size in sizes:
            for rates in measure(found, size, repeats, seconds):
                results["rates"][str(size)] = rates
                write_json(chosen.json, results, announce=False)
        if Path("/proc/self/statm").exists():
            note("memory per rig, in fresh processes")
            results["memory"] = memory(*(QUICK_MEMORY_SIZES if chosen.quick else MEMORY_SIZES), min(repeats, 3))
            write_json(chosen.json, results, announce=False)


if __name__ == "__main__":
    raise SystemExit(main())
