"""What a policy is: `predict` on batches, and what it may say of itself.

| attribute | what it says | without it |
|---|---|---|
| `predict(observation, state, episode_start, deterministic)` | actions, and its next state | no policy |
| `sensors` | channels that it must be shown, or the name of a set of them | it takes what it is shown |
| `privileged`, `tell(info)` | entries of `info` that it must be told before each `predict` | it is told nothing |
| `exact` | it is shown its channels without noise and delay, whatever the sensors | it sees what they show |
| `drive` | the `Drive` that it asks for | the rig's own drive |
| `slow` | an episode takes minutes rather than seconds | it is quick |

A class or function that makes policies gets, by keyword, those of `sensors`, `rig`, `slew_limit`, `control_period`,
`largest_reference` and `fleet` that it names: what belongs to the task that it acts in (see
`drillrig_env.env.task.Task`). `fleet` is that of the scenario, None where all episodes have the one rig; a policy that
is told "rig" is told which of its members each episode has.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import Actions, Observations
from drillrig_env.drive import Drive
from drillrig_env.parameters import refuse

Memory: TypeAlias = tuple[np.ndarray, ...] | None
"""What a policy keeps from one call of `predict` to the next: arrays with one row a rig, or nothing."""


@runtime_checkable
class Policy(Protocol):
    """Anything with Stable-Baselines3's `predict`: a baseline, a trained model, your own."""

    def predict(
        self,
        observation: Observations,
        state: Memory = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Memory]:
        """Actions of shape (n, 1), -1 to 1, for observations of shape (n, channels), and the policy's next state.

        `observation` has them; where `deterministic` is False a policy may explore.

        `state` is what the last call returned, None at first; where `episode_start`, shape (n,), is true it
        is begun anew.
        """


def channels_of(policy: Any) -> tuple[str, ...] | None:
    """The channels that a policy (or a class of policies) must be shown, by name; None where it takes what it is shown.

    `sensors` may be a sequence of names, or a record that has them as `names`.

    >>> from drillrig_env.policy import channels_of, load
    >>> channels_of(load("constant"))[:2]
    ('twist_12', 'twist_23')
    """
    sensors = getattr(policy, "sensors", None)
    names = getattr(sensors, "names", sensors)
    if names is None:
        return None
    if isinstance(names, str) or not isinstance(names, Sequence) or not all(isinstance(name, str) for name in names):
        raise refuse(type(policy).__name__, "sensors", repr(sensors), "", "names of channels, or none")
    return tuple(names)


def privileged_of(policy: Any) -> tuple[str, ...]:
    """The entries of `info` that a policy must be told before each `predict`.

    `ValueError` where they are no names, `TypeError` where the policy cannot be told.
    """
    told = getattr(policy, "privileged", ())
    if isinstance(told, str) or not isinstance(told, Sequence) or not all(isinstance(name, str) for name in told):
        raise refuse(type(policy).__name__, "privileged", repr(told), "", "names of entries of info, such as ('mu_s',)")
    names = tuple(told)
    if names and not callable(getattr(policy, "tell", None)):
        raise TypeError(f"{type(policy).__name__} must be told {', '.join(names)}, and has no tell(info)")
    return names


def is_exact(policy: Any) -> bool:
    """Whether a policy is shown its own channels as they are, without noise and delay.

    `ValueError` where that is neither true nor false, or where it does not say which channels.
    """
    exact = getattr(policy, "exact", False)
    if not isinstance(exact, bool):
        raise refuse(type(policy).__name__, "exact", repr(exact), "", "True or False")
    if exact and channels_of(policy) is None:
        raise refuse(
            type(policy).__name__, "sensors", None, "", "names of channels, those that it is shown as they are"
        )
    return exact


def drive_of(policy: Any) -> Drive | None:
    """The drive that a policy asks for; None for the rig's own. `ValueError` where that is no drive."""
    return Drive.of(getattr(policy, "drive", None))
