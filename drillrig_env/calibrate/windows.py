"""A record cut into windows on a grid of times: what goes into the model there, and what was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.records import SPEEDS, Record
from drillrig_env.model import STATE_NAMES, torque_into_string
from drillrig_env.parameters import refuse
from drillrig_env.rig import Rig

CHANNELS = ("bit_speed", "collar_speed", "top_speed", "current", "voltage", "torque_into_string")
_OF_STATE = {name: STATE_NAMES.index(name) for name in CHANNELS if name in STATE_NAMES}
UNITS = {**dict.fromkeys(SPEEDS, "rad/s"), "current": "A", "voltage": "V", "torque_into_string": "N m"}
"""Of the channels."""

_FAR = 2.5
"""Samples more than so many usual distances apart have a gap between them."""

_NOISY = {"speed_reference": 0.05, "normal_force": 2.0}
"""How far below 0 noise may take an input, as a share of its maximum: of the force, all there is without load."""

_LEAST_STEPS = 20
"""Steps of the shortest window."""


@dataclass(frozen=True, eq=False)
class Windows:
    """n windows of m steps of `period` (s) each, of one record."""

    period: float
    references: FloatArray  # (n, m), rad/s, held over each step
    asked: FloatArray  # (n, m), rad/s: the reference at the end of each step, which a voltage goes by
    forces: FloatArray  # (n, m), N
    data: FloatArray  # (n, m, channels): measured at the end of each step, NaN where it was not
    names: tuple[str, ...]  # of the channels
    noise: FloatArray  # (channels,): standard deviation of what is measured
    before: FloatArray  # (n, channels): measured at the beginning of each window
    whole: Windows | None = None  # all of the record, where these are some of them
    places: npt.NDArray[np.int64] | None = None  # (n,): where they are among those

    @classmethod
    def of(cls, record: Record, period: float, length: float) -> Windows:
        """Cut a record into windows of `length` s with steps of `period` s; what is left over at the end is left out.

        Between two samples that are close a line counts; samples in between are passed over: means of them would be
        late where currents are fast. A signal without any sample is left out, and what noise takes inputs below 0 is 0.
        Raises `ValueError` for a record without speed reference, normal force or signal, or too short for one window.
        """
        references = _input(record, "speed_reference", "rad/s")
        loads = _input(record, "normal_force", "N")
        steps = max(_LEAST_STEPS, round(length / period))
        span = float(record.time[-1])
        count = int((span / period + 1e-9) // steps)
        if count < 1:
            raise ValueError(
                f"{record.source}: length of the record = {span:g} s is not allowed; allowed: >= "
                f"{steps * period:.3g} s, which is one window; is its time in another unit?"
            )
        names = tuple(name for name in CHANNELS if np.isfinite(record.signals.get(name, np.nan)).any())
        if not names:
            raise ValueError(f"{record.source}: no signal has a sample; allowed: at least one of {', '.join(CHANNELS)}")
        total = count * steps
        times = period * np.arange(total + 1, dtype=float)
        table = np.stack([_at(times, record.time, record.signals[name]) for name in names], axis=-1)
        held = np.clip(np.searchsorted(record.time, times + 0.5 * period) - 1, 0, None)
        return cls(
            period,
            references[held[:-1]].reshape(count, steps),
            references[held[1:]].reshape(count, steps),
            loads[held[:-1]].reshape(count, steps),
            table[1:].reshape(count, steps, len(names)),
            names,
            np.array([_noise(table[:, i]) for i in range(len(names))]),
            table[:-1:steps],
        )

    def __len__(self) -> int:
        return len(self.data)

    def take(self, places: npt.NDArray[np.int64]) -> Windows:
        """Those at some places, shape (n,), ascending; they keep the `whole` that a model is led along to them."""
        return replace(
            self,
            references=self.references[places],
            asked=self.asked[places],
            forces=self.forces[places],
            data=self.data[places],
            before=self.before[places],
            whole=self if self.whole is None else self.whole,
            places=places if self.places is None else self.places[places],
        )

    def shown(self, rig: Rig, states: FloatArray) -> FloatArray:
        """What the channels show of states of shape (..., m, 7) in these windows, the last axis theirs."""
        columns = []
        for name in self.names:
            if name in _OF_STATE:
                columns.append(states[..., _OF_STATE[name]])
            elif name == "voltage":
                columns.append(rig.k_p * (self.asked - states[..., 4]) + rig.k_i * states[..., 6])
            else:
                columns.append(torque_into_string(rig, states))
        return np.stack(columns, axis=-1)


def _input(record: Record, name: str, unit: str) -> FloatArray:
    """The speed reference or normal force of a record, not below 0. `ValueError` where it is missing or negative."""
    values = getattr(record, name)
    if values is None:
        raise ValueError(f"{record.source}: the {name} is missing; give its column, or its value")
    if not np.isfinite(values).all():
        raise refuse(record.source, name, float(values[np.argmin(np.isfinite(values))]), unit, "finite throughout")
    if -values.min() > _NOISY[name] * values.max():
        allowed = f">= 0 {unit}; a minus before its unit turns a column round"
        raise refuse(record.source, name, float(values.min()), unit, allowed)
    return np.asarray(np.maximum(values, 0.0))


def _at(times: FloatArray, sampled: FloatArray, values: FloatArray) -> FloatArray:
    """Values at some times, on the line between the samples beside each; NaN where one is missing or far."""
    held = np.isfinite(values)
    usual = float(np.median(np.diff(sampled)))
    after = np.clip(np.searchsorted(sampled, times - 1e-6 * usual), 0, len(sampled) - 1)
    before = np.maximum(after - 1, 0)
    on = np.abs(sampled[after] - times) <= 1e-6 * usual
    found = np.interp(times, sampled[held], values[held]) if held.any() else np.full(len(times), np.nan)
    near = held[before] & held[after] & (sampled[after] - sampled[before] <= _FAR * usual)
    return np.asarray(np.where(np.where(on, held[after], near), np.where(on, values[after], found), np.nan))


def _noise(values: FloatArray) -> float:
    """The standard deviation of white noise in samples of a smooth signal, from their fourth differences."""
    held = values[np.isfinite(values)]
    differences = np.abs(np.diff(held, 4))
    spread = 1.4826 * float(np.median(differences)) / np.sqrt(70.0) if len(differences) else 0.0
    return max(spread, 1e-6 * float(np.ptp(held)), 1e-12)
