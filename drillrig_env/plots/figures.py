"""The figures of the chapter from the project's own code, with captions; beyond it the bistable region and other laws.

>>> from drillrig_env.plots.figures import draw
>>> draw("4.10").caption[:12]
'Figure 4.10.'
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path

from drillrig_env.files import write_text
from drillrig_env.parameters import closest
from drillrig_env.plots.bifurcations import bistable_region, diagram_at_a_larger_force, diagram_with_orbits
from drillrig_env.plots.friction_curves import friction_laws, stability_on_the_friction_curve
from drillrig_env.plots.local_stability import eigenvalue_crossing, equilibrium_branches, torsional_vibration_map
from drillrig_env.plots.other_laws import laws_and_borders
from drillrig_env.plots.own_rig import differences
from drillrig_env.plots.style import Picture, add_caption, look, save
from drillrig_env.plots.time_responses import (
    load_put_on_and_removed,
    motor_oscillations,
    speed_and_current,
    start_from_rest,
    stick_slip,
)
from drillrig_env.rig import Rig, RigLike

__all__ = ["FIGURES", "FORMATS", "Picture", "draw", "write"]

FIGURES: Mapping[str, Callable[[Rig], Picture]] = {
    "4.1": friction_laws,
    "4.2": partial(start_from_rest, 3.14),
    "4.3": partial(start_from_rest, 4.19),
    "4.4": stick_slip,
    "4.5": motor_oscillations,
    "4.6": load_put_on_and_removed,
    "4.7": speed_and_current,
    "4.8": stability_on_the_friction_curve,
    "4.9": equilibrium_branches,
    "4.10": eigenvalue_crossing,
    "4.11": torsional_vibration_map,
    "4.12": diagram_with_orbits,
    "4.13": diagram_at_a_larger_force,
    "bistable": bistable_region,
    "laws": laws_and_borders,
}
"""What draws each figure, by the chapter's number."""

FORMATS = ("png", "svg")
"""Kinds of files that a figure may be written as."""
_CAPTIONS = "captions.md"


def draw(name: str, rig: RigLike = None) -> Picture:
    """Draw a figure with its caption below it, for the chapter's rig or one of your own (as `Rig.of` takes it).

    On another rig, axes of speeds reach as far beside its fold as they do beside the chapter's; times, normal forces
    and friction are those that correspond to the chapter's (see `drillrig_env.scales`); and the caption says in what
    the rig differs. Raises `ValueError` for a name that is not in FIGURES, and for a rig without what the figure shows.
    """
    if name not in FIGURES:
        raise ValueError(f"figure {name!r} is not known; {closest(name, FIGURES)}")
    rig = Rig.of(rig)
    with look():
        drawn = FIGURES[name](rig)
        lead = "" if name in ("bistable", "laws") else f"Figure {name}. "
        if changed := differences(rig):
            lead += f"For a rig with {changed}: "
        picture = Picture(drawn.figure, lead + drawn.caption)
        add_caption(picture)
    return picture


def write(
    folder: str | Path,
    names: Iterable[str] = tuple(FIGURES),
    formats: Iterable[str] = FORMATS,
    rig: RigLike = None,
) -> Iterator[str]:
    """Draw figures and write each into a folder, with captions.md; yields each name once its files are there.

    `names` are those of FIGURES, `formats` those of FORMATS, and `folder` is made.

    `rig` as for `draw`. Captions of figures written there before stay. Raises `ValueError` as `draw` does, and for an
    unknown format.
    """
    folder, formats = Path(folder), tuple(formats)
    for suffix in formats:
        if suffix not in FORMATS:
            raise ValueError(f"format {suffix!r} is not known; {closest(suffix, FORMATS)}")
    folder.mkdir(parents=True, exist_ok=True)
    captions = _read_captions(folder / _CAPTIONS)
    for name in names:
        picture = draw(name, rig)
        with look():
            save(picture, folder, name, formats)
        captions[name] = f"![{name}]({name}.{formats[0]})\n\n{picture.caption}"
        sections = [f"## {known}\n\n{captions[known]}\n" for known in FIGURES if known in captions]
        write_text(folder / _CAPTIONS, "\n".join(["# Figures\n", *sections]))
        yield name


def _read_captions(path: Path) -> dict[str, str]:
    """The sections of a captions.md, by figure; empty where there is none."""
    if not path.exists():
        return {}
    _, *parts = re.split(r"^## (.+)\n", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return {name: text.strip() for name, text in zip(parts[::2], parts[1::2], strict=True)}
