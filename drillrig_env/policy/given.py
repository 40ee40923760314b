"""What `predict` is given, refused by name where no action can come of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import Observations
from drillrig_env.parameters import refuse

POLICY = "policy"
"""The name of a policy's part of an observation that also has one for a critic."""


def observations_of(name: str, channels: Sequence[str], observation: Any) -> Observations:
    """The observations that the policy `name` is given: (n, channels) of many rigs, or (channels,) of one.

    Where there is a part for a critic, they are the policy's part. `ValueError` for another shape, for what is no real
    number, and for what is not finite, with its channel.
    """
    if isinstance(observation, Mapping) and POLICY not in observation:
        allowed = f"an array, or a dictionary with the entry {POLICY!r}"
        raise refuse(name, "entries of an observation", ", ".join(map(str, observation)), "", allowed)
    found = np.asarray(observation[POLICY] if isinstance(observation, Mapping) else observation)
    width = len(channels)
    if found.ndim not in (1, 2) or found.shape[-1] != width:
        allowed = f"({width},) or (n, {width}): {', '.join(channels)}"
        raise refuse(name, "shape of an observation", found.shape, "", allowed)
    if found.dtype.kind not in "fiub":
        raise refuse(name, "kind of an observation", found.dtype, "", "real numbers, such as float32")
    finite = np.isfinite(found)
    if not finite.all():
        where = tuple(np.argwhere(~finite)[0])
        raise refuse(name, f"observation of {channels[where[-1]]}", found[where], "", "finite numbers")
    return found


def check_state(name: str, rigs: int, widths: Sequence[int], state: Any) -> None:
    """Raise `ValueError` where `state` is not what the policy `name` returns: first parts of these widths.

    Each part has the shape (rigs, width) and is finite; more may follow. None is the state at first.
    """
    if state is None:
        return
    if not isinstance(state, tuple | list) or not len(state):
        raise refuse(name, "kind of the state", type(state).__name__, "", "None, or what the last predict returned")
    if len(state) < len(widths):
        raise refuse(name, "parts of the state", len(state), "", f"{len(widths)}, as the last predict returned them")
    for part, width in zip(state, widths, strict=False):
        found = np.shape(part)
        if found != (rigs, width):
            allowed = f"{(rigs, width)}, as the last predict returned it for these rigs"
            raise refuse(name, "shape of the state", found, "", allowed)
        if not np.isfinite(part).all():
            raise refuse(name, "state", "one that is not finite", "", "finite numbers")


def flags_of(name: str, rigs: int, episode_start: Any) -> npt.NDArray[np.bool_] | None:
    """Which of `rigs` rigs begin an episode, shape (rigs,); None where nothing is said.

    `ValueError` for another number of flags, and for what is neither true nor false.
    """
    if episode_start is None:
        return None
    found = np.atleast_1d(episode_start)
    if found.shape != (rigs,):
        raise refuse(name, "shape of episode_start", found.shape, "", f"({rigs},), one a rig")
    if found.dtype != bool and (others := [one for one in found.tolist() if one not in (0, 1)]):
        raise refuse(name, "episode_start", repr(others[0]), "", "true or false, one a rig")
    return found.astype(bool)
