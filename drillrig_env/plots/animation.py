"""Make the README's animation: a rig held at its target sticks and slips, until jump-and-ease frees it.

    drillrig animate --output docs/images/stick_slip.gif
    drillrig animate --normal-force 10 --speed-target 2.4 --hold 10 --output calm.gif
    drillrig animate --rig my_rig.toml --output mine.gif

The rig has the chapter's friction and starts in stick-slip. After --hold seconds the policy jump_ease
takes over, and the animation ends once the bit has been calm at the target for 4 s. On another rig these
are what corresponds to them. A target between the critical speed and the fold shows most: there the same
rig at the same speed ends calm where it began in stick-slip.

Needs the extra `render`: in a clone, pip install -e '.[render]'
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt

from drillrig_env.allowed import Made
from drillrig_env.command_line import Parser, command
from drillrig_env.env.task import Task
from drillrig_env.extras import missing
from drillrig_env.files import check_writable_file, written_whole
from drillrig_env.flags import add_fields, add_rig_argument, given_fields
from drillrig_env.parameters import COUNT, NOT_NEGATIVE, POSITIVE, check_fields, parameter
from drillrig_env.policy import context_of, make_policy
from drillrig_env.progress import Progress
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales

_FORCE, _TARGET, _HOLD, _LONGEST = 20.0, 3.2, 6.0, 120.0  # N, rad/s, s and s, on the chapter's rig
_COLORS = 64
_CALM_TIME, _CALM_DEVIATION = 4.0, 0.05


@dataclass(frozen=True)
class Film:
    """What is filmed and how: a rig at a normal force and a target, and the size and pace of the film.

    Raises `ValueError` for a value that is not allowed.
    """

    normal_force: float = parameter(None, "N", "normal force", allowed=NOT_NEGATIVE, none=f"{_FORCE:g}, by rig")
    speed_target: float = parameter(None, "rad/s", "speed target", allowed=POSITIVE, none=f"{_TARGET:g}, by rig")
    hold: float = parameter(
        None,
        "s",
        "time at the target before jump-and-ease takes over",
        allowed=NOT_NEGATIVE,
        none=f"{_HOLD:g}, by rig",
    )
    speed_up: int = parameter(2, "", "seconds of the rig in a second of the film", allowed=COUNT)
    every: int = parameter(1, "control steps", "from one frame to the next", allowed=COUNT)
    width: int = parameter(640, "px", "width", allowed=COUNT)
    rig: Rig = parameter(meaning="the rig that is filmed", factory=Rig, allowed=Made(Rig.of, "as Rig.of takes it"))

    def __post_init__(self) -> None:
        check_fields(self)
        scales = self.task.scales
        standard = {
            "normal_force": _FORCE * scales.force,
            "speed_target": _TARGET * scales.speed,
            "hold": _HOLD * scales.time,
        }
        for name, value in standard.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)

    @property
    def task(self) -> Task:
        """The task that is filmed."""
        return Task.for_rig(self.rig, scenario="nominal", duration=_LONGEST * Scales.of(self.rig).duration)

    @property
    def frame_time(self) -> int:
        """How long a frame is shown, ms."""
        return round(1000 * self.task.control_period * self.every / self.speed_up)


def frames(film: Film) -> Iterator[npt.NDArray[np.uint8]]:
    """The frames of the film as RGB of shape (540, 960, 3), until the bit is calm at the target.

    On the chapter's rig they end after 120 s in any case. Raises `ValueError` for an impossible normal force or target.
    """
    task = film.task
    env = gym.make("DrillRig-v0", task=task, render_mode="rgb_array")
    policy: Any = make_policy("jump_ease", **context_of(task))
    memory = None
    options = {"normal_force": film.normal_force, "speed_target": film.speed_target, "start": "stick_slip"}
    observation, info = env.reset(seed=0, options=options)
    seen: deque[float] = deque(maxlen=round(_CALM_TIME * task.scales.time / task.control_period))
    for step in range(task.steps):
        policy.tell(info)
        action, memory = policy.predict(observation, memory)  # during the hold too, to see the oscillation
        held = step * task.control_period < film.hold
        observation, _, _, _, info = env.step(np.zeros_like(action) if held else action)
        if step % film.every == 0:
            yield np.asarray(env.render())
        seen.append(info["bit_speed"] / film.speed_target - 1.0)
        if not held and len(seen) == seen.maxlen and max(map(abs, seen)) < _CALM_DEVIATION:
            break
    env.close()


def save(film: Film, path: Path) -> int:
    """Write the film as a GIF that repeats for ever, and show the progress; returns the number of frames.

    All frames share one palette, in which thin lines keep their colours; a frame stores only what moved.
    """
    try:
        from PIL import Image
    except ImportError as error:
        raise missing("the animation", "Pillow", "render") from error

    size, palette, pictures = None, None, []
    longest = ceil(film.task.steps / film.every)
    with Progress(path.name, parts=1) as progress:
        for number, frame in enumerate(frames(film)):
            progress.show("frames", number, longest)
            picture = Image.fromarray(frame)
            size = size or (film.width, round(film.width * picture.height / picture.width))
            small = picture.resize(size, Image.Resampling.LANCZOS)
            palette = palette or small.quantize(_COLORS, Image.Quantize.FASTOCTREE)
            pictures.append(small.quantize(palette=palette, dither=Image.Dither.NONE))
        progress.show("frames", longest, longest)  # calm is mostly reached before
    more: dict[str, Any] = {"append_images": pictures[1:], "duration": film.frame_time, "loop": 0, "optimize": True}
    with written_whole(path) as new:
        pictures[0].save(new, save_all=True, **more)
    return len(pictures)


@command
def main(arguments: Sequence[str] | None = None, prog: str = "python -m drillrig_env.plots.animation") -> int:
    """Parse the command line and make the animation."""
    parser = Parser(prog=prog, description=__doc__)
    parser.add_argument("--output", type=Path, required=True, metavar="GIF", help="the file to write")
    add_rig_argument(parser)
    add_fields(parser, Film, skip=["rig"])
    options = parser.parse_args(arguments)
    check_writable_file(options.output)
    try:
        number = save(Film(**{**given_fields(options, Film), "rig": options.rig}), options.output)
    except (ValueError, ImportError) as error:
        parser.error(error)
    print(f"{options.output}: {number} frames, {options.output.stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
