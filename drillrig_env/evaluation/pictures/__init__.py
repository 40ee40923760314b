"""Pictures of a comparison, all of them from saved results: nothing is run to draw them.

| file | shows |
|---|---|
| `scores_SUITE.png` | every policy's scores with intervals |
| `calming_SUITE.png` | how many rigs are calm by when |
| `map_SUITE.png` | who mitigates what over target and normal force |
| `histories_SUITE_REGION.png` | one rig of a region over time under a few policies |
"""

from __future__ import annotations

from collections.abc import Callable, Container
from functools import partial
from pathlib import Path

from drillrig_env.evaluation.histories import REGIONS, Histories
from drillrig_env.evaluation.pictures.calming import plot_calming
from drillrig_env.evaluation.pictures.over_time import plot_histories
from drillrig_env.evaluation.pictures.score_dots import plot_scores
from drillrig_env.evaluation.pictures.who_mitigates import plot_map
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.store import picture_name
from drillrig_env.plots.style import Picture, add_caption, look, save

__all__ = ["draw", "draw_all", "plot_calming", "plot_histories", "plot_map", "plot_scores"]

PICTURES: dict[str, Callable[[Results, str], Picture]] = {
    "scores": plot_scores,
    "calming": plot_calming,
    "map": plot_map,
}
"""What draws each picture of a suite from scores alone, by name."""


def draw_all(
    results: Results, histories: Histories, folder: Path, only: Container[str] | None = None, prefix: str = ""
) -> list[Path]:
    """Draw all pictures of all suites, or `only` those of some names, as PREFIX + NAME.png in a folder; their paths."""
    plots: dict[str, Callable[[], Picture]] = {}
    for suite in results.scores:
        plots |= {picture_name(name, suite): partial(plot, results, suite) for name, plot in PICTURES.items()}
        for region in REGIONS:
            if histories.of(suite, region):
                name = picture_name(f"histories_{region}", suite)
                plots[name] = partial(plot_histories, results, histories, suite, region)
    paths = []
    for name, plot in plots.items():
        if only is None or name in only:
            paths += draw(plot, folder, f"{prefix}{name}")
    return paths


def draw(plot: Callable[[], Picture], folder: Path, name: str) -> list[Path]:
    """Draw one picture with its caption below it, in the figures' look, as NAME.png in a folder, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    with look():
        picture = plot()
        add_caption(picture)
        return save(picture, folder, name, ("png",))
