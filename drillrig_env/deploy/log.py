"""The log of a run: a CSV file that `read_record` reads as a record of the rig, and that can be replayed.

The first line is a comment with all that a replay needs, as JSON: policy and its digest, limits, how it began. Then a
row a control step; numbers are written so that they are read back to the last bit.

| column | holds |
|---|---|
| `time [s]` | since the start, when the measurements were taken |
| one a channel, such as `top_speed [rad/s]` | what was measured; empty where it was missing or no number |
| `speed_reference [rad/s]` | the reference that the drive has from then on |
| `speed_target [rad/s]` | what the operator wants |
| `command [rad/s]` | what the supervisor gave; in shadow mode nobody follows it |
| `state` | of the supervisor, after this step |
| `told [rad/s]` | the reference that the drive was said to have had, where it was not the last command |
| `operator` | `stop: reason`, `restart` |
| `ages`, `samples` | ages in s, and samples within the control step, as JSON by channel; empty where there are none |
| `events` | what happened in this step, and why |
"""

from __future__ import annotations

import csv
import io
import json
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from errno import ENOSPC
from os import strerror
from pathlib import Path
from typing import Any

from drillrig_env.deploy.checks import last_number
from drillrig_env.deploy.supervisor import Supervisor

_AFTER = ("speed_reference [rad/s]", "speed_target [rad/s]", "command [rad/s]", "state", "told [rad/s]", "operator",
          "ages", "samples", "events")  # fmt: skip

_BEGINNING = ("policy", "file", "sha256", "limits", "time", "reference", "target", "measurements")
_ROOM = 16_384
"""Bytes that must fit on the disk of a log that is to be begun."""


@dataclass(frozen=True)
class Row:
    """One control step of a log; `measured` and `ages` by channel, `operator` as the log has it."""

    time: float
    measured: Mapping[str, Any]
    target: float
    command: float
    told: float | None = None
    operator: str = ""
    ages: Mapping[str, float] = field(default_factory=dict)
    state: str = ""


class Log:
    """Writes the log of a supervisor that has just been started, a row at once; to be used in a `with` block.

    `path` is the file, `supervisor` whose log it is.

    `measurements` are those that it was started with. Raises `OSError` where the file cannot be begun; `failed` says
    why it ended before its time, empty where it has not. `run_loop(..., log=path)` keeps one.
    """

    def __init__(self, path: str | Path, supervisor: Supervisor, measurements: Mapping[str, Any]) -> None:
        self.supervisor, self.path = supervisor, path
        with _named(path):
            self._file = Path(path).open("wb", buffering=0)  # noqa: SIM115  # closed at the end of the block
        self._whole, self.failed = 0, ""
        policy = supervisor.controller.file
        about = {
            "policy": str(policy.about["name"]),
            "file": policy.path.name,
            "sha256": policy.sha256,
            "limits": supervisor.limits.as_dict(),
            "time": supervisor.time,
            "reference": supervisor.reference,
            "target": supervisor.target,
            "measurements": {name: _plain(value) for name, value in measurements.items()},
        }
        self._channels = tuple(supervisor.channels)
        units = [supervisor.controller.channels.get(name, "N m") for name in self._channels]
        names = [f"{name} [{unit}]" for name, unit in zip(self._channels, units, strict=True)]
        self._told = len(supervisor.events.kept)
        try:
            with _named(path):
                self._append(f"# {json.dumps(about)}\n" + _line(["time [s]", *names, *_AFTER]))
        except OSError:
            self._file.close()
            raise

    def __enter__(self) -> Log:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def write(self, row: Row, reference: float) -> None:
        """Write a control step; `reference` (rad/s) is the one that the drive has from now on.

        `row` has what was measured and done.

        Where the file cannot be written, as on a full disk, that is an event, and the log ends there with whole rows.
        """
        if self.failed:
            return
        try:
            self._append(self._row(row, reference))
        except OSError as error:
            self.failed = f"{self.path} cannot be written: {(error.strerror or str(error)).lower()}"
            with suppress(OSError):
                self._file.truncate(self._whole)
            self.supervisor.tell("log", f"{self.failed}; it ends here, the rig is controlled on")

    def _append(self, text: str) -> None:
        """Add whole lines, at once: what was done is told, whatever comes."""
        content = text.encode()
        if self._file.write(content) != len(content):
            raise OSError(ENOSPC, strerror(ENOSPC), str(self.path))
        self._whole += len(content)

    def _row(self, row: Row, reference: float) -> str:
        events = self.supervisor.events.kept[self._told :]
        self._told += len(events)
        samples = {name: _plain(value) for name, value in row.measured.items() if hasattr(value, "__len__")}
        samples = {name: value for name, value in samples.items() if isinstance(value, list)}
        return _line(
            [
                _text(row.time),
                *(_text(last_number(row.measured.get(name))) for name in self._channels),
                _text(reference),
                _text(row.target),
                _text(row.command),
                self.supervisor.state.value,
                _text(row.told),
                " ".join(row.operator.split()),
                json.dumps(dict(row.ages)) if row.ages else "",
                json.dumps(samples) if samples else "",
                "; ".join(f"{event.kind}: {event.reason}" for event in events),
            ]
        )


