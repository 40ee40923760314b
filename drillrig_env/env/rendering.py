"""The rig as a person would see it: turning discs, strip charts, and where it stands on its stability map.

Everything is drawn from the record of one rig. Angles are summed up from its speeds for the picture
alone, and nothing here reaches back into the physics. A canvas of twice the size is drawn and halved,
which smooths every edge; what seldom changes is painted once and kept as the background.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import ceil, cos, pi, sin, tau
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.error import ResetNeeded

from drillrig_env.env import charts
from drillrig_env.env.charts import BIT, HISTORY, INK, MINUS, MUTED, PAPER, TOP, Point, write
from drillrig_env.env.task import Task

# isort: split
import pygame  # after the charts, which say what to install where it is missing

SIZE = (960, 540)
"""Width and height of a frame, px."""

_CANVAS = (2 * SIZE[0], 2 * SIZE[1])  # every place and length below is on the canvas
_COLLARS = "#7a828c"
_STEEL, _DARK_STEEL = "#f2f4f6", "#c3cad2"


@dataclass(frozen=True)
class _Disc:
    """A disc seen obliquely from above; angles (rad) grow clockwise, the way a drill string turns."""

    name: str
    color: str
    pale: str
    y: float
    x: float = 270.0
    radius: float = 165.0
    flatness: float = 0.32
    thickness: float = 36.0

    def at(self, angle: float, share: float = 1.0) -> Point:
        """The point of the upper face at an angle and a share of the radius."""
        reach = share * self.radius
        return self.x + reach * cos(angle), self.y + reach * self.flatness * sin(angle)

    def sector(self, start: float, end: float) -> list[Point]:
        """The outline of the sector between two angles."""
        return [(self.x, self.y), *(self.at(angle) for angle in np.linspace(start, end, 24).tolist())]

    def face(self, sunk: float = 0.0) -> pygame.Rect:
        """The rectangle around the upper face, or around the one that lies `sunk` below it."""
        height = self.radius * self.flatness
        return pygame.Rect(self.x - self.radius, self.y - height + sunk, 2 * self.radius, 2 * height)


_DISCS = (
    _Disc("bit", BIT, "#bfd3e8", 880.0),
    _Disc("collars", _COLLARS, "#d3d8de", 560.0),
    _Disc("top drive", TOP, "#cfe6cb", 240.0),
)
_PIN_ANGLE, _PIN_SHARE = 0.55, 0.72  # where the brake pin presses on the bit
_BESIDE = 480.0  # where the labels of the discs begin


class RigPicture:
    """Frames of one rig: `begin` an episode, `follow` every step, and take a `frame`.

    `record` is the rig's entry in the batch core (see `drillrig_env.env.episode.EPISODE`) and changes in
    place. With `window` the picture is also shown in a window, `frame_rate` times a second; a window
    that its owner closes stays closed, and the episode goes on without it.
    """

    def __init__(self, task: Task, record: np.void, window: bool, frame_rate: float) -> None:
        self._fonts = charts.Fonts.load()
        self._canvas, self._picture = _surfaces()
        self._task, self._scales, self._record, self._frame_rate = task, task.scales, record, frame_rate
        self._background: pygame.Surface | None = None  # painted when it is first needed
        self._window = self._open_window() if window else None
        self._clock = pygame.time.Clock()
        self._angle = 0.0  # of the top drive, rad
        self._chart, self._map = self._speed_axes(1.0), charts.map_axes(task.largest_reference, 1.0)
        shown = round(HISTORY * self._scales.time / task.control_period)
        self._past: deque[tuple[float, ...]] = deque(maxlen=shown + 1)

    @property
    def began(self) -> bool:
        """Whether there is an episode to draw."""
        return len(self._past) > 0

    def begin(self) -> None:
        """Begin the picture of a new episode, with the map of its friction."""
        self._angle = 0.0
        self._past.clear()
        self._remember()
        self._scale()
        self.show()

    def follow(self) -> None:
        """Follow the rig through one control step."""
        self._angle += float(self._record["state"][4]) * self._task.control_period
        self._remember()
        fastest = max(self._past[-1][:3])
        if fastest > self._chart.y[1]:
            self._chart = self._speed_axes(ceil(fastest / self._scales.speed))
            self._background = None
        self.show()

    def memory(self) -> tuple[float, list[tuple[float, ...]]]:
        """What the picture knows beyond the rig's record: the angle of the top drive (rad) and what the charts show."""
        return self._angle, list(self._past)

    def recall(self, memory: tuple[float, list[tuple[float, ...]]]) -> None:
        """Go on from what another picture of such a rig knew, in the window too."""
        self._angle = memory[0]
        self._past.clear()
        self._past.extend(memory[1])
        if self.began:
            self._scale()
            self.show()

    def frame(self) -> npt.NDArray[np.uint8]:
        """The picture as RGB, shape (540, 960, 3)."""
        self._draw()
        pixels = bytearray(pygame.image.tobytes(self._picture, "RGB"))
        return np.frombuffer(pixels, dtype=np.uint8).reshape(SIZE[1], SIZE[0], 3)

    def show(self) -> None:
        """Show the picture in the window, if there is one, and wait until the next one is due."""
        if self._window is None:
            return
        if pygame.event.get(pygame.QUIT):
            self.close()
            return
        self._draw()
        self._window.blit(self._picture, (0, 0))
        pygame.display.flip()
        self._clock.tick(self._frame_rate)

    def close(self) -> None:
        """Close the window, if there is one; again changes nothing."""
        if self._window is not None:
            self._window = None
            pygame.display.quit()

    def _open_window(self) -> pygame.Surface:
        pygame.display.init()
        pygame.display.set_caption("DrillRig")
        return pygame.display.set_mode(SIZE)

    def _scale(self) -> None:
        """Choose the ranges of map and charts for the episode."""
        record, scales = self._record, self._scales
        loads = record["load_forces"][np.isfinite(record["load_times"])]
        highest_load = max(30.0 * scales.force, record["normal_force"], *loads)
        fastest = max(max(row[:3]) for row in self._past)
        self._map = charts.map_axes(self._task.largest_reference, 1.2 * highest_load)
        target = record["speed_target"] / scales.speed
        self._chart = self._speed_axes(max(2.5 * ceil(target), ceil(fastest / scales.speed)))
        self._background = None

    def _speed_axes(self, highest: float) -> charts.Axes:
        """The axes of the strip charts up to a speed, in rad/s of the chapter's rig."""
        return charts.speed_axes(HISTORY * self._scales.time, highest * self._scales.speed)

    def _remember(self) -> None:
        record = self._record
        state = record["state"]
        self._past.append(tuple(map(float, (state[2], state[4], record["speed_reference"], record["normal_force"]))))

    def _draw(self) -> None:
        if self._background is None:
            self._background = self._painted_background()
        self._canvas.blit(self._background, (0, 0))
        self._draw_rig()
        past = np.array(self._past)
        times = self._task.control_period * np.arange(1 - len(past), 1, dtype=np.float64)
        charts.draw_speeds(self._canvas, self._chart, times, past[:, :3], self._record["speed_target"])
        charts.draw_path(self._canvas, self._map, past[:, 2], past[:, 3])
        pygame.transform.smoothscale(self._canvas, SIZE, self._picture)

    def _draw_rig(self) -> None:
        """From the bit upwards, since what is higher hides what is lower."""
        state = self._record["state"].tolist()
        angles = (self._angle + state[1] + state[0], self._angle + state[1], self._angle)
        for i, (disc, angle, speed) in enumerate(zip(_DISCS, angles, state[2:5], strict=True)):
            self._draw_disc(disc, angle)
            turning = f"{speed:z.2f} rad/s".replace("-", MINUS)
            write(self._canvas, self._fonts.large, turning, (_BESIDE, disc.y + 2), "topleft", disc.color)
            if disc.name == "bit":
                self._draw_pin(disc)
            if disc.name != "top drive":
                self._draw_shaft(disc, _DISCS[i + 1], angle, angles[i + 1])
        top = _DISCS[-1]
        motor = pygame.Rect(top.x - 95, 34, 190, 104)
        pygame.draw.line(self._canvas, MUTED, motor.midbottom, (top.x, top.y), 22)
        pygame.draw.rect(self._canvas, MUTED, motor, border_radius=14)
        write(self._canvas, self._fonts.small, "motor", motor.center, "center", PAPER)
        time = f"time {self._record['step'] * self._task.control_period:.1f} s"
        write(self._canvas, self._fonts.large, time, (_BESIDE, motor.centery), "midleft", INK)

    def _draw_disc(self, disc: _Disc, angle: float) -> None:
        """A disc with its mark, the mark of the top drive, and between them how far the disc is turned back."""
        canvas, side = self._canvas, disc.face(disc.thickness)
        pygame.draw.ellipse(canvas, disc.color, side)
        pygame.draw.rect(canvas, disc.color, (side.left, disc.y, side.width, disc.thickness))
        if sin(angle) > 0:  # the mark runs down the front of the rim
            edge = [disc.at(angle - 0.08), disc.at(angle + 0.08)]
            pygame.draw.polygon(canvas, PAPER, [*edge, *((x, y + disc.thickness) for x, y in reversed(edge))])
        pygame.draw.ellipse(canvas, _STEEL, disc.face())
        twist = min(max(angle - self._angle, -tau), tau)
        pygame.draw.polygon(canvas, disc.pale, disc.sector(angle - twist, angle))
        pygame.draw.line(canvas, TOP, (disc.x, disc.y), disc.at(self._angle), 5)
        pygame.draw.ellipse(canvas, disc.color, disc.face(), 5)
        pygame.draw.polygon(canvas, disc.color, disc.sector(angle - 0.08, angle + 0.08))

    def _draw_shaft(self, low: _Disc, high: _Disc, low_angle: float, high_angle: float) -> None:
        """The shaft between two discs, with four lines along it that the twist winds up."""
        half = 14.0
        pygame.draw.rect(self._canvas, _DARK_STEEL, (low.x - half, high.y, 2 * half, low.y - high.y))
        heights = np.linspace(low.y, high.y, 24).tolist()
        for quarter in (0.0, pi / 2, pi, 3 * pi / 2):
            turned = np.linspace(low_angle, high_angle, 24) + quarter
            front = zip((low.x + half * np.cos(turned)).tolist(), heights, (np.sin(turned) > 0).tolist(), strict=True)
            for (x, y, seen), (next_x, next_y, next_seen) in pairwise(front):
                if seen and next_seen:
                    pygame.draw.line(self._canvas, MUTED, (x, y), (next_x, next_y), 4)
        twist = f"twist {low_angle - high_angle:+z.2f} rad".replace("-", MINUS)
        write(self._canvas, self._fonts.small, twist, (low.x - 30, (low.y + high.y) / 2), "midright", MUTED)

    def _draw_pin(self, bit: _Disc) -> None:
        """The brake pin, and above it the normal force as an arrow."""
        force = float(self._record["normal_force"])
        x, y = bit.at(_PIN_ANGLE, _PIN_SHARE)
        pygame.draw.line(self._canvas, INK, (x, y), (x, y - 76), 24)
        pygame.draw.circle(self._canvas, INK, (x, y), 12)
        if force > 0:
            tip = y - 84
            pygame.draw.line(self._canvas, INK, (x, tip - 28 - 110 * force / self._map.y[1]), (x, tip - 20), 9)
            pygame.draw.polygon(self._canvas, INK, [(x, tip), (x - 17, tip - 26), (x + 17, tip - 26)])
        write(self._canvas, self._fonts.small, f"normal force {force:.1f} N", (x + 34, y - 114), "midleft", INK)

    def _painted_background(self) -> pygame.Surface:
        """What changes with the episode or the range of the strip charts only."""
        ground = pygame.Surface(_CANVAS, depth=32)
        ground.fill(PAPER)
        for disc in _DISCS:
            write(ground, self._fonts.large, disc.name, (_BESIDE, disc.y), "bottomleft", disc.color)
        mu_s, mu_k, v_b = (float(self._record[name]) for name in ("mu_s", "mu_k", "v_b"))
        friction = mu_s, mu_k, v_b, self._task.scenario.friction.law
        charts.paint_map(ground, self._fonts, self._map, self._task.rig, *friction)
        charts.paint_speeds(ground, self._fonts, self._chart)
        return ground


