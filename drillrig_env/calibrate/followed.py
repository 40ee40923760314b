"""Whether a fit has found anything: a model that is nowhere near a signal tells nothing of the rig."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drillrig_env.calibrate.fit import Best
from drillrig_env.calibrate.records import SPEEDS, Record
from drillrig_env.calibrate.windows import UNITS

_SHARE, _NOISES = 0.5, 5.0
"""Of a signal's standard deviation and of its noise, more than both of which is no fit."""


class NotFollowedError(ValueError):
    """The best model is nowhere near a record."""


def check_followed(records: Sequence[Record], best: Best) -> None:
    """Raise `NotFollowedError` for the signal that the best model is furthest off, by more than half of its swing.

    A speed swings as the one that swings most: that of a stiff drive hardly does.
    """
    worst, told = 1.0, ""
    for record, windows, noise, residuals in zip(
        records, best.problem.windows, best.problem.noise, best.residuals, strict=True
    ):
        if not len(windows):
            continue
        table = residuals[:, : windows.data[0].size].reshape(windows.data.shape)
        swings = np.nanstd(windows.data, axis=(0, 1))
        speeds = [i for i, name in enumerate(windows.names) if name in SPEEDS]
        swings[speeds] = swings[speeds].max(initial=0.0)
        for i, name in enumerate(windows.names):
            held = np.isfinite(windows.data[..., i])
            off = 1.4826 * float(np.median(np.abs(table[..., i][held]))) * float(noise[i]) if held.any() else 0.0
            far = off / max(_SHARE * swings[i], _NOISES * windows.noise[i])
            if far > worst:
                worst, unit = far, UNITS[name]
                what = f"the best model is off {name} by {off:.2g} {unit}, which swings by {swings[i]:.2g}"
                told = f"{record.source}: {what}"
    if told:
        raise NotFollowedError(
            f"{told}; nothing is found: is a column another one or in another unit, a fixed value wrong, or the rig "
            "that the fit begins with far from yours? More --starts may help there"
        )
