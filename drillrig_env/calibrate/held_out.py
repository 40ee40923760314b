"""Windows that a fit does not see: what it is judged by afterwards, and what laws of friction are chosen by."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drillrig_env.allowed import Allowed
from drillrig_env.calibrate.spread import LEAST_WINDOWS
from drillrig_env.calibrate.windows import Windows

HELD_OUT = 0.2
"""Share of the windows of each record that is held out."""

SHARE = Allowed(0.0, 0.5)
"""What a share may be."""


def split(windows: Sequence[Windows], share: float = HELD_OUT) -> tuple[list[Windows], list[Windows]]:
    """The windows of each record that are fitted, and those that are held out: a `share` of them, evenly spread.

    Of a record with n windows floor(share n) are held out, always the same ones, so none of one that is short; fewer
    of the longest where less than `LEAST_WINDOWS` would be left to fit. Both lists are as long as `windows`; where
    nothing is held out of a record, its `Windows` there are empty.
    """
    counts = np.array([int(share * len(one) + 1e-9) for one in windows])
    total = sum(map(len, windows))
    while counts.any() and total - counts.sum() < LEAST_WINDOWS:
        counts[np.argmax(counts)] -= 1
    fitted, held = [], []
    for one, count in zip(windows, counts, strict=True):
        out = np.isin(np.arange(len(one)), ((np.arange(count) + 0.5) * len(one) / max(count, 1)).astype(int))
        fitted.append(one.take(np.flatnonzero(~out)) if count else one)
        held.append(one.take(np.flatnonzero(out)))
    return fitted, held
