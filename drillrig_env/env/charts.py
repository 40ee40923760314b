"""The charts beside the drawn rig: its speeds over the last seconds, and where it stands on its stability map.

What seldom changes (grids, names, regions) is painted on a background by the functions `paint_...`;
the curves of the moment are drawn over it by the functions `draw_...`. Places and lengths are px of
the canvas on which `drillrig_env.env.rendering` draws, twice as wide and high as a frame.
"""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import floor, log10
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.extras import missing
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.stability import critical_speed, end_of_stick_slip

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    import pygame
except ImportError as error:
    raise missing("rendering", "pygame-ce", "render") from error

HISTORY = 20.0
"""How far back the strip charts reach on the chapter's rig, s."""

INK, MUTED, PAPER = "#1a1a1a", "#59636e", "#ffffff"
BIT, TOP, REFERENCE = "#1f5fa8", "#5aa84f", "#d1651f"
MINUS = "\N{MINUS SIGN}"

_GRID = "#e1e5ea"
_STICK_SLIP, _EITHER, _CALM = "#f2c9ac", "#f6ebdd", "#dce8f4"
_FONTS = "dejavusans,liberationsans,arial,helvetica"
_CHART, _MAP = pygame.Rect(850, 120, 1010, 390), pygame.Rect(850, 660, 1010, 320)
_FORCES, _STRIDE = 60, 6  # of the map: how many, and of how many one whose fold is followed where that is slow

Point = tuple[float, float]


@dataclass(frozen=True)
class Axes:
    """A rectangle of the canvas with a scale on either axis."""

    box: pygame.Rect
    x: tuple[float, float]
    y: tuple[float, float]

    def places(self, x: npt.ArrayLike, y: npt.ArrayLike) -> list[Point]:
        """Where the points (x, y) lie on the canvas; what is beyond the axes lies on their edge."""
        right = (np.clip(x, *self.x) - self.x[0]) / (self.x[1] - self.x[0])
        up = (np.clip(y, *self.y) - self.y[0]) / (self.y[1] - self.y[0])
        points = np.broadcast_arrays(self.box.left + right * self.box.width, self.box.bottom - up * self.box.height)
        return [(across, down) for across, down in np.stack(points, axis=-1).reshape(-1, 2).tolist()]


@dataclass(frozen=True)
class Fonts:
    """The two sizes in which a picture is lettered."""

    large: pygame.font.Font
    small: pygame.font.Font

    @classmethod
    def load(cls) -> Fonts:
        """The first of a few plain fonts that the system has, or else pygame's own."""
        pygame.font.init()
        with warnings.catch_warnings():  # on a system that cannot list its fonts pygame's own will do
            warnings.simplefilter("ignore")
            path = pygame.font.match_font(_FONTS)
        return cls(pygame.font.Font(path, 36), pygame.font.Font(path, 31))


def speed_axes(history: float, highest: float) -> Axes:
    """The axes of the strip charts: time before now, up to `history` (s), and speeds up to `highest` (rad/s)."""
    return Axes(_CHART, (-history, 0.0), (-0.04 * highest, highest))


def map_axes(fastest: float, most: float) -> Axes:
    """The axes of the stability map: speed references up to `fastest` (rad/s), normal forces up to `most` (N)."""
    return Axes(_MAP, (0.0, fastest), (0.0, most))


def paint_speeds(ground: pygame.Surface, fonts: Fonts, axes: Axes) -> None:
    """The background of the strip charts."""
    times = {-before: f"{MINUS}{before:g} s" if before else "now" for before in _steps(-axes.x[0])}
    _paint_scales(ground, fonts, axes, times)
    lines = (("bit", BIT, False), ("top drive", TOP, False), ("reference", REFERENCE, False), ("target", INK, True))
    _paint_title(ground, fonts, axes.box, "speed, rad/s", lines)


