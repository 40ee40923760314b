"""What a critic may see that no policy does: the exact state, the load, the friction, and which rig it is.

With `privileged=True` an observation is a dictionary: "policy" is what it is otherwise, late and noisy as it is, and
"privileged" has the channels of the sensors "state", exact and at once, what the episode drew, how a tilted disc lies,
and of a fleet by how much its rig differs from the nominal one in whatever the fleet's rigs differ in. Everything is
scaled to about +-1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from math import cos, sin
from typing import Any, TypeAlias

import numpy as np
from gymnasium import spaces

from drillrig_env.arrays import FloatArray, Observations, Records
from drillrig_env.env.bank import RigBank
from drillrig_env.env.kernel import measure, scratch
from drillrig_env.env.scenario import Scenario
from drillrig_env.env.sensors import LIMIT, SENSORS, Channel
from drillrig_env.env.task import Task
from drillrig_env.jit.compiled import bound, compiled
from drillrig_env.parameters import POSITIVE
from drillrig_env.policy.given import POLICY
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales

PRIVILEGED = "privileged"
"""The name of a critic's part of an observation, beside that of the policy's."""

Seen: TypeAlias = Observations | dict[str, Observations]
"""What the environment shows: an array, or one for the policy and one for its critic."""

_DRAWN = (
    Channel("normal_force", "N", 20.0, 10.0, 0.0, "N_1 of the pin"),
    Channel("mu_s", "", 0.5, 0.25, 0.0, "coefficient of friction before slip"),
    Channel("mu_k", "", 0.306, 0.153, 0.0, "coefficient of friction at high speed"),
    Channel("v_b", "s/rad", 1.0, 0.5, 0.0, "how fast friction falls with speed"),
)
"""What an episode draws, on the chapter's rig; and the delay, whose range is the task's."""


class Privileged:
    """The privileged part of the observations of a batch: `channels`, of which the last are `parameters` of the rig.

    A parameter is seen as the logarithm of its ratio to the nominal one, or as the difference where it may be 0, over
    the largest in the fleet that `task` has; that of later ones is seen on the same scale. `shown` has shape
    (rigs, channels), a new array whenever it is filled.
    """

    def __init__(self, task: Task, bank: RigBank, rigs: int) -> None:
        state = SENSORS["state"].at(replace(task.scales, drive_given=task.drive is not None))
        low, high = task.delays
        width = (high - low) / 2.0 or 1.0
        delay = Channel("delay", "control steps", (low + high) / 2.0, width, 0.0, "by which measurements come late")
        self._tilted = task.scenario.tilt is not None
        drawn = (*_drawn_at(task.scales), delay, *_of_disc(task.scenario))
        self.parameters = _differing(bank)
        self._sizes = np.abs(_differences(bank.members.rigs, bank.nominal, self.parameters)).max(axis=0)
        rig = (
            Channel(f"rig_{name}", "", 0.0, size, 0.0, f"{name} of the rig beside the nominal one's")
            for name, size in zip(self.parameters, self._sizes.tolist(), strict=True)
        )
        self.channels = (*state.channels, *drawn, *rig)
        self._layout = state.layout(0.0)
        self._drawn = np.array([(channel.offset, channel.scale) for channel in drawn], dtype=float)
        self.shown: Observations = np.zeros((rigs, len(self.channels)), dtype=np.float32)
        self.take(bank)

    def take(self, bank: RigBank) -> None:
        """See the rigs of another bank. `ValueError`, and nothing changes, for a fleet that differs in more."""
        more = [name for name in _differing(bank) if name not in self.parameters]
        if more:
            raise ValueError(
                f"DrillRig: a fleet that differs in {', '.join(more)} is not allowed: the privileged observation has "
                f"{', '.join(self.parameters) or 'no parameter of the rig'}; make an environment for it"
            )
        shares = _differences(bank.rigs, bank.nominal, self.parameters) / self._sizes
        self._rigs = np.asarray(np.clip(shares, -LIMIT, LIMIT), dtype=np.float32)

    def check(self, scenario: Scenario) -> None:
        """Raise `ValueError` for a scenario with a tilted disc where none is seen."""
        if scenario.tilt is not None and not self._tilted:
            raise ValueError(
                "DrillRig: a tilted disc is not allowed: the privileged observation does not have its angle; make an "
                "environment with it"
            )

    def show(self, episodes: np.ndarray, settings: np.ndarray) -> None:
        """Fill `shown` from the records of the episodes, of EPISODE and SETTINGS."""
        self.shown = np.empty_like(self.shown)
        show_episodes(*self._arguments(episodes, settings, self.shown))

    def bound_show(self, episodes: np.ndarray, settings: np.ndarray, shown: Observations) -> Callable[[], None]:
        """A call that fills `shown`, each time from these records and with the rigs that there are now."""
        return bound(show_episodes, *self._arguments(episodes, settings, shown))

    def _arguments(self, episodes: np.ndarray, settings: np.ndarray, shown: Observations) -> tuple[np.ndarray, ...]:
        return episodes, settings, self._layout, self._drawn, self._rigs, shown, scratch()


def observation_space(channels: int, critic: Privileged | None) -> spaces.Space[Any]:
    """The space of one rig's observations: of so many channels, and of what a critic sees besides."""
    seen = spaces.Box(-LIMIT, LIMIT, (channels,), np.float32)
    if critic is None:
        return seen
    more = spaces.Box(-LIMIT, LIMIT, (len(critic.channels),), np.float32)
    return spaces.Dict({POLICY: seen, PRIVILEGED: more})


