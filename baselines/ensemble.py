"""What measurements tell whoever knows rig and friction: an ensemble of simulated rigs, drawn to what is seen.

A rig is deterministic: told the rig and its friction's law, only the state at the start and the normal force are
unknown. Many simulated rigs, each with a state and a force of its own, are given the speed reference as it really was,
and each measurement draws them towards what it shows, as far as they differ and as it is exact. This is the ensemble
Kalman filter (Evensen, J. Geophys. Res. 99, 1994), in the form that draws no random numbers and takes one channel after
the other (Whitaker & Hamill, Mon. Weather Rev. 130, 2002).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.scenario import LEAST_TARGET, UNIFORMS
from drillrig_env.fleet import Fleet
from drillrig_env.friction import Friction
from drillrig_env.model import STATE_NAMES
from drillrig_env.rig import Rig
from drillrig_env.scales import LARGEST_REFERENCE

MEMBERS = 64
"""Simulated rigs for each real one."""

CHANNELS = (*STATE_NAMES, "voltage", "string_torque", "string_torque_mean", "string_torque_deviation")
"""What can be measured of a member: these are its first numbers."""

FORCE = len(CHANNELS)
"""The place of the logarithm of N_1, behind them."""

SIZE = FORCE + 1
"""Numbers of a member."""

TOLD = ("rig", "mu_s", "mu_k", "v_b")
"""What must be known of a rig."""

_FORCES = (1.0, 45.0)  # N, evenly at first
_STEADY = 0.2  # share of the members that begin in steady rotation; the others stick and slip
_PHASE = 6  # place of the phase of the cycle among the uniform numbers that an episode draws
_LEAST_FORCE, _LARGEST_FORCE = 0.1, 200.0  # N
_FORGOTTEN = 1.002  # by what the members drift apart in a step, so that they never take themselves for certain
_SURPRISE, _WIDEST = 3.0, 3.0  # from what mean squared surprise on they are driven apart, and by what factor at most


class Ensemble:
    """Ensembles of members for any number of rigs: their start, a control step, and what a measurement makes of them.

    `rigs` are those that a rig may be, `nominal` is what drive and sensors take each of them for, `friction` has the
    law by which friction falls. `slew_limit` (rad/s^2) and `period` (s) are those of the environment, and `noise` has
    the standard deviations of the channels that are measured. All are counted in the rig's own scales. `threads` as
    for the batch core.

    An ensemble is an array of shape (n, members, SIZE): the numbers of CHANNELS, and the logarithm of N_1. `told` has
    what TOLD names, shape (n,) each.
    """

    def __init__(
        self,
        rigs: Sequence[Rig],
        nominal: Rig,
        friction: Friction,
        slew_limit: float,
        period: float,
        noise: Mapping[str, float],
        threads: int | None = None,
    ) -> None:
        self.noise = noise
        self._task = {
            "rig": nominal,
            "scenario": {"rigs": Fleet(rigs=tuple(rigs)), "friction": friction},
            "sensors": ("top_speed",),
            "slew_limit": slew_limit,
            "control_period": period,
            "largest_reference": LARGEST_REFERENCE,
            "duration": period,
        }
        self._threads = threads
        self._cores: dict[int, EpisodeBatch] = {}

    def begun(self, told: Mapping[str, FloatArray], reference: FloatArray) -> FloatArray:
        """Ensembles for rigs whose drive is asked for `reference` (rad/s), shape (n,), before anything was measured.

        Their forces are anything, evenly; most stick and slip, each in another phase of its cycle, and some turn
        steadily. Where the drive is asked for no speed they are at rest.
        """
        n = len(reference)
        even = np.arange(MEMBERS) + 0.5
        uniforms = np.full((MEMBERS, UNIFORMS), 0.5)
        uniforms[:, _PHASE] = even * (np.sqrt(5.0) - 1.0) / 2.0 % 1.0
        turning = np.where(even * np.sqrt(2.0) % 1.0 < _STEADY, "steady", "stick_slip")
        start = np.where(reference[:, None] < LEAST_TARGET, "rest", turning)
        core = self._core(n * MEMBERS)
        pins = {name: np.repeat(told[name], MEMBERS) for name in TOLD} | {
            "rig": np.repeat(told["rig"].astype(int), MEMBERS),
            "speed_target": np.repeat(np.clip(reference, LEAST_TARGET, LARGEST_REFERENCE), MEMBERS),
            "normal_force": np.tile(_FORCES[0] + (_FORCES[1] - _FORCES[0]) * even / MEMBERS, n),
            "start": start.ravel().tolist(),
            "load_steps": [],
        }
        core.reset(np.arange(n * MEMBERS), np.tile(uniforms, (n, 1)), pins)
        return _members_of(core.episodes, n)

    def stepped(self, told: Mapping[str, FloatArray], members: FloatArray, reference: FloatArray) -> FloatArray:
        """Ensembles of any number of members after a control step at `reference` (rad/s), shape (n,)."""
        n, count = members.shape[:2]
        core = self._core(n * count)
        episodes, rows = core.episodes, members.reshape(n * count, SIZE)
        states = len(STATE_NAMES)
        episodes["state"][:, :states] = rows[:, :states]
        episodes["normal_force"] = np.exp(rows[:, FORCE])
        for name in TOLD:
            episodes[name] = np.repeat(told[name], count)
        episodes["torque_mean"], episodes["torque_variance"] = rows[:, FORCE - 2], rows[:, FORCE - 1] ** 2
        episodes["speed_reference"] = np.repeat(reference, count)
        episodes["speed_target"] = 1.0
        episodes["load_times"] = episodes["target_time"] = np.inf
        episodes["step"] = 0
        core.step(np.zeros((n * count, 1), dtype=np.float32))
        return _members_of(episodes, n)

    def drawn_to(self, measured: Mapping[str, FloatArray], members: FloatArray) -> FloatArray:
        """Ensembles after a measurement: `measured` has a value for each rig by channel, shape (n,) each.

        Where it is a surprise to all members alike, as after a load step, they are driven apart first.
        """
        mean = members.mean(axis=1)
        apart = members - mean[:, None]
        places = [(name, CHANNELS.index(name), noise) for name, noise in self.noise.items()]
        surprise = np.zeros(len(mean))
        for name, k, noise in places:
            surprise += (measured[name] - mean[:, k]) ** 2 / (_variance(apart[:, :, k]) + noise**2)
        surprise /= len(places)
        apart *= (_FORGOTTEN * np.sqrt(np.clip(surprise / _SURPRISE, 1.0, _WIDEST**2)))[:, None, None]
        for name, k, noise in places:
            own = apart[:, :, k].copy()
            total = _variance(own) + noise**2
            gain = np.einsum("npk,np->nk", apart, own) / ((own.shape[1] - 1) * total[:, None])
            mean += gain * (measured[name] - mean[:, k])[:, None]
            share = 1.0 / (1.0 + noise / np.sqrt(total))
            apart -= own[:, :, None] * (share[:, None] * gain)[:, None]
        drawn = mean[:, None] + apart
        drawn[:, :, FORCE] = np.clip(drawn[:, :, FORCE], np.log(_LEAST_FORCE), np.log(_LARGEST_FORCE))
        drawn[:, :, FORCE - 1] = np.maximum(drawn[:, :, FORCE - 1], 0.0)
        return np.asarray(drawn)

    def _core(self, episodes: int) -> EpisodeBatch:
        """A batch core for so many members; the last few sizes are kept."""
        if episodes not in self._cores:
            while len(self._cores) >= 8:
                del self._cores[next(iter(self._cores))]
            self._cores[episodes] = EpisodeBatch(episodes, self._task, threads=self._threads)
        return self._cores[episodes]


def _members_of(episodes: np.ndarray, n: int) -> FloatArray:
    """The members that records of the batch core hold, for n rigs; shape (n, members, SIZE)."""
    columns = [*episodes["state"][:, : len(STATE_NAMES)].T]
    columns += [episodes[name] for name in ("voltage", "string_torque", "torque_mean")]
    columns += [np.sqrt(episodes["torque_variance"]), np.log(episodes["normal_force"])]
    return np.stack(columns, axis=-1).reshape(n, -1, SIZE)


def _variance(apart: FloatArray) -> FloatArray:
    """The variance of members whose distances from their mean are `apart`, shape (n, members); shape (n,)."""
    return np.asarray((apart**2).sum(axis=1) / (apart.shape[1] - 1))
