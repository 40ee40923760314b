"""A policy's file as a controller of one rig: measurements by name in, the speed reference out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TypeAlias

import numpy as np

from drillrig_env.calibrate.records.quantities import factor, unit_of, units_allowed
from drillrig_env.deploy.policy_file import PolicyFile
from drillrig_env.deploy.running import RunningStatistics
from drillrig_env.parameters import closest, refuse

Measurements: TypeAlias = Mapping[str, float | Sequence[float]]
"""Measured values by channel; several of one channel are its samples within the control step, the last one now."""

_KINDS = {"rad/s": "speed", "rad": "angle", "A": "current", "V": "voltage", "N m": "torque"}
REFERENCE, TARGET = "speed_reference", "speed_target"


class Controller:
    """One rig's controller from a shipped policy (`"ppo_surface"`) or a file.

    >>> controller = Controller("z_torque")
    >>> controller.start(reference=2.0, target=3.0, measurements={"top_speed": 2.0, "current": 1.2, "voltage": 2.0,
    ...                                                           "string_torque": 0.3})
    >>> round(controller.step({"top_speed": 2.0, "current": 1.2, "voltage": 2.0, "string_torque": 0.3}), 6)
    2.2

    `units` says of channels, and of `speed_reference` and `speed_target`, in which units they are given, such as
    `{"top_speed": "rpm"}`; all others are in SI units, those of `channels`. Running means and deviations are made here.
    Raises `ValueError` for a policy, a channel or a unit that is not known.
    """

    def __init__(self, policy: str | Path, units: Mapping[str, str] | None = None) -> None:
        self.file = PolicyFile(policy)
        about = self.file.about
        self.name = str(about["name"])
        self.period = float(about["control_period"]["value"])
        self.slew_limit = float(about["slew_limit"]["value"])
        self.highest = float(about[REFERENCE]["high"])
        self.statistics = RunningStatistics(about["statistics"], self.period)
        own = {one["channel"] for one in about["statistics"]}
        shown = {one["name"]: one["unit"] for one in about["channels"] if one["measured"] and one["name"] not in own}
        sources = {one["of"]: next(c["unit"] for c in about["channels"] if c["name"] == one["channel"])
                   for one in about["statistics"]}  # fmt: skip
        self.channels: dict[str, str] = {**shown, **sources}
        self._known = {**self.channels, **dict.fromkeys(own, ""), REFERENCE: "rad/s", TARGET: "rad/s"}
        self.units = dict(units or {})
        self._factors = {name: self._factor(name, unit) for name, unit in self.units.items()}
        self._reference: float | None = None
        self._target = 0.0
        self._begins = True

    def start(self, reference: float, target: float, measurements: Measurements) -> None:
        """Begin from the speed reference as it is, whatever that is: the first step moves on from there.

        `reference` and `target` are in rad/s.

        The first `step` shows the policy what it measures and leaves the running means as they begin: means of a rig
        that has always turned as it does now, unless `measurements` hold them by name (`string_torque_mean`, ...).
        Raises `ValueError` for values that are missing, unknown or not finite.
        """
        self._reference = self._number(REFERENCE, reference)
        self.target = target
        self.statistics.begin(self._read(measurements))
        self.file.reset()
        self._begins = True

    @property
    def target(self) -> float:
        """What the operator wants, in the unit of `speed_target`."""
        return self._target / self._factors.get(TARGET, 1.0)

    @target.setter
    def target(self, target: float) -> None:
        wanted = self._number(TARGET, target)
        if not 0.0 < wanted <= self.highest:
            raise refuse(self.name, TARGET, wanted, "rad/s", f"> 0 and <= {self.highest:g}")
        self._target = wanted

    @property
    def reference(self) -> float:
        """The speed reference that was given last, in the unit of `speed_reference`. `ValueError` before `start`."""
        return self._last / self._factors.get(REFERENCE, 1.0)

    @property
    def _last(self) -> float:
        if self._reference is None:
            raise ValueError(f"{self.name} has not been started; call start(reference, target, measurements) first")
        return self._reference

    def step(self, measurements: Measurements, reference: float | None = None) -> float:
        """The speed reference for the coming control step, from what was measured at the end of the last one.

        `measurements` are values by channel, in the controller's units.

        `reference` is the one that the drive had meanwhile, where that is not the one that was given. What comes moves
        by no more than the slew limit allows, from within or from outside the range of the policy. Raises `ValueError`
        before `start`, and for values that are missing, unknown or not finite.
        """
        held = self._last if reference is None else self._number(REFERENCE, reference)
        measured = self._read(measurements)
        if not self._begins:
            self.statistics.update(measured)
        self._begins = False
        inside = min(max(held, 0.0), self.highest)
        values = {name: samples[-1] for name, samples in measured.items()}
        values = {**values, **self.statistics.values, REFERENCE: inside, TARGET: self._target}
        _, found = self.file.step(values)
        wanted, most = float(found[0]), self.slew_limit * self.period
        if held != inside:  # back into the range no faster than the slew limit
            wanted = min(max(inside, held - most), held + most)
        self._reference = wanted
        return self.reference

    def _read(self, measurements: Measurements) -> dict[str, list[float]]:
        """The samples of every channel, in SI units."""
        for name in measurements:
            if name not in self._known:
                raise ValueError(f"{self.name}: unknown channel {name!r}; {closest(name, self.channels)}")
        for name, unit in self.channels.items():
            if name not in measurements:
                raise ValueError(f"{self.name}: {name} ({unit}) is missing; it wants {self.wants}")
        return {name: self._samples(name, value) for name, value in measurements.items()}

    def _samples(self, name: str, value: float | Sequence[float]) -> list[float]:
        if type(value) is float and isfinite(value):  # the common case, without an array
            return [value * self._factors.get(name, 1.0)]
        try:
            samples = np.asarray(value, dtype=float).reshape(-1)
        except (TypeError, ValueError):
            samples = np.array([np.nan])
        if len(samples) == 0 or not np.all(np.isfinite(samples)):
            raise refuse(self.name, name, value, self._known[name], "a finite number")
        return [sample * self._factors.get(name, 1.0) for sample in samples.tolist()]

    def _number(self, name: str, value: float) -> float:
        return self._samples(name, value)[-1]

    def describe(self) -> str:
        """What it wants and what it expects of the rig, line by line: to be compared before anything turns."""
        about = self.file.about
        sensors, trained = about["sensors"], about["training"]
        drive = ", ".join(f"{name} {value}" for name, value in about["drive"].items())
        rig = ", ".join(f"{name} {value:.4g}" for name, value in about["rig"].items())
        origin = trained.get("law") or f"{trained['algorithm']}, seed {trained['seed']}, {trained['date']}"
        return "\n".join(
            [
                f"{self.name}: {trained['kind']}, {origin}; {self.file.path.name}, SHA-256 {self.file.sha256[:12]}...",
                f"wants each {self.period:g} s: {self.wants}",
                f"gives {REFERENCE}: 0 to {self.highest:g} rad/s, by at most {self.slew_limit:g} rad/s^2",
                f"drive: {drive}",
                f"instruments: {sensors['name']}, {sensors['delay'][0]} to {sensors['delay'][1]} control steps late",
                f"rig: {rig}",
            ]
        )

    @property
    def wants(self) -> str:
        """The channels that it must be given, with their units, in words."""
        return ", ".join(f"{name} ({self.units.get(name, unit)})" for name, unit in self.channels.items())

    def _factor(self, name: str, unit: str) -> float:
        if name not in self._known or not self._known[name]:
            allowed = [*self.channels, REFERENCE, TARGET]
            raise ValueError(f"{self.name}: units of unknown channel {name!r}; {closest(name, allowed)}")
        kind = _KINDS[self._known[name]]
        found = unit_of(kind, unit)
        if found is None:
            raise refuse(self.name, f"unit of {name}", repr(unit), "", units_allowed(kind))
        return factor(kind, found)
