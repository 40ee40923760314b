"""A record cut into windows, from sample to sample: what goes into the model there, and what was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

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

_JUMP = 0.05
"""Of an input's maximum: less is noise."""

_HELD = 0.2
"""An input that changes in a smaller share of the samples is held in between."""

_NOISY = {"speed_reference": 0.05, "normal_force": 2.0}
"""How far below 0 noise may take an input, as a share of its maximum: of the force, all there is without load."""

_LEAST_STEPS = 20
"""Steps of the shortest window."""


@dataclass(frozen=True, eq=False)
class Windows:
    """n windows of m steps each, of one record; a step goes from a sample to a later one."""

    period: float  # s: the usual length of a step
    sample_period: float  # s
    times: FloatArray  # (n, m), s: the end of each step in the record
    lengths: FloatArray  # (n, m), s
    references: FloatArray  # (n, m), rad/s, the mean over each step, held over it
    asked: FloatArray  # (n, m), rad/s: the reference at the end of each step, which a voltage goes by
    forces: FloatArray  # (n, m), N, the mean over each step
    data: FloatArray  # (n, m, channels): measured at the end of each step, NaN where it was not
    names: tuple[str, ...]  # of the channels
    noise: FloatArray  # (channels,): standard deviation of what is measured
    before: FloatArray  # (n, channels): measured at the beginning of each window
    jumps: FloatArray  # (3, jumps): when (s) the reference of the whole record jumps, from and to what (rad/s)
    follows: npt.NDArray[np.bool_]  # (n,): whether a window begins where the one before it in the record ends
    whole: Windows | None = None  # all of the record, where these are some of them
    places: npt.NDArray[np.int64] | None = None  # (n,): where they are among those

    @classmethod
    def of(cls, record: Record, period: float, length: float) -> Windows:
        """Cut a record into windows of `length` s with steps of at most `period` s, or of one sample.

        Steps begin and end at samples: values between them would be late where currents are fast, and less noisy than
        those measured. No window spans a long gap; what is left over before one and at the end is left out. A signal
        without any sample is left out too, and what noise takes inputs below 0 is 0.
        Raises `ValueError` for a record without speed reference, normal force or signal, or too short for one window.
        """
        references = _input(record, "speed_reference", "rad/s")
        loads = _input(record, "normal_force", "N")
        names = tuple(name for name in CHANNELS if np.isfinite(record.signals.get(name, np.nan)).any())
        if not names:
            raise ValueError(f"{record.source}: no signal has a sample; allowed: at least one of {', '.join(CHANNELS)}")
        stride = max(1, int(period / record.sample_period + 1e-6))
        period = stride * record.sample_period
        steps = max(_LEAST_STEPS, round(length / period))
        jumps = np.flatnonzero(_jumps(references, held=True)) + 1
        changes = _jumps(references) | _jumps(loads)
        gaps = _gaps(np.diff(record.time), changes, 0.1 * steps * period)
        begins, follows = _cut(gaps, len(record.time), stride * steps)
        if not len(begins):
            raise ValueError(
                f"{record.source}: length of the record = {record.time[-1]:g} s is not allowed; allowed: >= "
                f"{steps * period:.3g} s without long gaps, which is one window; is its time in another unit?"
            )
        ends = begins[:, None] + stride * np.arange(1, steps + 1)
        table = np.stack([record.signals[name] for name in names], axis=-1)
        return cls(
            period,
            record.sample_period,
            record.time[ends],
            record.time[ends] - record.time[ends - stride],
            _means(references, record.time, ends, stride),
            references[ends],
            _means(loads, record.time, ends, stride),
            table[ends],
            names,
            np.array([_noise(table[:, i]) for i in range(len(names))]),
            table[begins],
            np.stack([record.time[jumps], references[jumps - 1], references[jumps]]),
            follows,
        )

    def __len__(self) -> int:
        return len(self.data)

    def take(self, places: npt.NDArray[np.int64]) -> Windows:
        """Those at some places, shape (n,), ascending; they keep the `whole` that a model is led along to them."""
        return replace(
            self,
            times=self.times[places],
            lengths=self.lengths[places],
            references=self.references[places],
            asked=self.asked[places],
            forces=self.forces[places],
            data=self.data[places],
            before=self.before[places],
            follows=self.follows[places],
            whole=self if self.whole is None else self.whole,
            places=places if self.places is None else self.places[places],
        )

    def lagging(self, lags: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The references where those of each window come some `lags` (n,) (s) after the logger shows them.

        They are two a step, before and after a jump of the reference in it: both references (rad/s) and how long the
        first one holds (s), of shape (n, m) each.
        """
        begins = self.times - self.lengths
        coming = np.searchsorted(self.jumps[0], begins - lags[:, None] + 1e-9 * self.lengths)
        times, first, second = (np.append(row, np.inf)[coming] for row in self.jumps)
        until = times + lags[:, None] - begins
        inside = until < (1.0 - 1e-9) * self.lengths
        held = np.where(inside, until, self.lengths)
        return held, np.where(inside, first, self.references), np.where(inside, second, self.references)

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


def _jumps(values: FloatArray, held: bool = False) -> npt.NDArray[np.bool_]:
    """Whether an input changes by more than noise does from a sample to the next; by anything where it is `held`.

    It is not held, whatever is asked for, where most samples differ from those before.
    """
    changes = np.abs(np.diff(values))
    least = 0.0 if held and np.mean(changes > 0.0) < _HELD else _JUMP * values.max()
    return np.asarray(changes > least)


def _gaps(distances: FloatArray, changes: npt.NDArray[np.bool_], longest: float) -> npt.NDArray[np.intp]:
    """The samples before which there is a gap that no window may span, of n - 1 distances between samples (s).

    It is longer than `longest` s, or inputs change in it, nobody knows when.
    """
    far = distances > _FAR * np.median(distances)
    return np.flatnonzero(far & (changes | (distances > longest))) + 1


def _cut(gaps: npt.NDArray[np.intp], count: int, size: int) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.bool_]]:
    """The samples at which windows of `size` samples begin between the gaps, and which of them follow another."""
    pieces = [
        np.arange(begin, end - size, size) for begin, end in pairwise([0, *gaps.tolist(), count]) if end - begin > size
    ]
    begins = np.concatenate([np.zeros(0, dtype=np.intp), *pieces])
    return begins, np.concatenate([[False], np.diff(begins) == size])[: len(begins)]


def _means(values: FloatArray, time: FloatArray, ends: npt.NDArray[np.intp], stride: int) -> FloatArray:
    """The means of an input, held from each sample to the next, over `stride` samples before each of the `ends`."""
    if stride == 1:
        return values[ends - 1]
    sums = np.concatenate([[0.0], np.cumsum(values[:-1] * np.diff(time))])
    return np.asarray((sums[ends] - sums[ends - stride]) / (time[ends] - time[ends - stride]))


def _noise(values: FloatArray) -> float:
    """The standard deviation of white noise in samples of a smooth signal, from their fourth differences."""
    held = values[np.isfinite(values)]
    differences = np.abs(np.diff(held, 4))
    spread = 1.4826 * float(np.median(differences)) / np.sqrt(70.0) if len(differences) else 0.0
    return max(spread, 1e-6 * float(np.ptp(held)), 1e-12)
