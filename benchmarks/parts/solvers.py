"""One rig: error and time of the project and of other solvers."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.parts.named_lines import draw_lines, name_lines, styled
from benchmarks.parts.part import OWN, Part, Results, duration, power, times
from drillrig_env import markdown
from drillrig_env.plots.style import Picture, new_figure

LIMITS = (1e-3, 1e-6)  # rad/s, errors of the bit speed at which solvers are compared


def result(results: Results) -> list[tuple[str, str]]:
    """By how much the project is faster than other solvers on one rig."""
    return [
        (f"one rig, against {who.replace('<=', '≤')} rad/s", f"**{times(one['ratio'])} times** as fast")
        for who, one in results.get("faster_than", {}).items()
    ]


def tables(results: Results) -> list[str]:
    """The fastest setting of each solver below each error, the largest error met, and every setting."""
    blocks = [best_table([one for one in results["solvers"] if "failure" not in one])]
    if "largest_error_of_stored_runs_rad_s" in results:
        blocks.append(
            "Largest error of any speed at the default setting over the 30 stored runs of the tests (2 to 40 N, 0.3 to "
            "9 rad/s, with steps of speed reference and normal force): "
            f"{results['largest_error_of_stored_runs_rad_s']:.1e} rad/s."
        )
    every = every_table(results["solvers"])
    return [*blocks, f"<details><summary>Every solver at every setting</summary>\n\n{every}\n\n</details>"]


def best_table(found: Sequence[Results]) -> str:
    """A row a solver: time, setting, and the project's time as often as it goes into it, below each limit."""
    rows = {one["solver"]: [one["solver"], one["form"]] for one in found}
    for limit in LIMITS:
        best = {name: fastest(found, name, limit) for name in rows}
        own = next((one for name, one in best.items() if one and name.startswith(OWN)), None)
        for name, one in best.items():
            ratio = times(one["seconds_for_50_s"] / own["seconds_for_50_s"]) if one and own else "-"
            rows[name] += [duration(one["seconds_for_50_s"]), one["setting"], ratio] if one else ["-", "-", "-"]
    heads = [head for limit in LIMITS for head in (f"error ≤ {power(limit)}", "setting", f"times {OWN}'s")]
    return markdown.table(["solver", "what it is given", *heads], rows.values(), words=2)


def fastest(found: Sequence[Results], solver: str, limit: float) -> Results | None:
    """The fastest of a solver's settings with an error below a limit (rad/s); the project's must promise it, too."""
    good = [
        one
        for one in found
        if one["solver"] == solver
        and one["error_rad_s"] <= limit
        and (one["library"] != OWN or one["rtol"] <= 1.001 * limit)
    ]
    return min(good, key=lambda one: float(one["seconds_for_50_s"]), default=None)


def every_table(found: Sequence[Results]) -> str:
    """A row a solver and setting; a failure in words."""
    rows = []
    for one in found:
        cells = [one.get("failure", ""), "-", "-", "-"]
        if "failure" not in one:
            cells = [f"{one['error_rad_s']:.1e}", duration(one["seconds_for_50_s"])]
            cells += [f"{one['simulated_s_per_s']:,.0f}", f"{one['compile_s']:.1f}"]
        rows.append([one["solver"], one["version"], one["setting"], *cells])
    heads = ["error, rad/s", "time for 50 s", "simulated s a second", "compiled in, s"]
    return markdown.table(["solver", "version", "setting", *heads], rows, words=3)


def plot(results: Results, made: str) -> Picture:
    """Seconds for 50 s of motion over the error, a line a solver, the most accurate on the right."""
    points: dict[str, list[tuple[float, float]]] = {}
    for one in results["solvers"]:
        if one.get("error_rad_s", 0.0) > 0.0:
            points.setdefault(one["solver"], []).append((one["error_rad_s"], one["seconds_for_50_s"]))
    lines = styled({name: tuple(zip(*sorted(pairs, reverse=True), strict=True)) for name, pairs in points.items()})
    figure = new_figure(4.4)
    panel = figure.subplots()
    draw_lines(panel, lines)
    panel.invert_xaxis()
    name_lines(panel, lines)
    panel.set_xlabel("largest error of the bit speed over 20 s, rad/s; more accurate to the right")
    panel.set_ylabel("wall time for 50 s of motion, s")
    case = results["case"]
    caption = (
        f"One rig in stick-slip ({case['normal_force_N']:g} N, {case['speed_reference_rad_s']:g} rad/s), 50 s sampled "
        "every 0.1 s on one core: wall time over the largest error of the bit speed against Radau with the kinks split "
        f"by events; a point a tolerance, medians, compilation not counted. Lower right is better. {made}"
    )
    return Picture(figure, caption)


SOLVERS = Part(
    "solvers",
    "One rig",
    """50 s of stick-slip (20 N, 2 rad/s), sampled every 0.1 s, on one core. The error is the largest of the bit speed
over the first 20 s against Radau with the kinks split by events. Compilation is not in the times. The table has each
solver's fastest setting below an error, and how many times DrillRig's time it takes.""",
    result,
    tables,
    plot,
    "Wall time over error for every solver",
)