def copied(seen: Seen) -> Seen:
    """A copy of what is shown, which whoever is given it may write into."""
    return {name: part.copy() for name, part in seen.items()} if isinstance(seen, dict) else seen.copy()


def seen_by(seen: Seen, rig: int | np.integer) -> Seen:
    """What one rig shows, of what all do."""
    return {name: part[rig] for name, part in seen.items()} if isinstance(seen, dict) else seen[rig]


@compiled
def show_episodes(
    episodes: Records,
    settings: Records,
    layout: Records,
    drawn: FloatArray,
    rigs: Observations,
    shown: Observations,
    scratch: Records,
) -> None:
    """Fill the privileged part of n observations, `shown` of shape (n, channels).

    `layout` is that of the sensors "state", `drawn` has offset and scale of the five numbers that follow, or eight with
    a tilted disc, and `rigs` what is then seen of each rig of the bank.
    """
    values, first, following = scratch[0].values, layout.shape[0], layout.shape[0] + drawn.shape[0]
    for n in range(episodes.shape[0]):
        episode = episodes[n]
        measure(episode, layout, values, shown[n])
        angle = episode.turns * episode.state[7] + settings[0].tilt_phase
        tilted = 1.0 if episode.turns > 0 else 0.0
        pressing = (episode.normal_force, episode.mu_s, episode.mu_k, episode.v_b)
        numbers = (*pressing, float(episode.delay), tilted * cos(angle), tilted * sin(angle), episode.turns)
        for i in range(drawn.shape[0]):
            scaled = (numbers[i] - drawn[i, 0]) / drawn[i, 1]
            shown[n, first + i] = min(max(scaled, -LIMIT), LIMIT)
        for i in range(rigs.shape[1]):
            shown[n, following + i] = rigs[episode.rig, i]


def _drawn_at(scales: Scales) -> tuple[Channel, ...]:
    """The channels of what an episode draws on a rig with such scales."""
    factors = (scales.force, 1.0, 1.0, 1.0 / scales.speed)
    return tuple(
        replace(channel, offset=float(channel.offset) * factor, scale=channel.scale * factor)
        for channel, factor in zip(_DRAWN, factors, strict=True)
    )


def _of_disc(scenario: Scenario) -> tuple[Channel, ...]:
    """The channels of how a tilted disc lies; none where it turns true."""
    if scenario.tilt is None:
        return ()
    low, high = min(scenario.tilt.turns), max(scenario.tilt.turns)
    width = (high - low) / 2.0 or 1.0
    return (
        Channel("tilt_cosine", "", 0.0, 1.0, 0.0, "of m theta_1 + phi, by which N_1 is larger"),
        Channel("tilt_sine", "", 0.0, 1.0, 0.0, "of m theta_1 + phi"),
        Channel("tilt_turns", "", (low + high) / 2.0, width, 0.0, "m, how often N_1 varies as disc 1 turns once"),
    )


def _differing(bank: RigBank) -> tuple[str, ...]:
    """The parameters in which a rig of a bank's fleet differs from the nominal one."""
    names = (item.name for item in fields(Rig))
    return tuple(
        name for name in names if any(getattr(rig, name) != getattr(bank.nominal, name) for rig in bank.members.rigs)
    )


def _differences(rigs: tuple[Rig, ...], nominal: Rig, parameters: tuple[str, ...]) -> FloatArray:
    """By how much rigs differ from the nominal one; shape (rigs, parameters)."""
    table = np.array([[getattr(rig, name) for name in parameters] for rig in (*rigs, nominal)], dtype=float)
    table = table.reshape(len(rigs) + 1, -1)
    known = {item.name: item.metadata["allowed"] for item in fields(Rig)}
    positive = np.array([known[name] == POSITIVE for name in parameters], dtype=bool)
    ratios = np.log(np.where(positive, table, 1.0))
    seen = np.where(positive, ratios, table)
    return np.asarray(seen[:-1] - seen[-1])
