"""A twin behind its line, in a thread of this process."""

import asyncio
import selectors
import socket
import threading
import time
from contextlib import AsyncExitStack, contextmanager

from drillrig_env.deploy.events import Events
from drillrig_env.twin.opcua import OpcUaServer
from drillrig_env.twin.pace import Pace
from drillrig_env.twin.rig import SimulatedRig
from drillrig_env.twin.server import LineServer
from drillrig_env.twin.station import Station


class Served:
    """The station that is served, and where."""

    def __init__(self, station, pace, token, opcua):
        self.station, self.pace, self.token, self.opcua = station, pace, token, opcua
        self.ready, self.address, self.failed = threading.Event(), "", None

    def run(self):
        with asyncio.Runner(loop_factory=lambda: asyncio.SelectorEventLoop(selectors.SelectSelector())) as runner:
            self.loop = runner.get_loop()
            try:
                runner.run(self.serve())
            except asyncio.CancelledError:
                pass
            except BaseException as error:
                self.failed = error
                raise
            finally:
                self.ready.set()

    async def serve(self):
        self.task = asyncio.current_task()
        listening = await LineServer(self.pace, self.token).listen("127.0.0.1", 0)
        host, port = listening.sockets[0].getsockname()
        self.address = f"{host}:{port}"
        async with AsyncExitStack() as stack:
            stack.callback(listening.close)
            if self.opcua:
                found = OpcUaServer(self.pace, host, free_port(), self.token)
                await found.begin()
                stack.push_async_callback(found.end)
                self.address = found.address
            self.ready.set()
            await self.pace.run()


def soon(true, seconds=10.0):
    """Whether something becomes true within some seconds."""
    end = time.monotonic() + seconds
    while not true() and time.monotonic() < end:
        time.sleep(0.01)
    return true()


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


@contextmanager
def serving(rig=None, token="", speed=1000.0, waits=True, opcua=False, **station):
    """Serve a rig (default: one of the surface) while the block runs; its time waits for clients unless told."""
    found = Station(rig or SimulatedRig(), events=Events(), **station)
    served = Served(found, Pace(found, speed, waits), token, opcua)
    thread = threading.Thread(target=served.run, daemon=True)
    thread.start()
    assert served.ready.wait(20.0)
    try:
        yield served
    finally:
        served.loop.call_soon_threadsafe(served.task.cancel)
        thread.join(10.0)
        assert served.failed is None
