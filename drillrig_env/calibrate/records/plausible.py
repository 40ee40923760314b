"""Whether a record can be what it is read as: long enough, moving, sampled well, and in units that fit a rig."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.records.columns import Reading
from drillrig_env.calibrate.records.motion import is_aliased, period_of
from drillrig_env.calibrate.records.quantities import QUANTITIES
from drillrig_env.calibrate.records.record import Record

_FEWEST = 8  # samples
_SLOWEST, _LONGEST, _SHORTEST = 1000.0, 60.0, 0.02  # s: of a period of stick-slip, at any sampling, and at 1 s and more
_SMOOTH = 15.0  # samples; what comes back sooner may be noise
_DENSEST, _RARE = 1e-6, 1.0  # s between samples; from the latter on, seconds may be milliseconds
_FASTEST = 60.0  # rad/s, 570 rpm: no bit, where no unit is written
_STILL, _TURN = 0.1, 0.5  # rad/s and rad: slower, and less in all, is noise
_TWIST = 100.0  # rad: no string winds up by more
_RPM, _DEGREES = 60.0 / (2.0 * pi), 180.0 / pi
_NEAR = 0.2  # share by which a ratio may miss that of two units
_IMPOSSIBLE = 4.0  # times the reference; no mean speed is so large


def check_length(record: Record) -> None:
    """Raise `ValueError` for a record of too few samples."""
    if len(record.time) < _FEWEST:
        raise ValueError(
            f"{record.source}: {len(record.time)} samples over {record.time[-1]:g} s are too few; "
            f"allowed: >= {_FEWEST}, and some periods of stick-slip to learn anything"
        )


def check_motion(record: Record) -> None:
    """Raise `ValueError` for a record in which no disc turns, or every speed is one number."""
    span = f"0 to {record.time[-1]:g} s"
    names = " and ".join(record.speeds)
    if all(_fastest(speed) < _STILL and abs(_turned(record.time, speed)) < _TURN for speed in record.speeds.values()):
        peak = max(_fastest(speed) for speed in record.speeds.values())
        raise ValueError(
            f"{record.source}: no motion in {names} from {span}, at most {peak:.2g} rad/s; allowed: a rig that turns "
            "(is it another column, or another unit?)"
        )
    if all(np.nanmin(speed) == np.nanmax(speed) for speed in record.speeds.values()):
        value = np.nanmax(next(iter(record.speeds.values())))
        raise ValueError(
            f"{record.source}: {names} is constant, {value:g} rad/s from {span}; allowed: measured values, which differ"
        )


def check_clock(record: Record, reading: Reading) -> None:
    """Raise `ValueError` for times whose unit cannot be right, unless the user has told it."""
    column = reading.column.name
    if reading.told or reading.column.values.dtype.kind != "f":
        return
    step, swing = record.sample_period, _period(record)
    told = f'tell the unit: --map "{column}=time:ms", or time:s, time:us'
    short = swing is not None and _SMOOTH * step < swing < _SHORTEST
    if swing is not None and (short or swing > _SLOWEST or (swing > _LONGEST and step >= _RARE)):
        raise ValueError(
            f"{record.source}, column {column}: periods of stick-slip of {swing:.4g} s are not those of a rig; "
            f"allowed: {_SHORTEST:g} to {_LONGEST:g} s; {told}"
        )
    if step < _DENSEST or (step >= _RARE and swing is None and not reading.stated):
        unit = "" if reading.stated else ", and no unit is written"
        raise ValueError(
            f"{record.source}, column {column}: a sample each {step:.3g} s{unit}; "
            f"allowed: {_DENSEST:g} to {_RARE:g} s; {told}"
        )


def check_sampling(record: Record) -> None:
    """Raise `ValueError` for a record with fewer than about four samples in a period of stick-slip."""
    for name, speed in record.speeds.items():
        if is_aliased(speed):
            raise ValueError(
                f"{record.source}: {name} swings from one sample to the next, {record.sample_period:.3g} s later; "
                "allowed: four samples or more in a period of stick-slip; sample more often"
            )


def check_speeds(record: Record, readings: Mapping[str, Reading]) -> None:
    """Raise `ValueError` for speeds that cannot be in the unit that they are read in, alone or beside one another."""
    for name, speed in record.speeds.items():
        reading = readings[name]
        if not reading.stated and (peak := _fastest(speed)) > _FASTEST:
            column, quantity = reading.column.name, reading.quantity
            unit = "rpm" if QUANTITIES[quantity] == "speed" else "deg"
            raise ValueError(
                f"{record.source}, column {column}: {peak:.3g} rad/s, as no unit is written, is too fast for a rig; "
                f'allowed: <= {_FASTEST:g} rad/s; tell the unit: --map "{column}={quantity}:{unit}"'
            )
    together = np.all([np.isfinite(speed) for speed in record.speeds.values()], axis=0)
    if not np.any(together):
        return
    means = {name: float(np.mean(speed[together])) for name, speed in record.speeds.items()}
    ordered = sorted(means, key=lambda name: abs(means[name]))
    slow, fast = ordered[0], ordered[-1]
    apart = abs(means[fast] - means[slow]) * float(record.time[-1])
    opposite = means[fast] * means[slow] < 0.0
    if apart > _TWIST and (opposite or abs(means[fast]) > 2.0 * abs(means[slow])):
        raise ValueError(
            f"{record.source}: in mean {fast} is {means[fast]:.4g} rad/s and {slow} {means[slow]:.4g} rad/s, which "
            f"winds up the string by {apart:.3g} rad; allowed: at most {_TWIST:g} rad; "
            + _likely(means[fast] / means[slow] if means[slow] else np.inf, fast, slow)
        )


def check_reference(record: Record, reference: FloatArray) -> None:
    """Raise `ValueError` where the mean speed is not what a drive with this reference (n,), rad/s, makes of it.

    The second half of the record counts. What stands out are the ratios of two units, and more than four times the
    reference; a drive may well fall short of it.

    >>> import numpy as np
    >>> from drillrig_env.calibrate import Record
    >>> time = np.arange(0.0, 10.0, 0.1)
    >>> record = Record("a run", "", time, {"top_speed": np.full(100, 3.0)})
    >>> check_reference(record, np.full(100, 3.0))
    """
    name = "top_speed" if "top_speed" in record.speeds else next(iter(record.speeds))
    late = record.time >= 0.5 * record.time[-1]
    speed, wanted = float(np.nanmean(record.speeds[name][late])), float(np.mean(reference[late]))
    if not np.isfinite(speed) or wanted <= 0.0:
        return
    ratio = speed / wanted
    mistaken = any(abs(r / of - 1.0) < _NEAR for r in (ratio, 1.0 / ratio if ratio else 0.0) for of in (_RPM, _DEGREES))
    if ratio > _IMPOSSIBLE or mistaken or ratio < -1.0 / _DEGREES:
        raise ValueError(
            f"{record.source}: {name} is {speed:.4g} rad/s in mean, and its reference {wanted:.4g} rad/s; "
            f"allowed: about as fast, or slower; {_likely(ratio, name, 'the speed reference')}"
        )


def _likely(ratio: float, name: str, other: str) -> str:
    """What a ratio of two speeds that should be alike tells of their units."""
    for unit, factor in (("rpm", _RPM), ("deg/s", _DEGREES)):
        if abs(ratio / factor - 1.0) < _NEAR:
            return f"{ratio:.3g} times: is {name} in {unit}?"
        if abs(ratio * factor - 1.0) < _NEAR:
            return f"{ratio:.2g} times: is {other} in {unit}?"
    if ratio < 0.0:
        return 'of opposite sign: turn it round, --map "COLUMN=bit_speed:-rpm"'
    return f"{ratio:.3g} times: is one of them before the gear, or in another unit?"


def _period(record: Record) -> float | None:
    found = [period for speed in record.speeds.values() if (period := period_of(record.time, speed)) is not None]
    return min(found) if found else None


def _fastest(speed: FloatArray) -> float:
    return float(np.nanpercentile(np.abs(speed), 99.0))


def _turned(time: FloatArray, speed: FloatArray) -> float:
    return float(np.nanmean(speed) * time[-1])