def draw_speeds(canvas: pygame.Surface, axes: Axes, times: FloatArray, speeds: FloatArray, target: float) -> None:
    """Speeds of bit, top drive and reference, shape (steps, 3), at `times` (s) before now; and the target (rad/s)."""
    for color, speed, width in zip((BIT, TOP, REFERENCE), speeds.T, (5, 6, 4), strict=True):
        _line(canvas, color, axes.places(times, speed), width)
    _line(canvas, INK, axes.places(axes.x, target), 4, dashed=True)


def paint_map(
    ground: pygame.Surface, fonts: Fonts, axes: Axes, rig: Rig, mu_s: float, mu_k: float, v_b: float, law: Any
) -> None:
    """Below the critical speed stick-slip, beyond the fold calm rotation, and between them either."""
    box = axes.box
    forces, critical, fold = _boundaries(rig, mu_s, mu_k, v_b, law, axes.y[1])
    pygame.draw.rect(ground, _CALM, box)
    for color, speeds in ((_EITHER, fold), (_STICK_SLIP, critical)):
        pygame.draw.polygon(ground, color, [box.bottomleft, *axes.places(speeds, forces), box.topleft])
    _paint_scales(ground, fonts, axes, {speed: f"{speed:g}" for speed in _steps(axes.x[1])})
    for dashed, speeds in ((False, critical), (True, fold)):
        inside = (speeds > 0.0) & (speeds < axes.x[1])
        _line(ground, INK, axes.places(speeds[inside], forces[inside]), 6, dashed)
    edges = (np.zeros_like(forces), critical, fold, np.full_like(forces, axes.x[1]))
    for (left, right), name, share in zip(
        pairwise(edges), ("stick-slip", "either", "calm"), (0.9, 0.9, 0.2), strict=True
    ):
        row = round(share * len(forces)) - 1
        (start, y), (end, _) = axes.places((left[row], right[row]), forces[row])
        if end - start > fonts.small.size(name)[0] + 20:
            write(ground, fonts.small, name, ((start + end) / 2, y), "center", INK)
    _paint_title(ground, fonts, box, "normal force, N", (("critical speed", INK, False), ("fold", INK, True)))
    write(ground, fonts.large, "speed reference, rad/s", (box.right, box.bottom + 48), "topright", INK)


def draw_path(canvas: pygame.Surface, axes: Axes, references: FloatArray, forces: FloatArray) -> None:
    """The way over the map to where the rig stands now: speed references (rad/s) and normal forces (N)."""
    path = axes.places(references, forces)
    _line(canvas, REFERENCE, path, 5)
    pygame.draw.circle(canvas, PAPER, path[-1], 17)
    pygame.draw.circle(canvas, REFERENCE, path[-1], 13)


def write(surface: pygame.Surface, font: pygame.font.Font, text: str, at: Point, anchor: str, color: str) -> int:
    """Write with the corner or side `anchor` of the text at a place; returns where the text ends."""
    image = font.render(text, True, color)
    place = image.get_rect(**{anchor: (round(at[0]), round(at[1]))})
    surface.blit(image, place)
    return place.right


