"""Whether records can be of a rig at all like the one that a fit begins with: sampling, signs and units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drillrig_env.calibrate.records import SPEEDS, Record, check_reference
from drillrig_env.calibrate.windows import UNITS, Windows
from drillrig_env.friction import Friction
from drillrig_env.model import steady_state
from drillrig_env.rig import Rig
from drillrig_env.slowest_mode import slowest_period

_FEWEST = 4.0
"""Samples in the rig's slowest period; what has fewer may be a quicker swing that looks like a slower one."""

_UNITS_APART = 100.0
"""How much larger or smaller than the rig has it a signal may be: no fit goes that far, and units are 1,000 apart."""

_BACKWARDS = 0.2
"""Share of its mean size that a signal's mean must be below 0 by, to be turned round."""

_SWINGS = 0.25
"""Standard deviation of a bit speed, as a share of its largest value, from which on it sticks and slips."""


def check_records(records: list[Record], windows: list[Windows], rig: Rig, friction: Friction) -> None:
    """Raise `ValueError` for the first record, cut into `windows`, that cannot be of a rig like this one.

    It has fewer than four samples in the rig's slowest period; or a mean speed that its reference does not go with; or
    current, voltage or torque of the wrong sign, or that another unit explains; or a normal force that does.
    """
    for record, cut in zip(records, windows, strict=True):
        _check_sampling(record, rig)
        assert record.speed_reference is not None
        if record.speeds:
            check_reference(record, np.maximum(record.speed_reference, 0.0))
        _check_signs(record, cut)
        _check_force(record, cut, rig, friction)
        _check_sizes(record, cut, rig, friction)


def _check_sampling(record: Record, rig: Rig) -> None:
    period, step = slowest_period(rig), record.sample_period
    if step * _FEWEST > period:
        raise ValueError(
            f"{record.source}: a sample each {step:.3g} s, {period / step:.2g} in the slowest period of the rig that "
            f"the fit begins with, {period:.3g} s; allowed: {_FEWEST:g} or more; sample more often, or give a --rig "
            "more like yours"
        )


def _check_signs(record: Record, windows: Windows) -> None:
    table = windows.data.reshape(-1, len(windows.names))
    means = dict(zip(windows.names, np.nanmean(table, axis=0), strict=True))
    sizes = dict(zip(windows.names, np.nanmean(np.abs(table), axis=0), strict=True))
    for name, mean in means.items():
        if mean < -_BACKWARDS * sizes[name]:
            raise ValueError(
                f"{record.source}: {name} is {mean:.3g} {UNITS[name]} in mean; allowed: above 0, as the speed "
                "reference is; a minus before its unit turns a column round"
            )


def _check_force(record: Record, windows: Windows, rig: Rig, friction: Friction) -> None:
    """The friction at the bit must be able to swing it as it is seen to swing, and not a hundred times as much."""
    if "bit_speed" not in windows.names:
        return
    speeds = windows.data[:, :, windows.names.index("bit_speed")]
    held = (np.ptp(windows.references, axis=1) == 0.0) & (windows.forces.min(axis=1) > 0.0)
    swings = np.nanstd(speeds[held], axis=1)
    held_swings = swings[swings > _SWINGS * np.nanmax(np.abs(speeds), initial=0.0)]
    if not len(held_swings):
        return
    swing, force = float(np.median(held_swings)), float(windows.forces.max())
    needed = swing * rig.impedance
    there = float(replace(friction, normal_force=force).break_loose(rig))
    if not 1.0 / _UNITS_APART < there / needed < _UNITS_APART:
        raise ValueError(
            f"{record.source}: at a normal_force of {force:.3g} N the friction that the fit begins with is {there:.3g} "
            f"N m, and swings of the bit of {swing:.3g} rad/s take some {needed:.2g} N m; allowed: within a factor of "
            f"{_UNITS_APART:g}; is the force in another unit?"
        )


def _check_sizes(record: Record, windows: Windows, rig: Rig, friction: Friction) -> None:
    """Current, voltage and torque beside what the rig needs to turn at the reference and to speed up to it."""
    reference, force = float(windows.references.max()), float(windows.forces.max())
    if reference <= 0.0:
        return
    state = steady_state(rig, replace(friction, normal_force=force), max(reference, rig.omega_s))
    speeding_up = reference / slowest_period(rig)
    torque = (rig.J_1 + rig.J_2) * speeding_up
    current = (torque + rig.J_3 * speeding_up) / (rig.eta * rig.K_T)
    quick = {"torque_into_string": torque, "current": current, "voltage": rig.R * current}
    asked = replace(windows, asked=np.full_like(windows.asked, reference))
    steady = np.abs(asked.shown(rig, np.broadcast_to(state, (*windows.references.shape, 7)))[0, 0])
    for i, name in enumerate(windows.names):
        if name in SPEEDS:
            continue
        seen, expected = float(np.nanmean(np.abs(windows.data[:, :, i]))), float(steady[i]) + quick[name]
        if not 1.0 / _UNITS_APART < seen / expected < _UNITS_APART:
            unit = UNITS[name]
            raise ValueError(
                f"{record.source}: {name} is {seen:.3g} {unit} in mean, and the rig that the fit begins with takes "
                f"some {expected:.2g} {unit}; allowed: within a factor of {_UNITS_APART:g}; is it another column, or "
                "in another unit? Else give a --rig more like yours"
            )
