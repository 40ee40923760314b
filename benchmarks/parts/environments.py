"""Environments: steps a second, one copy and many."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.parts.named_lines import Line, count_axis, draw_lines, name_lines, styled
from benchmarks.parts.part import CARTPOLE, RIG, Part, Results, amount, duration, times
from drillrig_env import markdown
from drillrig_env.plots.style import Picture, new_figure

BATCH = 4096  # copies for which the speed is quoted
WAYS = {"fixed": "fixed action", "random": "random actions, drawn within the time"}
SMALL, LARGE = 256, 65_536  # copies between which the time of one step is compared


def result(results: Results) -> list[tuple[str, str]]:
    """One copy beside CartPole, many copies, growth and memory."""
    lines = []
    for way, words in WAYS.items():
        one, other = _rate(results, 1, RIG, way), _rate(results, 1, CARTPOLE, way)
        if one and other:
            lines.append((f"one environment, {words}", f"**{times(one / other)} times** the steps/s of {CARTPOLE}"))
    if many := _rate(results, BATCH, RIG):
        what = f"{BATCH:,} environments on {results['cores']} cores, rewards, info and resets included"
        lines.append((what, f"**{amount(many)} steps/s**"))
    if (few := _rate(results, SMALL, RIG)) and (most := _rate(results, LARGE, RIG)):
        what = f"time of one step of one of {LARGE:,} environments"
        lines.append((what, f"**{few / most:.2f} times** that of one of {SMALL}"))
    if "memory" in results:
        own = results["memory"]["bytes_per_rig"]
        lines.append(("memory of one rig in the vector environment", f"**{own:,.0f} bytes**"))
    return lines


def tables(results: Results) -> list[str]:
    """Steps a second by environment and number of copies, a table a way to act, and what drawing actions takes."""
    sizes = [int(size) for size in results["rates"]]
    blocks = []
    for way, words in WAYS.items():
        rates = {name: [_rate(results, size, name, way) for size in sizes] for name in results["environments"]}
        rows = [[name, *map(amount, found)] for name, found in rates.items() if any(found)]
        blocks += [f"Steps a second, {words}, by number of copies:"]
        blocks += [markdown.table(["environment", *(f"{size:,}" for size in sizes)], rows)]
    rows = [[name, _draw(results, name), about] for name, about in results["environments"].items()]
    heads = ["environment", "drawing one action", "what a step is, and the fixed action"]
    return [*blocks, markdown.table(heads, rows, words=len(heads))]


def _draw(results: Results, name: str) -> str:
    one = results["rates"].get("1", {}).get(name, {})
    return duration(one["seconds_per_draw"]) if "seconds_per_draw" in one else "-"


def _rate(results: Results, size: int, name: str, way: str = "fixed") -> float | None:
    return results["rates"].get(str(size), {}).get(name, {}).get(f"steps_per_second_{way}")  # type: ignore[no-any-return]


def plot(results: Results, made: str) -> Picture:
    """Steps a second over the number of copies, under a fixed action and under random ones."""
    points: dict[str, dict[str, tuple[Sequence[float], Sequence[float]]]] = {}
    for way in WAYS:
        for name in results["environments"]:
            rates = {int(size): found.get(name, {}) for size, found in results["rates"].items()}
            known = {size: one[key] for size, one in rates.items() if (key := f"steps_per_second_{way}") in one}
            if known:
                points.setdefault(way, {})[name] = tuple(known), tuple(known.values())
    looks = {line.name: line.style for line in styled(points.get("fixed", {}))}
    figure = new_figure(3.6)
    panels = figure.subplots(1, len(WAYS), sharex=True, sharey=True)
    for panel, way in zip(panels, WAYS, strict=True):
        lines = [Line(name, x, y, looks[name]) for name, (x, y) in points.get(way, {}).items()]
        draw_lines(panel, lines)
        panel.set_title(WAYS[way])
        count_axis(panel, "copies side by side")
    name_lines(panels[-1], lines)
    panels[0].set_ylabel("environment steps a second")
    caption = (
        "Steps a second of one copy (gym.make) and of many in a vector environment, with wrappers, rewards, info and "
        "resets. Fixed action: whole episodes; the rig's holds the speed reference, so that most rigs stick and slip, "
        f"the dearest they can do. Random actions: Gymnasium's own benchmark, which draws them within the time. {made}"
    )
    return Picture(figure, caption)


ENVIRONMENTS = Part(
    "environments",
    "Environments",
    """Environment steps a second, wrappers, rewards, observations, info and resets included: `gym.make` for one copy, a
vector environment for more. The fixed action plays whole episodes; random actions are Gymnasium's own benchmark, whose
time includes the drawing of actions. For the rig these are different physics as well: a held reference leaves most
rigs in stick-slip, the dearest they can do, and random actions shake them about.""",
    result,
    tables,
    plot,
    "Environment steps a second over the number of copies",
)
