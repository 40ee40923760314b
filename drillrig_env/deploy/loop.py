"""The loop: measure, decide, command, at every control period; how punctual it is, is measured.

rig = MyRig()  # measure() -> values by channel; command(speed_reference)
supervisor = Supervisor("lqg", Limits(highest_reference=6.0))
timing = run_loop(supervisor, rig, reference=2.0, target=3.0, steps=600, log="run.csv")
print(timing)
"""

from __future__ import annotations

import gc
import time as system
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from drillrig_env.allowed import COUNT
from drillrig_env.deploy.log import Log, Row, check_log
from drillrig_env.deploy.supervisor import Supervisor
from drillrig_env.parameters import checked

_KEPT = 100_000  # steps
_SHORTEST = 0.5  # control periods between two steps
_REHEARSAL = 0.004  # s before the beat


class Hardware(Protocol):
    """What a rig offers to the loop; with `ages()` it also says how old (s) each value is, by channel."""

    def measure(self) -> Mapping[str, Any]:
        """The measurements of now, by channel, in SI units; what is missing is left out or None."""

    def command(self, speed_reference: float) -> None:
        """Give the drive a speed reference (rad/s). `speed_reference` holds until the next command."""


@dataclass(frozen=True)
class Operator:
    """What the operator asks for in a control step: a stop with its reason, a restart, another target (rad/s).

    With `leave` the loop ends before this step, with the drive as it is.
    """

    stop: str = ""
    restart: bool = False
    target: float | None = None
    leave: bool = False


@dataclass
class Timing:
    """How punctual a loop was: how late each control step began, how long it took to decide, in s; beats left out.

    `late` and `took` have these, `missed` is the number of beats left out.

    Of a long run it knows the last 100,000 steps.
    """

    late: deque[float] = field(default_factory=lambda: deque(maxlen=_KEPT))
    took: deque[float] = field(default_factory=lambda: deque(maxlen=_KEPT))
    missed: int = 0

    def percentile(self, share: float) -> tuple[float, float]:
        """Lateness and length (s) that `share` (%) of the steps do not exceed. `ValueError` before the first step."""
        if not self.took:
            raise ValueError("Timing: no control step has been done")
        return float(np.percentile(self.late, share)), float(np.percentile(self.took, share))

    def __str__(self) -> str:
        if not self.took:
            return "no control step"
        rows = [
            f"{name}: {1e3 * late:.3f} ms late, {1e3 * took:.3f} ms long"
            for name, (late, took) in (
                ("median", self.percentile(50.0)),
                ("99 %", self.percentile(99.0)),
                ("worst", self.percentile(100.0)),
            )
        ]
        return "\n".join([f"{len(self.took)} control steps, {self.missed} missed", *rows])


def run_loop(
    supervisor: Supervisor,
    rig: Hardware,
    *,
    reference: float | Callable[[], float],
    target: float,
    steps: int,
    log: str | Path | None = None,
    operator: Callable[[int], Operator | None] | None = None,
    shadow: Callable[[], float] | None = None,
    rehearse: bool = False,
    clock: Callable[[], float] = system.perf_counter,
    sleep: Callable[[float], None] = system.sleep,
) -> Timing:
    """Run a supervisor on a rig for a number of control `steps`, from the drive's `reference` to a `target` (rad/s).

    `reference` may be what tells it, and is asked when all is ready: a watchdog that is armed by it waits for no more
    than a control period.

    `log` is written as `drillrig_env.deploy.log` says; `operator` is asked in each step, by its number, what it wants.
    With `shadow`, which tells the reference (rad/s) that the drive has from somebody else, nothing is commanded, and
    what would have been is logged. With `rehearse` the policy is computed once just before each beat, for nothing, so
    that the step itself is quick; it is for the system's own time. `clock` and `sleep` are those of the system. A beat
    that has passed, or that comes less than half a period after a late one, is left out, never made up for. When the
    loop ends, whatever ends it, the drive keeps its last reference: a watchdog on the rig's side takes over. Raises
    `ValueError` as `Supervisor.start` does, and `OSError` where the log cannot be begun, before `reference` is asked.
    """
    count = checked("run_loop", "steps", steps, "", COUNT)
    supervisor.controller.target = target  # what is not allowed is refused before a rig is armed
    if log is not None:
        check_log(log)
    period, timing, beat = supervisor.controller.period, Timing(), 0
    with ExitStack() as opened, _no_pauses():
        first = rig.measure()
        has = reference() if callable(reference) else reference
        begin = clock()
        supervisor.start(has, target, first, 0.0)
        book = None if log is None else opened.enter_context(Log(log, supervisor, first))
        now = begin
        for step in range(count):
            beat += 1
            if begin + beat * period - now < _SHORTEST * period:  # it would come too soon after a late one
                timing.missed += 1
                beat += 1
            if rehearse and (ahead := begin + beat * period - _REHEARSAL - clock()) > 0.0:
                sleep(ahead)
                supervisor.controller.file.rehearse()
            if (ahead := begin + beat * period - clock()) > 0.0:
                sleep(ahead)
            now = clock()
            passed = int((now - begin) / period) - beat
            if passed > 0:
                timing.missed += passed
                beat += passed
            measured = rig.measure()
            ages: Mapping[str, float] = rig.ages() if hasattr(rig, "ages") else {}
            wishes = None if operator is None else operator(step)
            if wishes is not None and wishes.leave:
                break
            decides = clock()
            done = serve(supervisor, wishes, measured)
            told = None if shadow is None else shadow()
            given = supervisor.step(measured, now - begin, ages, told)
            timing.took.append(clock() - decides)
            timing.late.append(now - begin - beat * period)
            if shadow is None:
                rig.command(given)
            if book is not None:
                row = Row(now - begin, measured, supervisor.target, given, told, done, ages)
                book.write(row, given if told is None else told)
    return timing


def serve(supervisor: Supervisor, wishes: Operator | None, measured: Mapping[str, Any]) -> str:
    """Do what the operator asks for; what was done, as a log has it. A restart that is not allowed is an event."""
    if wishes is None:
        return ""
    if wishes.target is not None:
        supervisor.target = wishes.target
    if wishes.stop:
        supervisor.stop(wishes.stop)
        return f"stop: {wishes.stop}"
    if wishes.restart:
        try:
            supervisor.restart(measured)
        except ValueError as error:
            supervisor.tell("refused", str(error))
        return "restart"
    return ""


@contextmanager
def _no_pauses() -> Iterator[None]:
    """Without the garbage collection, whose pauses are longer than a step; reference counting goes on."""
    was = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()
