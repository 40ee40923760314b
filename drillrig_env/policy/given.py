"""What `predict` is given, refused by name where no action can come of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from drillrig_env.arrays import Observations
from drillrig_env.parameters import refuse


def observations_of(name: str, channels: Sequence[str], observation: Any) -> Observations:
    """The observations that the policy `name` is given: (n, channels) of many rigs, or (channels,) of one.

    `ValueError` for another shape, for what is no real number, and for what is not finite, with its channel.
    """
    found = np.asarray(observation)
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


def check_rows(name: str, rigs: int, state: Any, episode_start: Any) -> None:
    """Raise `ValueError` where a policy's memory or its flags of beginning episodes are not those of `rigs` rigs.

    `state` is the array that the policy keeps, one row a rig, and None at first; `episode_start` may be None as well.
    """
    for what, given in (("rows of the state", state), ("flags in episode_start", episode_start)):
        rows = rigs if given is None else len(np.atleast_1d(given))
        if rows != rigs:
            raise refuse(name, what, rows, "", f"{rigs}, one a rig")
