"""Make the README's animation: a rig held at its target sticks and slips, until jump-and-ease frees it.

    python -m drillrig_env.plots.animation --output docs/images/stick_slip.gif
    python -m drillrig_env.plots.animation --normal-force 10 --speed-target 2.4 --hold 10 --output calm.gif

The rig has the chapter's friction and starts in stick-slip. After --hold seconds the policy
jump_ease takes over, and the animation ends once the bit has been calm at the target for 4 s. A
target between the critical speed and the fold shows most: there the same rig at the same speed
ends calm where it began in stick-slip.

Needs the extra `render`: pip install 'drillrig[render]'
"""

from __future__ import annotations

import argparse
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt

from drillrig_env.env.kernel import CONTROL_PERIOD
from drillrig_env.parameters import refuse
from drillrig_env.policy import make_policy

_LONGEST = 120.0  # s
_COLORS = 64
_CALM_TIME, _CALM_DEVIATION = 4.0, 0.05


@dataclass(frozen=True)
class Film:
    """What is filmed and how: a rig at a normal force and a target, and the size and pace of the film.

    Raises `ValueError` for a number of steps, pixels or a pace below 1, or a hold below 0.
    """

    normal_force: float = 20.0  # N
    speed_target: float = 3.2  # rad/s
    hold: float = 6.0  # s at the target, before jump-and-ease takes over
    speed_up: int = 2  # seconds of the rig in a second of the film
    every: int = 1  # control steps from one frame to the next
    width: int = 640  # px

    def __post_init__(self) -> None:
        for name, unit, least in (("speed_up", "", 1), ("every", "steps", 1), ("width", "px", 1), ("hold", "s", 0)):
            value = getattr(self, name)
            if not value >= least:
                raise refuse("Film", name, value, unit, f">= {least}")

    @property
    def frame_time(self) -> int:
        """How long a frame is shown, ms."""
        return round(1000 * CONTROL_PERIOD * self.every / self.speed_up)


def frames(film: Film) -> Iterator[npt.NDArray[np.uint8]]:
    """The frames of the film as RGB of shape (540, 960, 3), until the bit is calm at the target or 120 s are over.

    Raises `ValueError` for an impossible normal force or target.
    """
    env = gym.make("DrillRig-v0", scenario="nominal", duration=_LONGEST, render_mode="rgb_array")
    policy: Any = make_policy("jump_ease")
    memory = None
    options = {"normal_force": film.normal_force, "speed_target": film.speed_target, "start": "stick_slip"}
    observation, info = env.reset(seed=0, options=options)
    seen: deque[float] = deque(maxlen=round(_CALM_TIME / CONTROL_PERIOD))
    for step in range(round(_LONGEST / CONTROL_PERIOD)):
        policy.tell(info)
        action, memory = policy.predict(observation, memory)  # during the hold too, to see the oscillation
        held = step * CONTROL_PERIOD < film.hold
        observation, _, _, _, info = env.step(np.zeros_like(action) if held else action)
        if step % film.every == 0:
            yield np.asarray(env.render())
        seen.append(info["bit_speed"] / film.speed_target - 1.0)
        if not held and len(seen) == seen.maxlen and max(map(abs, seen)) < _CALM_DEVIATION:
            break
    env.close()


def save(film: Film, path: Path) -> int:
    """Write the film as a GIF that repeats for ever, with a progress bar; returns the number of frames.

    All frames share one palette, in which thin lines keep their colours; a frame stores only what moved.
    """
    try:
        from PIL import Image
        from tqdm import tqdm  # type: ignore[import-untyped,unused-ignore]
    except ImportError as error:
        raise ImportError("the animation needs Pillow and tqdm: pip install 'drillrig[render]'") from error

    size, palette, pictures = None, None, []
    for frame in tqdm(frames(film), desc=path.name, unit=" frames"):
        picture = Image.fromarray(frame)
        size = size or (film.width, round(film.width * picture.height / picture.width))
        small = picture.resize(size, Image.Resampling.LANCZOS)
        palette = palette or small.quantize(_COLORS, Image.Quantize.FASTOCTREE)
        pictures.append(small.quantize(palette=palette, dither=Image.Dither.NONE))
    path.parent.mkdir(parents=True, exist_ok=True)
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=film.frame_time, loop=0, optimize=True)
    return len(pictures)


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line and make the animation."""
    default = Film()
    parser = argparse.ArgumentParser(
        prog="python -m drillrig_env.plots.animation",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--output", type=Path, required=True, help="the GIF to write")
    parser.add_argument("--normal-force", type=float, default=default.normal_force, metavar="N", help="default: 20 N")
    parser.add_argument(
        "--speed-target", type=float, default=default.speed_target, metavar="RAD/S", help="default: 3.2 rad/s"
    )
    parser.add_argument("--hold", type=float, default=default.hold, metavar="S", help="time at the target (default: 6)")
    parser.add_argument(
        "--speed-up", type=int, default=default.speed_up, metavar="N", help="times faster than the rig (default: 2)"
    )
    parser.add_argument(
        "--every", type=int, default=default.every, metavar="N", help="control steps a frame (default: 1)"
    )
    parser.add_argument("--width", type=int, default=default.width, metavar="PX", help="width (default: 640)")
    values = vars(parser.parse_args(arguments))
    path = values.pop("output")
    try:
        number = save(Film(**values), path)
    except (ValueError, OSError) as error:
        parser.error(str(error))
    print(f"{path}: {number} frames, {path.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
