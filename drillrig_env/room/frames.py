"""The binary frames: control steps of both lanes, as docs/room_protocol.md lays them out. Little-endian throughout."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from drillrig_env.course import COLUMNS
from drillrig_env.room.lane import SIGNALS, STEP_VALUES
from drillrig_env.room.lanes import Step
from drillrig_env.room.verdicts import Verdict
from drillrig_env.stepper.ladder import SAMPLES

FRAME, FRAME_VERSION = 0x44, 1  # "D"

_HEADER = struct.Struct("<BBBBHHIIf")
"""Kind, version, lanes, flags, control steps, samples a step, number of the run, first control step, control period."""

HEADER_BYTES = _HEADER.size

GAP = 1
"""Flag: control steps before the first one were left out, since the client was slow."""

FULL, CALM, MITIGATED = 1, 2, 4
"""Flags of a verdict."""

VERDICT_VALUES = ("index", "mean", "calm_since", "stuck", "flags", "channels")


def frame(run: int, period: float, steps: Sequence[Step], gap: bool) -> bytes:
    """A frame with consecutive control steps, at least one, of `period` s."""
    count, last = len(steps), steps[-1].shown
    parts = [_HEADER.pack(FRAME, FRAME_VERSION, len(last), GAP * gap, count, SAMPLES, run, steps[0].number, period)]
    parts.append(np.array([step.given for step in steps], dtype="<f4").tobytes())
    for place, shown in enumerate(last):
        parts.append(_verdict(shown.verdict, len(shown.seen)))
        parts.append(shown.seen.astype("<f4").tobytes())
        parts.append(np.concatenate([step.shown[place].values for step in steps]).astype("<f4").tobytes())
        signals = np.concatenate([step.shown[place].signals for step in steps], axis=1)
        parts.append(signals.astype("<f4").tobytes())
    return b"".join(parts)


def _verdict(verdict: Verdict, channels: int) -> bytes:
    flags = FULL * verdict.full + CALM * verdict.calm + MITIGATED * verdict.mitigated
    since = np.nan if verdict.calm_since is None else verdict.calm_since
    numbers = (verdict.index, verdict.mean, since, verdict.stuck, flags, channels)
    return np.array(numbers, dtype="<f4").tobytes()


def frame_bytes(steps: int, channels: Sequence[int]) -> int:
    """How long a frame of so many control steps is, in which the lanes see so many channels."""
    lane = len(VERDICT_VALUES) + steps * (len(STEP_VALUES) + len(SIGNALS) * SAMPLES)
    return HEADER_BYTES + 4 * (steps * len(COLUMNS) + sum(lane + seen for seen in channels))
