"""A rig at the other end of a line, as the loop wants it: what it measures, how old that is, and where commands go."""

from __future__ import annotations

import select
import socket
import time as system
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from drillrig_env.deploy.connected import ConnectedRig
from drillrig_env.deploy.greeting import Greeting
from drillrig_env.deploy.line import VERSION, Lines, decode, encode
from drillrig_env.deploy.readings import Readings

_SILENT = 5.0  # s of the system's time without an answer


class LineRig(ConnectedRig):
    """A connection to the rig at `address`, "host:port"; it commands nothing until `arm`.

    All times are the rig's, which runs `speed` times as fast as the system's, or only as this side asks it to, where
    it `waits`. `greeting` is what the rig says of itself: channels with units, control period and so on. Raises
    `ConnectionError` where there is no such rig or it refuses the connection, and later where the line breaks or the
    rig's watchdog has taken over; `ValueError` for an address that is none.
    """

    def __init__(self, address: str, token: str = "") -> None:
        self.address, place = address, _host_and_port(address)
        try:
            self._socket = socket.create_connection(place, timeout=_SILENT)
        except OSError as error:
            raise ConnectionError(f"there is no rig at {address}: {error.strerror or error}") from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.setblocking(False)
        self._lines = Lines()
        self._answers: list[dict[str, Any]] = []
        self._readings, self._armed = Readings(address), False
        self._now, self.speed, self.waits = 0.0, 1.0, False
        try:
            self._send({"hello": "drillrig", "version": VERSION, "token": token})
            self.greeting = self._answer("rig")
            said = Greeting.of(self.greeting)
            self.speed, self.waits, self._now, self.period = said.speed, said.waits, said.time, said.period
            self.channels = said.channels
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            self._socket.close()
            raise ConnectionError(f"{address} is no rig of this protocol: {error}") from error
        except BaseException:
            self._socket.close()
            raise
        self._readings = Readings(address, same_clock=self.waits)

    def clock(self) -> float:
        """A time, s of the rig's."""
        return self._now if self.waits else system.perf_counter() * self.speed

    def sleep(self, seconds: float) -> None:
        """Let a time (s of the rig's) pass, taking in what comes meanwhile."""
        self._wait(seconds, first=False)

    def measure(self) -> Mapping[str, Any]:
        """The latest measurements by channel; waited for a little where those of now are just underway."""
        self._take()
        if not self._readings.fresh:
            self._wait(self._patience, first=True)
        return self._readings.seen()

    def first_reference(self) -> float:
        """The speed reference (rad/s) that the drive had when the connection began."""
        return float(self.greeting["reference"])

    def arm(self) -> float:
        """Have the rig from now on; the speed reference (rad/s) of its drive. `ConnectionError` where it refuses."""
        self._send({"arm": True})
        answer = self._answer("armed")
        self._armed, self._readings.armed_at = True, float(answer["time"])
        return float(answer["armed"])

    def command(self, speed_reference: float) -> None:
        """Give the drive a speed reference (rad/s)."""
        self._send({"command": speed_reference})

    def release(self) -> None:
        """Give the rig back, its drive at the reference that it has."""
        if self._armed:
            self._send({"release": True})
        self._armed, self._readings.armed_at = False, None

    def close(self) -> None:
        """End the connection. A rig that has not been given back is left to its watchdog."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_WR)
        self._socket.close()

    def _wait(self, seconds: float, first: bool) -> None:
        """Take in what comes for a time (s of the rig's), or only until the `first` new measurements."""
        if self.waits:
            self._send({"until": self._now + seconds, "first": first})
            self._now = float(self._answer("now")["now"])
            return
        end = self.clock() + seconds
        while not (first and self._readings.fresh) and (left := end - self.clock()) > 0.0:
            if select.select([self._socket], [], [], left / self.speed)[0]:
                self._take()

    def _answer(self, name: str) -> dict[str, Any]:
        """The next message that is an answer, which must have `name`."""
        end = system.monotonic() + _SILENT
        while not self._answers:
            if not select.select([self._socket], [], [], max(0.0, end - system.monotonic()))[0]:
                raise ConnectionError(f"{self.address} does not answer for {_SILENT:g} s")
            self._take()
        answer = self._answers.pop(0)
        if name not in answer:
            raise ConnectionError(f"{self.address} answers with {', '.join(answer) or 'nothing'}, not with {name}")
        return answer

    def _take(self) -> None:
        """Take in all that has come. `ConnectionError` where the line has broken or something is refused."""
        while True:
            try:
                content = self._socket.recv(65_536)
            except BlockingIOError:
                return
            except OSError as error:
                raise ConnectionError(f"the line to {self.address} is broken: {error.strerror}") from error
            if not content:
                raise ConnectionError(f"{self.address} has ended the connection")
            try:
                for line in self._lines.take(content):
                    self._read(decode(line))
            except (TypeError, KeyError, ValueError, OverflowError) as error:
                raise ConnectionError(f"{self.address} is no rig of this protocol: {error}") from error

    def _read(self, message: dict[str, Any]) -> None:
        if "refused" in message:
            raise ConnectionError(f"{self.address} refuses: {message['refused']}")
        if "values" in message:
            self._readings.take(message, self.clock())
        else:
            self._answers.append(message)

    def _send(self, message: Mapping[str, Any]) -> None:
        """Send a line at once; one that the system does not take, as nobody reads, is an error."""
        line = encode(message)
        try:
            sent = self._socket.send(line)
        except OSError as error:
            raise ConnectionError(f"the line to {self.address} is broken: {error.strerror or error}") from error
        if sent < len(line):
            raise ConnectionError(f"{self.address} does not read what it is sent")


def _host_and_port(address: str) -> tuple[str, int]:
    host, _, port = address.rpartition(":")
    digits = port.isascii() and port.isdigit()
    if not host or "/" in host or not digits or not 0 < int(port) < 65_536:
        raise ValueError(
            f"address {address!r} is not allowed; allowed: HOST:PORT, such as 127.0.0.1:5025, or opc.tcp://HOST:PORT"
        )
    return host.strip("[]"), int(port)
