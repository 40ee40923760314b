"""Cycles of stick-slip, measured and by the model: their period, peak, share of time stuck, and swing of the torque.

From the beginning of each window the model runs on freely, as long as several windows; the first whole cycle that was
measured is set beside the model's that begins next to it. Such numbers know nothing of phase, in which runs part that
are otherwise the same. The model's signals get the noise that was measured: peaks and swings of noisy ones are larger.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import nan

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.beside import Beside
from drillrig_env.calibrate.calibration import Calibration
from drillrig_env.calibrate.projection import run_windows
from drillrig_env.calibrate.records import SPEEDS
from drillrig_env.calibrate.records.motion import rises
from drillrig_env.calibrate.windows import UNITS, Windows
from drillrig_env.scales import Scales
from drillrig_env.stepper.finite import NotFiniteError
from drillrig_env.verdict import STUCK_SPEED

_WINDOWS = 8
"""A run goes on for so many windows."""

_SWINGS, _HYSTERESIS = 0.1, 0.5
"""A signal swings whose standard deviation is above such a share of its largest value; it rises through its mean by so
many of them."""

_ALIKE = 0.3
"""Two measured periods, one after the other, differ by less than this share: else it is no cycle, but steps."""

_GAPS = 0.1
"""Most of a cycle that may be missing in a record."""

_NOISES = 4.0
"""The bit is stuck within so many deviations of its speed's noise."""

HEADINGS = ["record", "cycles", "", "measured", "model", "off"]


@dataclass(frozen=True)
class Feature:
    """A number of the cycle, the median over windows: measured and by the model."""

    name: str
    unit: str
    measured: float
    model: float


@dataclass(frozen=True)
class Cycles:
    """The cycles that begin in the windows of a part of a record."""

    source: str
    part: str
    count: int
    features: tuple[Feature, ...]


def cycles(calibration: Calibration, parts: Sequence[Beside]) -> list[Cycles]:
    """The cycles of each part of a record in which there are any; none where the model runs away."""
    found = [_cycles(calibration, one) for one in parts]
    return [one for one in found if one is not None]


def cycle_rows(found: Sequence[Cycles]) -> list[list[str]]:
    """A row of text for each feature, under `HEADINGS`."""
    rows = []
    for one in found:
        for it in one.features:
            share = it.unit == ""
            told = [f"{value:.3f}" if share else f"{value:.4g}" for value in (it.measured, it.model)]
            off = f"{it.model - it.measured:+.3f}" if share else f"{100.0 * (it.model / it.measured - 1.0):+.1f} %"
            name = f"{it.name}, {it.unit}" if it.unit else it.name
            rows.append([one.source, f"{one.count} {one.part}", name, *told, off])
    return rows


def onwards(windows: Windows, count: int) -> Windows:
    """Each window with those that follow it in the record, `count` together, for a longer run from the same start.

    Behind a gap or the record's end nothing is measured.
    """
    whole = windows if windows.whole is None else windows.whole
    places = np.arange(len(whole)) if windows.places is None else windows.places
    chain = places[:, None] + np.arange(count)
    ended = chain >= len(whole)
    chain = np.minimum(chain, len(whole) - 1)
    ended[:, 1:] |= ~whole.follows[chain[:, 1:]]
    ended = np.logical_or.accumulate(ended, axis=1)

    def joined(values: FloatArray) -> FloatArray:
        return np.asarray(values[chain].reshape(len(places), -1, *values.shape[2:]))

    data = np.where(ended[:, :, None, None], nan, whole.data[chain])
    return replace(
        whole,
        times=joined(whole.times),
        lengths=joined(whole.lengths),
        references=joined(whole.references),
        asked=joined(whole.asked),
        forces=joined(whole.forces),
        data=data.reshape(len(places), -1, data.shape[-1]),
        before=windows.before,
        follows=windows.follows,
    )


