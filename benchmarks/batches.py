"""Many rigs at once (5 to 40 N, 0.5 to 5 rad/s, 10 s each): how time and memory grow with their number.

    python -m benchmarks.batches
    python -m benchmarks.batches --quick
    python -m benchmarks.batches --only DrillRig --sizes 256 4096 65536 262144 --limit 300

Every measurement has a process of its own, in which compilation comes first and is timed apart. The rigs and
their start are the same for all; the states after 10 s are what is asked for, so that memory is what a solver
needs rather than what it is asked to keep. The error is that of the bit speed, the largest of samples every
0.1 s for each of a fixed few rigs, against Radau with the kinks split by events (rtol 1e-9); the table has the
median and the 90 % quantile over those rigs. A size is left out, with the reason, where it would take longer
than --limit by the times of the sizes before, and a batch is repeated less often where --repeats would take
longer than that in all. torchdiffeq gets 1 s of motion only.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.case import NORMAL_FORCES, SPEED_REFERENCES, Rigs, drawn_rigs, largest_errors, sample_times
from benchmarks.measure import (
    in_new_process,
    kept,
    median_seconds,
    memory_growth,
    note,
    print_table,
    seconds_of,
    use_one_core,
    write_json,
)
from benchmarks.peers import BATCH_PEERS
from benchmarks.peers.peer import BatchPeer, Run, Setting, asked_for, left_out
from drillrig_env.allowed import COUNT, POSITIVE
from drillrig_env.arrays import FloatArray
from drillrig_env.command_line import Parser, command
from drillrig_env.engine import Local
from drillrig_env.flags import of_kind
from drillrig_env.jit.threads import available_threads

SIZES = (1, 16, 256, 4096, 65536)
DURATION, BASE_SIZE = 10.0, 256  # s; rigs that growth is told from
JUDGED, GLANCED = 32, 4  # rigs whose error is taken, with --quick too
Result = dict[str, Any]


def prepared(name: str, setting: Setting, rigs: int, sampled: bool) -> tuple[Run, float]:
    """A run of the peer of that name on as many cores as it shall use, and the seconds that compiling took."""
    peer = next(peer for peer in BATCH_PEERS if peer.name == name)
    if peer.one_core:
        use_one_core()
    import_module(peer.package.module)
    times = sample_times(peer.duration) if sampled else np.array([0.0, peer.duration])
    runs: list[Run] = []
    seconds = seconds_of(
        lambda: runs.append(peer.prepare(drawn_rigs(rigs), setting, times, 1 if peer.one_core else available_threads()))
    )
    return runs[0], seconds


def timed(name: str, setting: Setting, rigs: int, repeats: int, limit: float) -> Result:
    """Seconds and memory of one batch; fewer repeats where they would take longer than `limit` s in all."""
    run, compile_time = prepared(name, setting, rigs, sampled=False)
    begin = time.perf_counter()
    growth = memory_growth(run)
    repeats = max(1, min(repeats, int(limit / (time.perf_counter() - begin))))
    return {
        "seconds": median_seconds(run, repeats, warm=True),
        "repeats": repeats,
        "compile_s": compile_time,
        "memory_B": growth,
    }


def errors(name: str, setting: Setting, reference: FloatArray) -> list[float]:
    """Largest error of the bit speed of each rig that the reference has, rad/s."""
    run, _ = prepared(name, setting, len(reference), sampled=True)
    found: list[float] = np.asarray(largest_errors(run(), reference)).tolist()
    return found


def reference_of(rig: int) -> FloatArray:
    """The accurate bit speed of one of the drawn rigs, every 0.1 s."""
    rigs = drawn_rigs(rig + 1)
    last = Rigs(rigs.normal_force[rig:], rigs.speed_reference[rig:])
    return np.asarray(last.bit_speeds(sample_times(DURATION), rtol=1e-9)[0])


def references(rigs: int) -> FloatArray:
    """The accurate bit speeds of the first rigs, shape (rigs, samples), from as many processes as there are cores."""
    with Local(available_threads()) as engine:
        return np.stack(engine.map(reference_of, range(rigs)))


def expected_seconds(sizes: Result, size: int) -> float:
    """Time of a batch as it follows from the two sizes before, a + b rigs; the same as before where there is one."""
    times = [(0, 0.0), *((int(rigs), one["seconds"]) for rigs, one in sizes.items())]
    if len(times) < 3:
        return float(times[-1][1])
    (few, short), (many, long) = times[-2:]
    return float(long + max(long - short, 0.0) / (many - few) * (size - many))


def described(peer: BatchPeer, setting: Setting) -> Result:
    """A solver at one setting, before it is measured."""
    return {
        **peer.described(setting),
        "cores": 1 if peer.one_core else available_threads(),
        "duration_s": peer.duration,
        "sizes": {},
    }


def measure(
    result: Result, setting: Setting, reference: FloatArray, sizes: list[int], repeats: int, limit: float
) -> Iterator[Result]:
    """Add to a described solver its error, then size by size its time, ascending; one turn for each that is added.

    It ends with the first size that is not done in time, and says why.
    """
    name, done, timeout = result["solver"], result["sizes"], 4.0 * limit + 60.0  # compilation, a first run, repeats
    try:
        found = in_new_process(errors, name, setting, reference, timeout=timeout)
        result["median_error_rad_s"] = float(np.median(found))
        result["error_90_percent_rad_s"] = float(np.quantile(found, 0.9))
        yield result
        for size in sizes:
            expected = expected_seconds(done, size)
            if expected > limit:
                result["not_run"] = f"{size:,} rigs would take about {expected:.0f} s"
                break
            one = in_new_process(timed, name, setting, size, repeats, limit, timeout=timeout)
            one["seconds_per_rig"] = one["seconds"] / size
            one["simulated_s_per_s"] = size * result["duration_s"] / one["seconds"]
            one["memory_per_rig_B"] = one["memory_B"] / size
            done[str(size)] = one
            note(f"    {size:,} rigs: {one['seconds']:.3g} s")
            yield result
    except (TimeoutError, RuntimeError) as failure:
        result["not_run"] = f"{len(done)} of {len(sizes)} sizes done: {failure}"
    yield result


def rows(result: Result) -> list[list[str]]:
    """The lines of the table for one solver at one setting."""
    name = f"{result['solver']}, {result['setting']}"
    base = result["sizes"].get(str(BASE_SIZE), {}).get("seconds_per_rig")
    lines = [
        [
            name,
            f"{int(rigs):,}",
            f"{one['seconds']:.3g}",
            f"{one['simulated_s_per_s']:,.0f}",
            f"{1e6 * one['seconds_per_rig']:,.1f}",
            f"{one['seconds_per_rig'] / base:.2f}" if base else "-",
            f"{one['memory_per_rig_B']:,.0f}" if int(rigs) >= BASE_SIZE else "-",
            f"{one['compile_s']:.1f}",
        ]
        for rigs, one in result["sizes"].items()
    ]
    return lines + ([[name, "not run", result["not_run"], *["-"] * 5]] if "not_run" in result else [])


def report(results: list[Result]) -> None:
    """Print both tables."""
    headings = ["solver", "rigs", "seconds", "simulated s a second", "us a rig", f"to {BASE_SIZE} rigs"]
    headings += ["B a rig", "compiled in, s"]
    print_table(headings, [line for result in results for line in rows(result)])
    print()
    print_table(
        ["solver", "median error, rad/s", "90 % of rigs below, rad/s"],
        [
            [f"{r['solver']}, {r['setting']}", f"{r['median_error_rad_s']:.1e}", f"{r['error_90_percent_rad_s']:.1e}"]
            for r in results
            if "median_error_rad_s" in r
        ],
    )


@command
def main() -> None:
    """Measure all solvers over all sizes and print the tables."""
    parser = Parser(prog="python -m benchmarks.batches", description=__doc__)
    parser.add_argument(
        "--repeats", type=of_kind(COUNT), default=5, help="timings of which the median counts (default: 5)"
    )
    parser.add_argument("--quick", action="store_true", help="a first look: up to 256 rigs, 2 repeats, a minute or two")
    parser.add_argument(
        "--limit", type=of_kind(POSITIVE, "s"), default=60.0, help="longest run of a batch, s (default: 60)"
    )
    parser.add_argument(
        "--sizes", type=of_kind(COUNT), nargs="+", default=list(SIZES), help="numbers of rigs (default: %(default)s)"
    )
    parser.add_argument("--only", action="append", default=[], metavar="NAME", help="only solvers with NAME in theirs")
    parser.add_argument(
        "--json", type=Path, default=Path("results/benchmarks/batches.json"), help="where to write the figures"
    )
    arguments = parser.parse_args()
    sizes = sorted(size for size in arguments.sizes if not arguments.quick or size <= BASE_SIZE)
    repeats, limit = (2, 10.0) if arguments.quick else (arguments.repeats, arguments.limit)
    try:
        wanted = asked_for(BATCH_PEERS, arguments.only)
    except ValueError as error:
        parser.error(error)
    missing = left_out(BATCH_PEERS)
    for hint in missing:
        note(hint)
    runs = [
        (peer, setting)
        for peer in wanted
        for setting in (peer.settings[len(peer.settings) // 2 :][:1] if arguments.quick else peer.settings)
    ]
    note("the accurate solution")
    reference = references(GLANCED if arguments.quick else JUDGED)
    results: list[Result] = []
    outcome: Result = {
        "case": {
            "normal_force_N": NORMAL_FORCES,
            "speed_reference_rad_s": SPEED_REFERENCES,
            "duration_s": DURATION,
            "rigs_judged": len(reference),
        },
        "quick": arguments.quick,
        "limit_s": limit,
        "cores": available_threads(),
        "left_out": missing,
        "batches": results,
    }

    def tell() -> None:
        report(results)
        write_json(arguments.json, outcome)

    with kept(arguments.json, tell):
        for number, (peer, setting) in enumerate(runs, 1):
            note(f"[{number}/{len(runs)}] {peer.name}, {setting.label}")
            results.append(described(peer, setting))
            for _ in measure(results[-1], setting, reference, sizes, repeats, limit):
                write_json(arguments.json, outcome, announce=False)


if __name__ == "__main__":
    raise SystemExit(main())
