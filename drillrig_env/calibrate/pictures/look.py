"""What records can tell before any fit."""

from __future__ import annotations

from pathlib import Path

from drillrig_env.calibrate.calibration import BY_RECORDS, NOT_BY_RECORDS
from drillrig_env.calibrate.look import Look
from drillrig_env.calibrate.unknowns import WIDE
from drillrig_env.files import check_writable_file
from drillrig_env.plots.style import BLUE, DARK, GREY, Picture, add_caption, look, new_figure, save


def check_place(path: Path, overwrite: bool) -> None:
    """Raise `ValueError` for a path that is no picture's, and `OSError` where none can be written there."""
    if path.suffix not in (".png", ".svg"):
        raise ValueError(f"--output {path} is not allowed: with --look it is a picture; allowed: a name.png or .svg")
    if path.exists() and not overwrite:
        raise FileExistsError(f"{path} is there already; choose another --output, or give --overwrite")
    check_writable_file(path)


def write_look(path: Path, found: Look) -> None:
    """Write the picture with its caption."""
    with look():
        picture = draw_look(found)
        add_caption(picture)
        save(picture, path.parent, path.stem, [path.suffix[1:]])


def draw_look(found: Look) -> Picture:
    """The relative standard deviation of each parameter, beside what it has where nothing is known."""
    told = found.told
    sizes = 100.0 * found.deviations
    colours = [BLUE if name in told else GREY for name in found.names]
    with look():
        figure = new_figure(0.9 + 0.19 * len(found.names))
        axes = figure.subplots()
        places = range(len(found.names))[::-1]
        axes.barh(places, sizes, color=colours, height=0.6)
        axes.axvline(100.0 * WIDE, color=DARK, lw=1.0, ls="--", label="nothing is known")
        for colour, words in ((BLUE, BY_RECORDS), (GREY, NOT_BY_RECORDS)):
            axes.plot([], [], "s", color=colour, label=words)
        axes.set_xscale("log")
        axes.set_xlim(min(0.1, 0.5 * float(sizes.min())), 200.0 * WIDE)
        axes.xaxis.set_major_formatter("{x:g}")
        axes.set_yticks(places, found.names)
        axes.set_ylim(-0.6, len(found.names) - 0.4)
        axes.set_xlabel("relative standard deviation, %")
        figure.legend(loc="outside upper right", ncols=3)
    return Picture(figure, f"What the records can tell before any fit. {'. '.join(found.advice())}.")