def _cycles(calibration: Calibration, one: Beside) -> Cycles | None:
    windows = onwards(one.windows, _WINDOWS)
    try:
        states = run_windows(windows, calibration.rig, calibration.friction, one.starts)
    except NotFiniteError:  # a drive that does not turn steadily may run away beyond the windows of the fit
        return None
    shown = windows.shown(calibration.rig, states)
    shown = shown + windows.noise * np.random.default_rng(0).standard_normal(shown.shape)
    stuck = STUCK_SPEED * Scales.of(calibration.rig).speed
    for i in range(len(windows.names)):  # the first signal that shows any
        both = []
        for time, measured, model in zip(np.cumsum(windows.lengths, axis=1), windows.data, shown, strict=True):
            found = _both(measured[:, i], model[:, i])
            if found is not None:
                level, *pair = found
                both.append(
                    [
                        _numbers(windows, time, values, i, cycle, level, stuck)
                        for values, cycle in zip((measured, model), pair, strict=True)
                    ]
                )
        if both:
            features = []
            for name, unit in both[0][0]:
                measured, model = np.median([[it[name, unit] for it in pair] for pair in both], axis=0).tolist()
                features.append(Feature(name, unit, measured, model))
            return Cycles(calibration.records[one.record].source, one.part, len(both), tuple(features))
    return None


def _both(measured: FloatArray, model: FloatArray) -> tuple[float, tuple[int, int], tuple[int, int]] | None:
    """The level that a signal of shape (m,) rises through, and from which place to which its first cycle goes.

    None where it does not swing, what was measured does not come again, or one has no whole cycle.
    """
    known = measured[np.isfinite(measured)]
    if len(known) < 2 or np.std(known) <= _SWINGS * np.abs(known).max():
        return None
    middle, band = float(np.mean(known)), _HYSTERESIS * float(np.std(known))
    first, second = rises(measured, middle, band), rises(model, middle, band)
    if len(first) < 3 or len(second) < 2:
        return None
    lengths = np.diff(first[:3])
    missing = ~np.isfinite(measured[first[0] - 1 : first[1]])
    in_gaps = missing[0] or missing[-1] or np.mean(missing) > _GAPS  # a rise within a gap has no time
    if np.ptp(lengths) > _ALIKE * lengths.max() or in_gaps:
        return None
    k = int(np.argmin(np.abs(second[:-1] - first[0])))
    return middle + band, (int(first[0]), int(first[1])), (int(second[k]), int(second[k + 1]))


def _numbers(
    windows: Windows,
    time: FloatArray,
    values: FloatArray,
    channel: int,
    cycle: tuple[int, int],
    level: float,
    stuck: float,
) -> dict[tuple[str, str], float]:
    """What a cycle is like, by name and unit, of signals (m, channels) at times (m,), measured or the model's.

    The bit is `stuck` below such a speed (rad/s), or where noise does not tell it from standing.
    """
    part, name = values[slice(*cycle)], windows.names[channel]
    begin, end = (_crossing(time, values[:, channel], place, level) for place in cycle)
    found = {("period", "s"): end - begin}
    if name in SPEEDS:
        found[f"peak of {name.replace('_', ' ')}", UNITS[name]] = float(np.nanmax(part[:, channel]))
    if name == "bit_speed":
        speed = np.abs(part[np.isfinite(part[:, channel]), channel])
        found["stuck, share of the period", ""] = float(np.mean(speed < max(stuck, _NOISES * windows.noise[channel])))
    for torque in ("torque_into_string", "current"):
        if torque in windows.names:
            swing = part[:, windows.names.index(torque)]
            if np.isfinite(swing).any():
                found[f"swing of {torque.replace('_', ' ')}", UNITS[torque]] = float(
                    np.nanmax(swing) - np.nanmin(swing)
                )
            break
    return found


def _crossing(time: FloatArray, signal: FloatArray, place: int, level: float) -> float:
    """When a signal comes to a level that it is above at a place: on the line from the sample before it."""
    before, after = signal[place - 1], signal[place]
    back = (after - level) / (after - before) if before < level else 0.0
    return float(time[place] - back * (time[place] - time[place - 1]))