class RigPictures:
    """Pictures of all rigs of a batch, each with its own history; they share what they are drawn on.

    A picture that has been drawn keeps a background of 8 MB.
    """

    def __init__(self, task: Task, episodes: np.ndarray) -> None:
        self._pictures = [RigPicture(task, episodes[i], False, 0.0) for i in range(len(episodes))]

    def begin(self, rigs: npt.NDArray[np.intp]) -> None:
        """Begin the pictures of new episodes in the rigs of these numbers."""
        for i in rigs:
            self._pictures[i].begin()

    def follow(self) -> None:
        """Follow all rigs through one control step."""
        for picture in self._pictures:
            picture.follow()

    def frames(self) -> tuple[npt.NDArray[np.uint8], ...]:
        """The pictures as RGB, each of shape (540, 960, 3). Raises `ResetNeeded` before the first episode."""
        if not all(picture.began for picture in self._pictures):
            raise ResetNeeded("there is no episode to draw yet; call reset() first")
        return tuple(picture.frame() for picture in self._pictures)

    def memory(self) -> list[Any]:
        """What the pictures know beyond the rigs' records."""
        return [picture.memory() for picture in self._pictures]

    def recall(self, memory: list[Any]) -> None:
        """Go on from what other pictures of such rigs knew."""
        for picture, one in zip(self._pictures, memory, strict=True):
            picture.recall(one)


@lru_cache(maxsize=1)
def _surfaces() -> tuple[pygame.Surface, pygame.Surface]:
    """What all pictures are drawn on: a canvas, and the picture that it is halved to."""
    return pygame.Surface(_CANVAS, depth=32), pygame.Surface(SIZE, depth=32)
