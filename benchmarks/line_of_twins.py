"""Twins one after another in a process of their own, each behind a port, for a benchmark that plays many rigs."""

from __future__ import annotations

import asyncio
import selectors
import signal
from dataclasses import dataclass
from multiprocessing.connection import Connection

from drillrig_env.deploy.events import Events
from drillrig_env.evaluation.suites import STICKING
from drillrig_env.scales import DURATION
from drillrig_env.seeds import EVALUATION_SEEDS
from drillrig_env.twin.channel import Wire
from drillrig_env.twin.pace import Pace
from drillrig_env.twin.rig import SimulatedRig
from drillrig_env.twin.server import LineServer
from drillrig_env.twin.station import Station


@dataclass(frozen=True)
class Sort:
    """A sort of wire: share of messages lost, by up to how many s each is late, how many periods the watchdog bears."""

    loss: float = 0.0
    jitter: float = 0.0
    periods: int = 3
    seed: int = 0

    @property
    def words(self) -> str:
        """It, as the table has it."""
        if not self.loss and not self.jitter:
            return "perfect"
        return f"{100 * self.loss:g} % lost, up to {1e3 * self.jitter:g} ms late, watchdog of {self.periods} periods"


def serve(pipe: Connection, sensors: str, sort: Sort, rigs: int, speed: float) -> None:
    """Serve rig after rig of the suite `default`: send its address, and when asked its verdict and its time (s)."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with asyncio.Runner(loop_factory=lambda: asyncio.SelectorEventLoop(selectors.SelectSelector())) as runner:
        for number in range(rigs):
            runner.run(_serve_one(pipe, sensors, sort, number, speed))


async def _serve_one(pipe: Connection, sensors: str, sort: Sort, number: int, speed: float) -> None:
    rig = SimulatedRig(EVALUATION_SEEDS.start + number, sensors, options=STICKING)
    wire = Wire(loss=sort.loss, jitter=sort.jitter)
    station = Station(rig, wire, periods=sort.periods, seed=sort.seed * 1_000_000 + number, events=Events())
    pace = Pace(station, speed, waits=True)
    listening = await LineServer(pace).listen("127.0.0.1", 0)
    host, port = listening.sockets[0].getsockname()
    loop, asked = asyncio.get_running_loop(), asyncio.Event()
    loop.add_reader(pipe.fileno(), asked.set)
    running = asyncio.create_task(pace.run())
    pipe.send(f"{host}:{port}")
    await asked.wait()
    pipe.recv()
    loop.remove_reader(pipe.fileno())
    running.cancel()
    listening.close()
    pipe.send((rig.is_mitigated, min(rig.time, DURATION)))
