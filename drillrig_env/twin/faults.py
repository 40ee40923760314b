"""Instruments that fail for a while: to see what a loop makes of it.

| kind | what the instrument shows |
|---|---|
| missing | nothing |
| frozen | what it showed when the fault began |
| wild | a number that cannot be, `_WILD` times what it is and one more |
| slow | what was 0.5 s before, and that it is so old |
| drifting | what it is and 5 % of that more each second: a lie that can be believed |
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from drillrig_env.parameters import NOT_NEGATIVE, checked, closest, refuse

KINDS = ("missing", "frozen", "wild", "slow", "drifting")
_WILD, _SLOW, _DRIFT = 1000.0, 0.5, 0.05  # times, s, per s


@dataclass(frozen=True)
class Fault:
    """What is wrong with a `channel`, from a time `begin` to `end` (s)."""

    channel: str
    kind: str
    begin: float
    end: float

    @classmethod
    def parse(cls, text: str) -> Fault:
        """A fault as a command line has it, `current:frozen:20:30`. `ValueError` for what is not allowed."""
        parts = text.split(":")
        if len(parts) != 4:
            raise refuse("fault", "fault", repr(text), "", "channel:kind:from:to, such as current:frozen:20:30")
        channel, kind, *times = parts
        if kind not in KINDS:
            raise ValueError(f"fault: kind {kind!r} is not known; {closest(kind, KINDS)}")
        try:
            begin, end = (float(checked("fault", "time", float(time), "s", NOT_NEGATIVE)) for time in times)
        except ValueError as error:
            raise refuse("fault", "times", ":".join(times), "s", "from:to, two numbers >= 0") from error
        if not begin < end:
            raise refuse("fault", "times", f"{begin:g}:{end:g}", "s", "from < to")
        return cls(channel, kind, begin, end)


@dataclass
class FaultyInstruments:
    """Puts `faults` into measurements that come each control `period` (s). `ValueError` for an unknown channel."""

    faults: Sequence[Fault]
    channels: Sequence[str]
    period: float
    _frozen: dict[Fault, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for fault in self.faults:
            if fault.channel not in self.channels:
                raise ValueError(f"fault: unknown channel {fault.channel!r}; {closest(fault.channel, self.channels)}")
        self._earlier: deque[Mapping[str, Any]] = deque(maxlen=max(1, round(_SLOW / self.period)) + 1)

    def show(self, measured: Mapping[str, Any], time: float) -> tuple[dict[str, Any], dict[str, float]]:
        """What the instruments show at a time (s), and the ages (s) of what is old; to be asked once a period."""
        shown, ages = dict(measured), dict[str, float]()
        self._earlier.append(measured)
        for fault in self.faults:
            if not fault.begin <= time < fault.end:
                continue
            name, true = fault.channel, measured[fault.channel]
            if fault.kind == "missing":
                del shown[name]
            elif fault.kind == "frozen":
                shown[name] = self._frozen.setdefault(fault, true)
            elif fault.kind == "wild":
                shown[name] = _times(true, _WILD, 1.0)
            elif fault.kind == "drifting":
                shown[name] = _times(true, 1.0 + _DRIFT * (time - fault.begin))
            else:
                shown[name] = self._earlier[0][name]
                ages[name] = (len(self._earlier) - 1) * self.period
        return shown, ages


def _times(value: Any, factor: float, more: float = 0.0) -> Any:
    return [_times(one, factor, more) for one in value] if isinstance(value, list) else value * factor + more
