"""Many rigs: how time and memory grow with their number."""

from __future__ import annotations

from typing import Any

from benchmarks.parts.named_lines import Line, count_axis, draw_lines, name_lines, styled
from benchmarks.parts.part import OWN, Part, Results, digits, power, times
from benchmarks.parts.solvers import LIMITS
from drillrig_env import markdown
from drillrig_env.plots.style import Picture, new_figure

BATCH = 4096  # rigs for which solvers are compared
SMALL, LARGE = 256, 65_536  # rigs between which growth of time is told


def result(results: Results) -> list[tuple[str, str]]:
    """By how much the project is faster than the fastest peer of like error, and how its time grows."""
    lines = []
    for limit in LIMITS:
        good = [
            one
            for one in results["batches"]
            if one.get("median_error_rad_s", 1.0) <= limit
            and str(BATCH) in one["sizes"]
            and "one core" not in one["solver"]
        ]
        own = [one for one in good if one["library"] == OWN and one["rtol"] <= 1.001 * limit]
        peers = [one for one in good if one["library"] != OWN]
        if own and peers:
            peer = max(peers, key=_speed)
            ratio = times(_speed(max(own, key=_speed)) / _speed(peer))
            what = f"{BATCH:,} rigs, against the fastest peer, median error ≤ {power(limit)} rad/s"
            lines.append((what, f"**{ratio} times** as fast as {batch_name(peer)}"))
    for one in results["batches"]:
        few, many = (one["sizes"].get(str(size)) for size in (SMALL, LARGE))
        if one["library"] == OWN and one["rtol"] == LIMITS[-1] and few and many:
            growth = many["seconds_per_rig"] / few["seconds_per_rig"]
            what = f"time of one of {LARGE:,} rigs, {batch_name(one)}"
            lines.append((what, f"**{growth:.2f} times** that of one of {SMALL}"))
    return lines


def _speed(one: Results) -> float:
    """Simulated seconds a second."""
    return float(one["sizes"][str(BATCH)]["simulated_s_per_s"])


def tables(results: Results) -> list[str]:
    """Time of a rig's simulated second, memory, error and compile time, a row a solver and setting."""
    found = results["batches"]
    sizes = sorted({int(rigs) for one in found for rigs in one["sizes"]})
    rows = []
    for one in found:
        done = {int(rigs): figures for rigs, figures in one["sizes"].items()}
        cells = [digits(1e6 / one["duration_s"] * done[n]["seconds_per_rig"]) if n in done else "-" for n in sizes]
        largest = max(done, default=0)
        memory = f"{done[largest]['memory_per_rig_B']:,.0f}" if largest >= SMALL else "-"
        compiled = f"{done[largest]['compile_s']:.1f}" if done else "-"
        error = f"{one['median_error_rad_s']:.1e}" if "median_error_rad_s" in one else "-"
        rows.append([batch_name(one), error, *cells, memory, compiled])
    heads = ["median error, rad/s", *(f"{size:,}" for size in sizes), "B a rig", "compiled in, s"]
    stopped = [f"- {batch_name(one)}: {one['not_run']}." for one in found if "not_run" in one]
    return [
        markdown.table(["solver, tolerance", *heads], rows),
        *(["Sizes that were not run:\n\n" + "\n".join(stopped)] if stopped else []),
    ]


def batch_name(one: Results) -> str:
    """A solver and its setting, short."""
    return f"{one['solver']}, {power(one['rtol'])}".replace(" fast stepper", "")


def plot(results: Results, made: str) -> Picture:
    """Memory of all rigs, and time of a rig's simulated second, over the number of rigs."""
    times_of: dict[str, Any] = {}
    memory_of: dict[str, Any] = {}
    for one in results["batches"]:
        if one["sizes"]:
            sizes = {int(rigs): figures for rigs, figures in one["sizes"].items()}
            scale = 1e6 / one["duration_s"]
            times_of[batch_name(one)] = [*sizes], [scale * figures["seconds_per_rig"] for figures in sizes.values()]
            memory = {rigs: rigs * figures["memory_per_rig_B"] / 2**20 for rigs, figures in sizes.items()}
            memory = {rigs: size for rigs, size in memory.items() if size > 0.0}
            memory_of[batch_name(one)] = [*memory], [*memory.values()]
    lines = styled(times_of)
    figure = new_figure(3.6)
    left, right = figure.subplots(1, 2, width_ratios=(0.75, 1.0))
    known = [(line, *memory_of[line.name]) for line in lines if memory_of[line.name][0]]
    draw_lines(left, [Line(line.name, rigs, size, line.style) for line, rigs, size in known])
    draw_lines(right, lines)
    name_lines(right, lines)
    left.set_ylabel("growth of memory, MiB")
    right.set_ylabel("wall time of one simulated second of one rig, µs")
    for panel in (left, right):
        count_axis(panel, "rigs in the batch")
    caption = (
        "Batches of rigs at random normal force and speed reference, with each solver's tolerance: by how much the "
        "peak of resident memory grows, and wall time by rig and simulated second. Medians; compilation not counted. "
        f"{made}"
    )
    return Picture(figure, caption)


BATCHES = Part(
    "batches",
    "Many rigs",
    """Rigs at random normal forces (5 to 40 N) and speed references (0.5 to 5 rad/s), 10 s each. The columns by number
of rigs hold µs for one simulated second of one rig; memory is the growth of the process at its peak. Compilation is
not in the times.""",
    result,
    tables,
    plot,
    "Memory, and time per rig, over the number of rigs",
)