def check_log(path: str | Path) -> None:
    """Raise `OSError`, naming it, where a log cannot be begun in the file at `path`; to be asked before a rig is armed.

    It leaves a file that is there as it is, and none where there is none.
    """
    path = Path(path)
    with _named(path):
        if path.is_file() or not path.exists():
            probe = path.with_name(f".{secrets.token_hex(8)}")
            try:
                probe.write_bytes(bytes(_ROOM))
            finally:
                probe.unlink(missing_ok=True)
        if path.exists():
            with path.open("ab", buffering=0) as file:
                if not path.is_file():  # a device, to which one line more does nothing
                    file.write(b"\n")


@contextmanager
def _named(path: str | Path) -> Iterator[None]:
    """Say of what fails in the block that it is the log of that path."""
    try:
        yield
    except OSError as error:
        raise type(error)(f"the log {path} cannot be begun: {(error.strerror or str(error)).lower()}") from error


def read_log(path: str | Path) -> tuple[dict[str, Any], Iterator[Row]]:
    """How a log began, and its rows. `ValueError` where it is no log of this kind, or a row is damaged.

    `path` is the file.

    A last row that a crash has cut short is left out.
    """
    with Path(path).open(encoding="utf-8", errors="replace", newline="") as file:
        first, *lines = file.read().split("\n")
    try:
        about = json.loads(first.removeprefix("# "))
        for name in _BEGINNING:
            about[name]
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path} is no log of a controller: its first line does not tell how it began") from error
    return about, _rows(str(path), lines[:-1])


def _rows(source: str, lines: list[str]) -> Iterator[Row]:
    for number, cells in enumerate(csv.DictReader(lines), start=3):
        try:
            names = [name for name in cells if name.endswith("]") and name not in (*_AFTER, "time [s]")]
            measured: dict[str, Any] = {name.partition(" ")[0]: _number(cells, name) for name in names}
            measured |= json.loads(cells["samples"]) if cells["samples"] else {}
            yield Row(
                _there(cells, "time [s]"),
                measured,
                _there(cells, "speed_target [rad/s]"),
                _there(cells, "command [rad/s]"),
                _number(cells, "told [rad/s]"),
                cells["operator"],
                json.loads(cells["ages"]) if cells["ages"] else {},
                cells["state"],
            )
        except KeyError as error:
            raise ValueError(f"{source}: the column {error} is missing") from error
        except (TypeError, ValueError, AttributeError) as error:
            raise ValueError(f"{source}, line {number}: no row of a log: {error}") from error


def _line(cells: list[str]) -> str:
    """Cells as a line of CSV."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue()


def _text(number: float | None) -> str:
    return "" if number is None else repr(float(number))


def _number(cells: Mapping[str, Any], name: str) -> float | None:
    cell = cells[name]
    if cell is None:
        raise ValueError(f"it ends before {name}")
    try:
        return float(cell) if cell else None
    except ValueError:
        raise ValueError(f"{name} is {cell!r}, which is no number") from None


def _there(cells: Mapping[str, Any], name: str) -> float:
    number = _number(cells, name)
    if number is None:
        raise ValueError(f"{name} is empty")
    return number


def _plain(value: Any) -> Any:
    """A value as JSON holds it: a number, a list of them, or null."""
    if last_number(value) is None:
        return None
    return [float(one) for one in value] if hasattr(value, "__len__") else float(value)
