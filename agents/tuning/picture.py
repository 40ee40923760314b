"""A study as a picture: what tries were worth one after another, and over each hyperparameter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import FormatStrFormatter, LogLocator, MaxNLocator, NullFormatter

from agents.tuning.space import Dimension
from agents.tuning.tries import worth
from drillrig_env.plots.style import BLUE, DARK, VERMILLION, Picture, add_caption, look, new_figure, save

if TYPE_CHECKING:
    from agents.tuning.study import Study

_COLUMNS = 3  # panels side by side
_ROW = 1.9  # inches


def draw_study(study: Study, folder: Path) -> None:
    """Write study.png into a folder."""
    with look():
        picture = plot_study(study)
        add_caption(picture)
        save(picture, folder, "study", ("png",))


def plot_study(study: Study) -> Picture:
    """The study as a picture: tries that went to their end are filled, the best one is red."""
    dimensions, tries = study.question.space.dimensions, study.done
    worths = [worth(one) for one in tries]
    full = np.array([study.is_full(one) for one in tries])
    best = tries.index(study.best_first()[0])
    rows = 1 + -(-len(dimensions) // _COLUMNS)
    figure = new_figure(_ROW * rows)
    grid = figure.add_gridspec(rows, _COLUMNS)
    over_time = figure.add_subplot(grid[0, :])
    _dots(over_time, np.arange(len(tries)), worths, full, best)
    reached = np.maximum.accumulate(np.where(full, worths, -np.inf))
    over_time.step(np.arange(len(tries)), np.where(np.isfinite(reached), reached, np.nan), where="post", color=DARK)
    over_time.xaxis.set_major_locator(MaxNLocator(integer=True))
    over_time.set_xlabel("tries, as they were begun")
    over_time.set_ylabel(study.question.objective)
    for number, one in enumerate(dimensions):
        panel = figure.add_subplot(grid[1 + number // _COLUMNS, number % _COLUMNS])
        _dots(panel, _places(panel, one, [trial.params[one.name] for trial in tries]), worths, full, best)
        panel.set_xlabel(one.name)
    ended = len(tries) - int(full.sum())
    caption = (
        f"{len(tries)} tries of {study.spent:,} steps in all, {ended} of them ended early (open circles); the line is "
        f"the best so far, red the best. {study.question.objective} on {study.question.rigs} rigs for validation of "
        f"the suite {study.question.suite}, without exploration; higher is better."
    )
    return Picture(figure, caption)


def _dots(panel: Any, places: Any, worths: Any, full: Any, best: int) -> None:
    worths, places = np.asarray(worths), np.asarray(places)
    panel.plot(places[full], worths[full], "o", color=BLUE)
    panel.plot(places[~full], worths[~full], "o", color=BLUE, markerfacecolor="none")
    panel.plot(places[best], worths[best], "o", color=VERMILLION)


def _places(panel: Any, one: Dimension, drawn: list[Any]) -> Any:
    """Where what was drawn lies on an axis: choices side by side."""
    if one.choices:
        panel.set_xticks(range(len(one.choices)), [str(choice) for choice in one.choices])
        return [one.choices.index(value) for value in drawn]
    if one.log:
        panel.set_xscale("log")
        panel.set_xlim(0.9 * one.low, 1.1 * one.high)
        panel.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        panel.xaxis.set_major_formatter(FormatStrFormatter("%g"))
        panel.xaxis.set_minor_formatter(NullFormatter())
    elif all(isinstance(value, int) for value in drawn):
        panel.xaxis.set_major_locator(MaxNLocator(integer=True))
    return drawn
