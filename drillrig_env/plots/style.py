"""How the figures look in print, and how a picture with its caption becomes a file.

A figure is 6.5 inches wide with 8 pt text and up. Colours are those of Okabe and Ito, which stay apart
for the colour-blind; wherever a colour tells two things apart, a line style does too. Stable is
solid, unstable dashed, as in the chapter.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.extras import missing
from drillrig_env.files import written_whole

try:
    from matplotlib import rc_context
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
except ImportError as error:
    raise missing("a figure", "Matplotlib", "plot") from error

BLUE, VERMILLION, GREEN, PURPLE, DARK, GREY = "#0072B2", "#D55E00", "#009E73", "#AA4499", "0.1", "0.45"
STABLE: dict[str, Any] = {"color": BLUE, "ls": "-", "lw": 1.6}
UNSTABLE: dict[str, Any] = {"color": VERMILLION, "ls": (0, (4, 2)), "lw": 1.6}

SPEED_REFERENCE = r"speed reference $\omega_{ref}$, rad/s"
BIT_SPEED = r"bit speed $\dot{\theta}_1$, rad/s"
TWIST = r"twist $\delta_{12}$, rad"
TIME = "time, s"

WIDTH = 6.5  # inches
_TEXT = 8.0  # pt
_LINE = 1.35 * _TEXT / 72.0  # inches from one caption line to the next
_NO_BREAK = "\N{NO-BREAK SPACE}"  # keeps a number and its unit on one line
_CAPTION_COLUMNS = 106  # characters; a line of them fits into WIDTH
_LOOK: Any = {
    "font.size": _TEXT,
    "axes.titlesize": _TEXT + 1.0,
    "axes.titlelocation": "left",
    "axes.labelsize": _TEXT,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.alpha": 0.25,
    "grid.linewidth": 0.6,
    "legend.fontsize": _TEXT,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "lines.markersize": 5.0,
    "hatch.linewidth": 0.5,
    "svg.hashsalt": "drillrig",  # without it, each run would draw other ids into the same picture
}


@dataclass(frozen=True, eq=False)
class Picture:
    """A drawn figure and its caption, which names the parameters used."""

    figure: Figure
    caption: str


def look() -> Any:
    """The context in which figures are drawn and saved; the user's own Matplotlib settings stay as they are."""
    return rc_context(_LOOK)


def new_figure(height: float) -> Figure:
    """An empty figure of the page's width and a height in inches, caption aside."""
    return Figure(figsize=(WIDTH, height), layout="constrained")


def add_caption(picture: Picture) -> None:
    """Write the caption below the picture, which grows by the lines that it takes."""
    bound = re.sub(r" (?=[=<>] )|(?<= [=<>]) |(?<=\d) (?=(?:rad|N|s|A|m|rpm)\b)", _NO_BREAK, picture.caption)
    lines = textwrap.wrap(bound, _CAPTION_COLUMNS, break_on_hyphens=False)
    below = _LINE * (len(lines) + 0.6)
    height = picture.figure.get_size_inches()[1] + below
    picture.figure.set_size_inches(WIDTH, height)
    picture.figure.set_layout_engine("constrained", rect=(0.0, below / height, 1.0, 1.0 - below / height))
    text = "\n".join(lines).replace(_NO_BREAK, " ")
    picture.figure.text(0.015, (below - 0.3 * _LINE) / height, text, va="top", fontsize=_TEXT, linespacing=1.25)
    _freeze_layout(picture.figure)


def _freeze_layout(figure: Figure) -> None:
    """Lay the figure out once for every format; rounded, since the solver's last digit varies from run to run."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in figure.axes:
        left, bottom, width, height = (round(float(value), 4) for value in axes.get_position().bounds)
        axes.set_position((left, bottom, width, height))


def save(picture: Picture, folder: Path, name: str, formats: Iterable[str]) -> list[Path]:
    """Write a picture as NAME.FORMAT into a folder; the same picture gives the same bytes each time."""
    paths = [folder / f"{name}.{suffix}" for suffix in formats]
    for path in paths:
        metadata = {"Date": None} if path.suffix == ".svg" else None
        with written_whole(path) as new:
            picture.figure.savefig(new, dpi=200, metadata=metadata)
    return paths


def plot_stability(axes: Axes, x: FloatArray, y: FloatArray, stable: npt.NDArray[np.bool_]) -> None:
    """A branch, solid where it is stable and dashed where it is not; the pieces meet."""
    borders = np.flatnonzero(stable[1:] != stable[:-1]) + 1
    for begin, end in pairwise([0, *borders.tolist(), len(x)]):
        axes.plot(x[begin : end + 1], y[begin : end + 1], **(STABLE if stable[begin] else UNSTABLE))


def name_line_styles(axes: Axes, where: Literal["upper left", "lower left", "lower right"]) -> None:
    """The legend of stable and unstable."""
    axes.plot([], [], label="stable", **STABLE)
    axes.plot([], [], label="unstable", **UNSTABLE)
    axes.legend(loc=where)


def mark(axes: Axes, x: float, y: float, text: str, offset: tuple[float, float], **arguments: Any) -> None:
    """A dot at a special point, and its name at an offset in pt."""
    axes.plot(x, y, "o", color=DARK, ms=4.0, zorder=5)
    axes.annotate(text, (x, y), offset, textcoords="offset points", **arguments)