@lru_cache(maxsize=32)
def _boundaries(
    rig: Rig, mu_s: float, mu_k: float, v_b: float, law: Any, most: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Normal forces up to `most` (N), and for each the critical speed and the fold (rad/s), infinite off the map."""
    forces = np.linspace(most / _FORCES, most, _FORCES)
    frictions = [Friction(force, mu_s, mu_k, v_b, law=law) for force in forces.tolist()]
    critical = np.array([_critical(rig, friction) for friction in frictions])
    fold = _folds(rig, frictions)
    return forces, critical, np.fmax(critical, fold)  # where there is no bistable region, the fold is NaN


def _critical(rig: Rig, friction: Friction) -> float:
    try:
        return float(critical_speed(rig, friction))
    except ValueError:  # a drive that shakes by itself, but in windows of speed
        return np.inf


def _folds(rig: Rig, frictions: list[Friction]) -> FloatArray:
    """The fold (rad/s) for each of some frictions that go from light to heavy load.

    It is a look into a table where stick-slip ends in grazing, and takes up to a second a load where the branch has to
    be followed to its end: there every `_STRIDE`th is, and a straight line joins them.
    """
    found: dict[int, tuple[float, bool]] = {}

    def at(place: int) -> tuple[float, bool]:
        if place not in found:
            found[place] = _fold(rig, frictions[place])
        return found[place]

    folds = np.empty(len(frictions))
    for first, last in pairwise([*range(0, len(frictions) - 1, _STRIDE), len(frictions) - 1]):
        (left, is_quick), (right, is_too) = at(first), at(last)
        if (is_quick and is_too) or np.isfinite(left) != np.isfinite(right):
            folds[first : last + 1] = [at(place)[0] for place in range(first, last + 1)]
        else:
            folds[first : last + 1] = np.linspace(left, right, last - first + 1) if np.isfinite(left) else left
    return folds


def _fold(rig: Rig, friction: Friction) -> tuple[float, bool]:
    """The fold (rad/s), and whether it is quickly found: stick-slip ends in grazing, or there is none."""
    try:
        end = end_of_stick_slip(rig, friction)
    except (ValueError, FloatingPointError):  # too strong friction, a rig that is never stable, or no orbit found
        return np.inf, False
    return float(end.speed), end.kind in ("grazing", "none")


def _steps(highest: float) -> list[float]:
    """Numbers from 0 up to `highest`, in at most six steps of 1, 2 or 5 times a power of ten."""
    power = floor(log10(highest / 6.0))
    step = float(next(f"{digit}e{power}" for digit in (1, 2, 5, 10) if highest <= 6.000001 * float(f"{digit}e{power}")))
    return [float(f"{step * k:.9g}") for k in range(int(highest / step + 1e-6) + 1)]


def _paint_scales(ground: pygame.Surface, fonts: Fonts, axes: Axes, x: dict[float, str]) -> None:
    """Grid and numbers of a chart."""
    box = axes.box
    for value, name in x.items():
        ((across, _),) = axes.places(value, 0.0)
        pygame.draw.line(ground, _GRID, (across, box.top), (across, box.bottom), 2)
        write(ground, fonts.small, name, (across, box.bottom + 10), "midtop", MUTED)
    for value in _steps(axes.y[1]):
        ((_, down),) = axes.places(0.0, value)
        pygame.draw.line(ground, _GRID, (box.left, down), (box.right, down), 2)
        write(ground, fonts.small, f"{value:g}", (box.left - 14, down), "midright", MUTED)


def _paint_title(
    ground: pygame.Surface, fonts: Fonts, box: pygame.Rect, title: str, lines: tuple[tuple[str, str, bool], ...]
) -> None:
    """The name of the vertical axis, then the lines of the chart and whether they are dashed."""
    base, right = box.top - 20, float(box.left)
    right = write(ground, fonts.large, title, (right, base), "bottomleft", INK) + 50
    for name, color, dashed in lines:
        _line(ground, color, [(right, base - 20), (right + 44, base - 20)], 4 if dashed else 7, dashed)
        right = write(ground, fonts.large, name, (right + 56, base), "bottomleft", color) + 30


def _line(surface: pygame.Surface, color: str, points: list[Point], width: int, dashed: bool = False) -> None:
    """A line through points; none where there are fewer than two."""
    if len(points) < 2:
        return
    if not dashed:
        pygame.draw.lines(surface, color, False, points, width)
        return
    x, y = np.array(points).T
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    starts = np.arange(0.0, along[-1], 28.0)
    ends = np.stack([(np.interp(at, along, x), np.interp(at, along, y)) for at in (starts, starts + 16.0)])
    for start, end in ends.transpose(2, 0, 1).tolist():
        pygame.draw.line(surface, color, start, end, width)
