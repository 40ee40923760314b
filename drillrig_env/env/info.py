"""What an info says of many rigs, and of a single one, read number by number.

Making NumPy scalars of one record's fields by name costs more than the physics of a step; an entry of an array of plain
numbers does not.
"""

from __future__ import annotations

from operator import itemgetter
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.env.episode import EPISODE
from drillrig_env.env.reward import Reward
from drillrig_env.env.reward_terms import TERMS
from drillrig_env.env.scenario import Scenario


def _place(name: str, index: int = 0) -> int:
    """Where a field of a rig's record stands among its entries of 8 bytes."""
    fields: Any = EPISODE.fields
    return int(fields[name][1]) // 8 + index


REWARD, STEP = _place("reward"), _place("step")
"""Where the reward stands among the numbers, and the control steps done among the counts."""

_changing = itemgetter(
    _place("state", 2),
    _place("state", 4),
    _place("speed_reference"),
    _place("normal_force"),
    _place("torque_into_string"),
    _place("terms", 0),
    _place("terms", 1),
    _place("terms", 2),
)
_NAMES = (
    "speed_reference",
    "speed_target",
    "normal_force",
    "mu_s",
    "mu_k",
    "v_b",
    "torque_into_string",
    "delay",
    "start",
    "rig",
)
"""Entries of a record that are in an info by their own names."""

_VARYING = tuple((name, _place(name)) for name in ("speed_target", "mu_s", "mu_k", "v_b"))
_NOT_YET = np.array(False)


def infos(episodes: np.ndarray, reward: Reward, success: npt.NDArray[np.bool_]) -> dict[str, npt.NDArray[Any]]:
    """What every step reports of n episodes, by name, one entry a rig: always the same names with the same dtypes.

    `success` tells of which an end was mitigated.
    """
    names = () if reward.own is None else reward.own.names
    return {
        "bit_speed": episodes["state"][:, 2].copy(),
        "top_speed": episodes["state"][:, 4].copy(),
        **{name: episodes[name].copy() for name in _NAMES},
        **{f"reward_{name}": episodes["terms"][:, i].copy() for i, name in enumerate(TERMS)},
        **{f"reward_{name}": episodes["own_terms"][:, i].copy() for i, name in enumerate(names)},
        "is_success": success,
    }


def entries_of(record: np.void) -> tuple[np.ndarray, np.ndarray]:
    """The entries of a record as numbers and as counts, both views of it: each says what its fields of that kind hold.

    `record` is one of `drillrig_env.env.episode.EPISODE`.
    """
    entries = record.dtype.itemsize // 8
    numbers: np.ndarray = np.ndarray(entries, np.float64, buffer=record.data)
    counts: np.ndarray = np.ndarray(entries, np.int64, buffer=record.data)
    return numbers, counts


def own_places(reward: Reward, scenario: Scenario) -> tuple[tuple[str, int], ...]:
    """Names in an info, and places among the numbers, of what only some tasks have to say in every step.

    These are terms of the reward of the user's own, and target and friction where they vary.
    """
    names = () if reward.own is None else reward.own.names
    terms = tuple((f"reward_{name}", _place("own_terms", i)) for i, name in enumerate(names))
    return terms + (_VARYING if scenario.varies else ())


def next_info(kept: dict[str, Any], numbers: np.ndarray, own: tuple[tuple[str, int], ...]) -> dict[str, Any]:
    """The info of a control step: what all of the episode say alike is in `kept`, the rest among the `numbers`.

    `own` is what `own_places` gives.
    """
    info = kept.copy()
    (
        info["bit_speed"],
        info["top_speed"],
        info["speed_reference"],
        info["normal_force"],
        info["torque_into_string"],
        info["reward_variance"],
        info["reward_tracking"],
        info["reward_action"],
    ) = _changing(numbers)
    for name, place in own:
        info[name] = numbers[place]
    info["is_success"] = _NOT_YET.copy()
    return info
