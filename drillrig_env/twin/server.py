"""The rig behind a line: clients watch it over TCP, and one of them may have it."""

from __future__ import annotations

import asyncio
import hmac
import socket
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from drillrig_env.deploy.checks import last_number
from drillrig_env.deploy.line import LONGEST, VERSION, BadLine, decode, encode
from drillrig_env.twin.greeting import greeting
from drillrig_env.twin.pace import Pace

_MOST_CLIENTS = 16
_HELLO_TIME = 5.0  # s of the system's time, for a client to say who it is
_UNDERWAY = 65_536  # bytes that the system may hold on their way to a client
_MOST_UNREAD = 65_536  # and that may wait here for one that does not read
_WORDS = ("arm", "command", "release", "until")


class LineServer:
    """Serves the station of `pace`, which runs beside it. With a `token` every client must have it."""

    def __init__(self, pace: Pace, token: str = "") -> None:
        self.station, self.pace = pace.station, pace
        pace.receivers.append(self.deliver)
        self._token = token
        self._clients: dict[asyncio.StreamWriter, bool] = {}  # whether each has been greeted

    async def listen(self, host: str, port: int) -> asyncio.Server:
        """Begin to serve; `OSError` where the port cannot be had. Port 0 is any that is free."""
        return await asyncio.start_server(self._serve, host, port, limit=LONGEST)

    def deliver(self, message: Mapping[str, Any]) -> None:
        """Send measurements to every client; one that has not read for long is left."""
        line = encode(message)
        for writer, greeted in list(self._clients.items()):
            if greeted and writer.transport.get_write_buffer_size() > _MOST_UNREAD:
                self._leave(writer)
            elif greeted:
                writer.write(line)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """One client, from its first line to its last."""
        self._clients[writer] = False
        writer.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _UNDERWAY)
        try:
            if len(self._clients) > _MOST_CLIENTS:
                raise BadLine(f"there are {_MOST_CLIENTS} clients already")
            self._greet(writer, await asyncio.wait_for(reader.readline(), _HELLO_TIME))
            while line := await reader.readline():
                await self._answer(writer, decode(line))
        except BadLine as error:
            self._tell(writer, {"refused": str(error)})
        except (ValueError, TimeoutError) as error:  # asyncio's own for a line that is too long
            told = f"no line within {_HELLO_TIME:g} s" if isinstance(error, TimeoutError) else f"{LONGEST} bytes a line"
            self._tell(writer, {"refused": f"{told}; allowed: lines of the protocol"})
        except (OSError, asyncio.CancelledError):
            pass  # it has gone, or the twin ends
        finally:
            self._leave(writer)

    def _greet(self, writer: asyncio.StreamWriter, line: bytes) -> None:
        """Take a client in. `BadLine` for one that does not say hello, or has not the token."""
        hello = decode(line)
        if "hello" not in hello or hello.get("version") != VERSION:
            raise BadLine(f'no hello of version {VERSION}; begin with {{"hello": "my name", "version": {VERSION}}}')
        token = hello.get("token", "")
        known = isinstance(token, str) and hmac.compare_digest(token.encode("utf-8", "replace"), self._token.encode())
        if not known:
            raise BadLine("the token is not this rig's")
        self._tell(writer, greeting(self.pace))
        self._clients[writer] = True

    async def _answer(self, writer: asyncio.StreamWriter, message: Mapping[str, Any]) -> None:
        """Do what a client asks for. `BadLine` for what it may not ask for."""
        word = next((word for word in _WORDS if word in message), None)
        if word in ("arm", "release") and message[word] is not True:
            raise BadLine(f"{word} = {message[word]!r} is not allowed; allowed: true")
        try:
            if word == "command":
                self.station.command(writer, message["command"])
            elif word == "arm":
                self.station.arm(writer)
                self._tell(writer, {"armed": self.station.rig.reference, "time": self.station.time})
            elif word == "release":
                self.station.release(writer)
            elif word == "until":
                await self._until(writer, message)
            else:
                raise BadLine(f"{', '.join(map(str, message)) or 'nothing'} is not known; allowed: {', '.join(_WORDS)}")
        except ValueError as error:
            raise BadLine(str(error)) from error

    async def _until(self, writer: asyncio.StreamWriter, message: Mapping[str, Any]) -> None:
        until = message["until"]
        if last_number(until) is None:
            raise BadLine(f"until = {until!r} is not allowed; allowed: a time in s")
        now = await self.pace.ask(float(until), message.get("first") is True)
        self._tell(writer, {"now": now})

    def _tell(self, writer: asyncio.StreamWriter, message: Mapping[str, Any]) -> None:
        with suppress(OSError, RuntimeError):
            writer.write(encode(message))

    def _leave(self, writer: asyncio.StreamWriter) -> None:
        """End a connection. A client that had the rig and has not given it back leaves it to the watchdog."""
        if self._clients.pop(writer, None) is not None:
            unread = writer.transport.get_write_buffer_size() > _MOST_UNREAD
            (writer.transport.abort if unread else writer.close)()
