"""Maps and orbits of both lanes as a client is told them: at once what is quick, and when all is at rest the rest."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.room import protocol
from drillrig_env.room.chart import Chart, chart_of, deepen, driven, followed, orbit_of
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.outbox import Outbox
from drillrig_env.room.view import LARGEST_FORCE, sliders
from drillrig_env.room.worker import Worker

_REST = 0.3
"""s without a change until what is slow is worked out."""


@dataclass(frozen=True)
class Asked:
    """What charts are drawn for: a rig a lane, by the lane's name, with its drive; friction, target (rad/s), force."""

    rigs: dict[str, Rig]
    rig: Rig  # whose sliders there are
    friction: Friction
    target: float
    largest_force: float

    @classmethod
    def of(cls, lanes: Lanes) -> Asked:
        """What is given in a run now."""
        task = lanes.lanes[0].task
        rigs = {lane.name: driven(lane.task.rig, lane.task.drive) for lane in lanes.lanes}
        largest = LARGEST_FORCE * task.scales.force
        return cls(rigs, task.rig, lanes.given.friction(), lanes.given.values["speed_target"], largest)


class Charts:
    """Draws what is wanted, one thing after another, and tells the newest."""

    def __init__(self, outbox: Outbox) -> None:
        self._outbox = outbox
        self._asked: Asked | None = None
        self._given: tuple[Any, ...] | None = None
        self._mapped: tuple[Asked, dict[Rig, dict[str, Any]]] | None = None
        self._wanted, self._to_follow = asyncio.Event(), asyncio.Event()
        self._prepared: dict[str, Rig] = {}
        self._preparing: asyncio.Task[None] | None = None
        # What follows an orbit, or prepares, would hold the map up for a second, and longer while kernels are compiled.
        self._mapper, self._worker, self._beside = Worker(None), Worker(None), Worker(None)

    def want(self, run: int, lanes: Lanes) -> None:
        """Have maps and orbits drawn, where run, friction, force or target are others than they were."""
        given = (run, *lanes.given.values.values())
        if given != self._given:
            self._given, self._asked = given, Asked.of(lanes)
            self._wanted.set()

    async def draw(self) -> None:
        """Work out what is wanted, for ever; in threads, so that no clock waits, which end when this does."""
        try:
            async with asyncio.TaskGroup() as loops:
                loops.create_task(self._map())
                loops.create_task(self._follow())
        finally:
            self._asked = None
            for worker in (self._mapper, self._worker, self._beside):
                worker.close()

    async def _map(self) -> None:
        """Tell the map of what is asked for, whatever is being followed."""
        while True:
            await self._wanted.wait()
            self._wanted.clear()
            asked = self._asked
            if asked is None:
                continue
            maps = await self._mapper.do(partial(quick, asked))
            if not self._is_old(asked):
                self._mapped = asked, maps
                self._to_follow.set()
            self._tell(asked, maps)

    async def _follow(self) -> None:
        """Tell orbits and the true end of stick-slip for the map that was told last."""
        while True:
            await self._to_follow.wait()
            self._to_follow.clear()
            if self._mapped is None:
                continue
            asked, maps = self._mapped
            charts = await self._worker.do(partial(with_orbits, asked, maps))
            if self._is_old(asked):
                continue
            self._tell(asked, charts)
            try:
                await asyncio.wait_for(self._to_follow.wait(), _REST)
                continue
            except TimeoutError:
                pass
            slow = await self._worker.do(partial(thorough, asked, charts, partial(self._is_old, asked)))
            if slow is not None and not self._is_old(asked):
                self._tell(asked, slow)
            if self._prepared != asked.rigs:
                self._prepared = asked.rigs
                self._preparing = asyncio.create_task(self._beside.do(partial(prepare, asked)))

    def _is_old(self, asked: Asked) -> bool:
        return asked is not self._asked

    def _tell(self, asked: Asked, charts: dict[Rig, dict[str, Any]]) -> None:
        lanes = [
            {"name": name, "map": charts[rig]["map"].as_dict(), "orbit": charts[rig].get("orbit")}
            for name, rig in asked.rigs.items()
        ]
        self._outbox.say(protocol.write("charts", lanes=lanes), "charts")


def quick(asked: Asked) -> dict[Rig, dict[str, Any]]:
    """The map of each rig, in milliseconds."""
    return {rig: {"map": chart_of(rig, asked.friction, asked.largest_force)} for rig in set(asked.rigs.values())}


def with_orbits(asked: Asked, charts: dict[Rig, dict[str, Any]]) -> dict[Rig, dict[str, Any]]:
    """The same with orbits: in some ten milliseconds, or in a second where an orbit must be followed to."""
    orbits = {rig: orbit_of(rig, asked.friction, asked.target) for rig in charts}
    return {rig: {**chart, "orbit": orbits[rig]} for rig, chart in charts.items()}


def thorough(
    asked: Asked, charts: dict[Rig, dict[str, Any]], stop: Callable[[], bool]
) -> dict[Rig, dict[str, Any]] | None:
    """The same with the true end of stick-slip; None where `stop` has said that it is no longer wanted."""
    found = {}
    for rig, chart in charts.items():
        drawn: Chart | None = followed(chart["map"], rig, asked.friction, asked.largest_force, stop)
        if drawn is None:
            return None
        found[rig] = {**chart, "map": drawn}
    return found


def prepare(asked: Asked) -> None:
    """Have what is quick stay quick at the far ends of all sliders."""
    ends = sliders(asked.rig)
    for rig in set(asked.rigs.values()):
        deepen(rig, (asked.largest_force, ends["mu_s"][1], ends["mu_k"][0], ends["v_b"][1]))
