"""A record: what was measured on a rig over time, in SI units, as every fit and every score takes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.parameters import refuse

SPEEDS = ("bit_speed", "collar_speed", "top_speed")
"""The speeds that a record may hold, rad/s: of disc 1, disc 2 and the motor's output."""


@dataclass(frozen=True, eq=False)
class Record:
    """A measured run: `time` (n,) in s, ascending from 0, and `signals` by name, each (n,), NaN where masked.

    `source` is the file, and `digest` its SHA-256, both empty where there is none; `speed_reference` (rad/s) and
    `normal_force` (N) are (n,), or None where they were not recorded. `notes` tell how the file was read; `begin` (s)
    is t = 0 on the file's own clock, 0 where that is a date or the time of a day.

    Signals are `bit_speed`, `collar_speed`, `top_speed` (rad/s), `current` (A), `voltage` (V) and
    `torque_into_string` (N m), as far as they were measured.
    """

    source: str  # the file, as it was named
    digest: str  # its SHA-256, in hexadecimal digits
    time: FloatArray
    signals: Mapping[str, FloatArray]
    speed_reference: FloatArray | None = None  # (n,), rad/s
    normal_force: FloatArray | None = None  # (n,), N
    notes: tuple[str, ...] = field(default=())  # what was read as what, left out, masked, sorted and dropped
    begin: float = 0.0  # s: t = 0 on the file's own clock; 0 where that is a date or the time of a day

    @property
    def speeds(self) -> dict[str, FloatArray]:
        """Those of its signals that are speeds, by name."""
        return {name: self.signals[name] for name in SPEEDS if name in self.signals}

    @property
    def sample_period(self) -> float:
        """The median time between samples, s."""
        return float(np.median(np.diff(self.time)))

    def schedule(self, values: FloatArray | None) -> list[tuple[float, float]] | None:
        """`speed_reference` or `normal_force` as `simulate` takes it: (time in s, value) from each change on, from 0 s.

        `values` are either of them.

        None where it was not recorded.
        """
        if values is None:
            return None
        changes = np.concatenate([[0], np.flatnonzero(np.diff(values)) + 1])
        times = np.concatenate([[0.0], self.time[changes[1:]]])
        return list(zip(times.tolist(), values[changes].tolist(), strict=True))

    def since(self, start_time: float) -> Record:
        """The record from `start_time` on (s, on the file's own clock), which becomes t = 0; earlier samples go.

        Raises `ValueError` where fewer than 2 samples are left.
        """
        earliest, latest = self.begin, self.begin + float(self.time[-2])
        if not earliest <= start_time <= latest:
            raise refuse(self.source, "start_time", start_time, "s", f">= {earliest:g} and <= {latest:g}")
        shift = start_time - self.begin
        kept = self.time >= shift

        def cut(values: FloatArray | None) -> FloatArray | None:
            return None if values is None else values[kept]

        return replace(
            self,
            time=self.time[kept] - shift,
            signals={name: values[kept] for name, values in self.signals.items()},
            speed_reference=cut(self.speed_reference),
            normal_force=cut(self.normal_force),
            begin=start_time,
        )
