"""One client at its websocket: what comes is counted, measured and read, what goes is the newest there is."""

from __future__ import annotations

import asyncio
import re
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import NoReturn

import anyio
from starlette.websockets import WebSocket, WebSocketDisconnect

from drillrig_env.env.recorded import Recorded
from drillrig_env.room import protocol
from drillrig_env.room.frames import frame
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.limits import Bucket, Limits
from drillrig_env.room.session import Session
from drillrig_env.room.setting import Setting
from drillrig_env.room.stock import Stock
from drillrig_env.room.strangers import said
from drillrig_env.room.view import welcome
from drillrig_env.room.worker import Worker

REFUSED, TOO_BIG, TOO_MANY = 1008, 1009, 1013
"""Codes with which a websocket is closed: against the rules, too long a message, come again later."""

_REASON = 80
"""Characters of a reason, at most: no more than 123 bytes are sent."""

_REPLAY = re.compile(r'\s*\{\s*"do"\s*:\s*"replay"')


@dataclass(frozen=True)
class Beginning:
    """What a room begins with: a setting or a recorded run, and a story and the lecture mode, if any."""

    setting: Setting
    recorded: Recorded | None = None
    story: str | None = None
    full_screen: bool = False


class SentAway(Exception):  # noqa: N818  # no mistake of the program
    """The client goes, with a code and a reason."""

    def __init__(self, code: int, reason: str) -> None:
        super().__init__(reason)
        self.code, self.reason = code, reason


class Client:
    """A client that has been let in, until it goes or is sent away."""

    def __init__(self, websocket: WebSocket, stock: Stock, beginning: Beginning, limits: Limits) -> None:
        self._websocket, self._stock, self._beginning, self._limits = websocket, stock, beginning, limits
        self._bucket, self._mistakes = Bucket(limits.messages, limits.burst), 0

    async def serve(self) -> None:
        """Begin a room with the first message, and keep it until the end."""
        await self._websocket.accept()
        begin = {"story": self._beginning.story, "full_screen": self._beginning.full_screen}
        await self._websocket.send_text(welcome(self._stock, begin))
        worker = Worker()
        try:
            await self._play(await self._begin(worker))
        except WebSocketDisconnect:
            return
        except SentAway as end:
            with suppress(RuntimeError, WebSocketDisconnect):
                await self._websocket.close(end.code, end.reason)
        finally:
            worker.close()

    async def _play(self, session: Session) -> None:
        """Let the clock go, and do what is asked for, until the client goes or is sent away."""
        ends: list[Exception] = []
        async with anyio.create_task_group() as group:
            group.start_soon(session.run)
            group.start_soon(session.charts.draw)
            group.start_soon(self._send, session)
            try:
                await self._receive(session)
            except (SentAway, WebSocketDisconnect) as end:
                ends.append(end)
            group.cancel_scope.cancel()
        raise ends[0]

    async def _begin(self, worker: Worker) -> Session:
        """The room that the first message asks for; where it cannot be had, the one that there is otherwise."""
        while True:
            request = await self._next(self._limits.first)
            if isinstance(request, protocol.Begin):
                break
            await self._refuse("", "control room: the first message must be begin")
        if request.version != protocol.VERSION:
            raise SentAway(
                REFUSED, f"this server speaks version {protocol.VERSION} of the protocol: load the page again"
            )
        own = self._beginning
        try:
            lanes = await worker.do(partial(Lanes, own.setting.changed(request.setting), self._stock))
        except Exception as error:  # a stranger's policy may raise anything
            await self._refuse("link", said(error))
            try:
                lanes = await worker.do(partial(Lanes, own.setting, self._stock))
            except Exception as fault:
                raise SentAway(REFUSED, said(fault)[:_REASON]) from fault
        session = Session(self._stock, lanes, worker)
        if own.recorded is not None and not request.setting:
            await session.replay(own.recorded)
        if own.story is not None and not request.setting:
            await session.do(protocol.Tell(name=own.story))
        session.say_all()
        return session

    async def _receive(self, session: Session) -> NoReturn:
        while True:
            await session.do(await self._next(self._limits.idle))

    async def _send(self, session: Session) -> None:
        """Send what there is, as fast as the client takes it, until it has gone, which `_receive` is told as well."""
        with suppress(WebSocketDisconnect, RuntimeError):
            while True:
                texts, steps, gap = await session.outbox.take()
                content = frame(session.run_number, session.lanes.period, steps, gap) if steps else b""
                for text in texts:
                    await self._websocket.send_text(text)
                if content:
                    await self._websocket.send_bytes(content)

    async def _next(self, patience: float) -> protocol.Request:
        """The next message. `SentAway` for a client that says nothing, too much or too often, or no messages."""
        while True:
            try:
                event = await asyncio.wait_for(self._websocket.receive(), patience)
            except TimeoutError as error:
                raise SentAway(REFUSED, f"nothing was heard for {patience:g} s: load the page again") from error
            if event["type"] == "websocket.disconnect":
                raise WebSocketDisconnect(event.get("code", 1000))
            if not self._bucket.take():
                raise SentAway(REFUSED, f"more than {self._limits.messages:g} messages a second")
            try:
                return self._read(event.get("text"))
            except ValueError as error:
                self._mistakes += 1
                if self._mistakes > self._limits.mistakes:
                    raise SentAway(REFUSED, "too many messages that are none of the protocol") from error
                await self._refuse("", str(error))

    def _read(self, text: str | None) -> protocol.Request:
        if text is None:
            raise ValueError("control room: messages are text, not bytes")
        most = self._limits.run_bytes if _REPLAY.match(text) else self._limits.message_bytes
        if len(text.encode("utf-8", "surrogatepass")) > most:
            raise SentAway(TOO_BIG, f"a message longer than {most} bytes")
        return protocol.read(text)

    async def _refuse(self, field: str, sentence: str) -> None:
        await self._websocket.send_text(protocol.write("refused", field=field, sentence=sentence))
