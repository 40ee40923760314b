"""Memory of a policy without memory: the last n observations, put side by side."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Frames = npt.NDArray[np.float32]


def no_frames(rigs: int, frames: int, channels: int) -> Frames:
    """The stack before an episode's first observation: zeros, shape (rigs, frames * channels)."""
    return np.zeros((rigs, frames * channels), dtype=np.float32)


def push(stack: Frames, observation: Frames, episode_start: npt.NDArray[np.bool_] | None = None) -> Frames:
    """The stack with a new observation, shape (rigs, channels), at its end; the oldest falls out.

    Where `episode_start`, what came before is forgotten. Bit for bit what SB3's `VecFrameStack` shows.
    """
    channels = observation.shape[1]
    pushed = np.empty_like(stack)
    pushed[:, :-channels] = stack[:, channels:]
    if episode_start is not None:
        pushed[np.asarray(episode_start, dtype=bool)] = 0.0
    pushed[:, -channels:] = observation
    return pushed
