"""One client's room: its setting, its run and its clock. Nothing of it is shared with other clients."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from functools import partial
from typing import Any

from drillrig_env.allowed import Allowed
from drillrig_env.env.recorded import Recorded
from drillrig_env.parameters import checked
from drillrig_env.room import protocol
from drillrig_env.room.charts import Charts
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.outbox import Outbox
from drillrig_env.room.setting import LARGEST_SEED, Setting
from drillrig_env.room.stock import Stock
from drillrig_env.room.stories import part_of
from drillrig_env.room.strangers import said
from drillrig_env.room.view import state
from drillrig_env.room.worker import Worker

SPEEDS = Allowed(0.1, 10.0)
"""How many times as fast as real time a run may go."""

FRAMES = 30.0
"""Most frames a second that are sent."""

_MOST_BEHIND = 0.25
"""s of the clock that are caught up with, at most; what is lost beyond is lost, so that no queue of steps grows."""


class Session:
    """The room of one client; `outbox` has what is to be sent to it.

    `lanes` are those to begin with. What takes long, or belongs to a policy, is done by the `worker`, one thing after
    another and in turn with what a client asks for.
    """

    def __init__(self, stock: Stock, lanes: Lanes, worker: Worker) -> None:
        self.stock, self.outbox = stock, Outbox()
        self._worker, self._turn = worker, asyncio.Lock()
        self.run_number, self.paused, self.times = 0, False, 1.0
        self.story: tuple[str, int] | None = None
        self.lanes = lanes
        self.charts = Charts(self.outbox)
        self._moved = asyncio.Event()

    async def run(self) -> None:
        """Let the clock go, for ever."""
        loop = asyncio.get_running_loop()
        behind, last = 0.0, loop.time()
        while True:
            if self.paused or self.lanes.at_end:
                self._moved.clear()
                await self._moved.wait()
                behind, last = 0.0, loop.time()
                continue
            period = self.lanes.period / self.times
            await asyncio.sleep(max(period - behind, 1.0 / FRAMES))
            now = loop.time()
            behind = min(behind + now - last, _MOST_BEHIND + period)
            last = now
            while behind >= period and not self.paused and not self.lanes.at_end:
                async with self._turn:
                    if not self.paused:
                        await self._step(more=behind >= 2.0 * period)
                behind -= period
                period = self.lanes.period / self.times
            if self.lanes.at_end:
                self.say_state()

    async def _step(self, more: bool = False) -> None:
        """One control step, unless the run is at its end; what a policy or the rig raises stops the clock.

        `more` says that others are due as well.
        """
        lanes = self.lanes
        if lanes.at_end:
            return
        ramps = lanes.given.ramps
        try:
            self.outbox.add(await self._worker.do(lanes.step), more)
        except Exception as error:  # a lost state, or a policy that does not come back
            lanes.broken = self.paused = True
            self._refuse("run", f"the run has stopped, restart it: {said(error)}")
            self.say_state()
            return
        if ramps or lanes.recorded is not None:
            self.charts.want(self.run_number, lanes)
        if ramps != lanes.given.ramps:
            self.say_state()

    async def do(self, request: protocol.Request) -> None:
        """Do what a message asks for; where that is not allowed, nothing changes, and the rig's sentence is told."""
        if not isinstance(request, protocol.Alive):
            await self._attempt(protocol.field_of(request), partial(self._do, request))

    async def replay(self, recorded: Recorded) -> None:
        """Play a recorded run again, or tell why that cannot be."""
        await self._attempt("replay", partial(self._begin, self.lanes.setting, recorded))

    async def _attempt(self, field: str, action: Callable[[], Awaitable[None]]) -> None:
        """Do something in its turn; `field` is the control beside which a refusal of it belongs."""
        async with self._turn:
            try:
                await action()
            except Exception as error:  # the rig's own sentence, or whatever a stranger's policy raises
                self._refuse(field, said(error))
            self._moved.set()
            self.say_all()

    async def _do(self, request: protocol.Request) -> None:
        match request:
            case protocol.Set(setting=changes):
                await self._begin(self._chosen(changes))
            case protocol.Give(values=values):
                await self._give(values)
            case protocol.Ramp(name=name, to=to, seconds=seconds):
                self.lanes.given.ramp(name, to, seconds, self.lanes.step_number)
            case protocol.Take(lane=lane, reference=reference):
                one = self.lanes.lane(lane)
                one.take(one.speed_reference if reference is None else reference)
            case protocol.GiveBack(lane=lane):
                self.lanes.lane(lane).take(None)
            case protocol.Pause(paused=paused):
                self.paused = paused
            case protocol.One():
                self.paused = True
                await self._step()
            case protocol.Speed(times=times):
                self.times = float(checked("control room", "speed", times, "times real time", SPEEDS))
            case protocol.Restart(new_seed=new_seed):
                await self._restart(new_seed)
            case protocol.Tell(name=name, part=part):
                await self._tell(name, part)
            case protocol.Keep(what=what):
                await self._keep(what)
            case protocol.Replay(run=run):
                recorded = await self._worker.do(partial(Recorded.of, run, "the recorded run"))
                self.stock.check_rig(recorded.rig)
                await self._begin(self.lanes.setting, recorded)
                self.paused = False
            case protocol.Begin():
                raise ValueError("control room: the room has begun already; send another setting by set")

    def _refuse(self, field: str, sentence: str) -> None:
        """Tell the client that something is not allowed; `field` is the control beside which it belongs."""
        self.outbox.say(protocol.write("refused", field=field, sentence=sentence))

    def say_state(self) -> None:
        """Tell the client how all controls are."""
        self.outbox.say(protocol.write("state", **state(self)), "state")

    def say_all(self) -> None:
        """Tell the client how all controls are, and have maps drawn that are others now."""
        self.say_state()
        self.charts.want(self.run_number, self.lanes)

    def _chosen(self, changes: dict[str, Any]) -> Setting:
        """The setting with some choices anew; what was given by hand stays on the same rig."""
        kept = {**self.lanes.setting.as_dict(), **self.lanes.given.values}
        return Setting(**kept).changed(changes)

    async def _begin(self, setting: Setting, recorded: Recorded | None = None, hands: bool = True) -> None:
        """Begin a run; where that is not possible, the one under way goes on. `hands` stay on the lanes, or do not."""
        kept = [lane.hand for lane in self.lanes.lanes] if hands and recorded is None else []
        lanes = await self._worker.do(partial(Lanes, setting, self.stock, recorded))
        for lane, hand in zip(lanes.lanes, kept, strict=False):
            if hand is not None:
                lane.take(min(hand, lane.task.largest_reference))
        self.lanes = lanes
        self.run_number += 1
        self.outbox.forget_steps()
        self.story = self.story if recorded is None else None

    async def _restart(self, new_seed: bool) -> None:
        if self.lanes.recorded is not None and not new_seed:
            await self._begin(self.lanes.setting, self.lanes.recorded)
            return
        seed = self.lanes.setting.seed
        await self._begin(self._chosen({"seed": (seed + 1) % LARGEST_SEED if new_seed else seed}))

    async def _give(self, values: Mapping[str, float | str]) -> None:
        """Give values; before the first step they belong to the start, which is then another one."""
        if self.lanes.step_number == 0:
            self.lanes.given.set(values)  # refuses what is not allowed
            await self._begin(self._chosen(dict(values)))
        else:
            self.lanes.given.set(values)

    async def _tell(self, name: str, part: int) -> None:
        if not name:
            self.story = None
            return
        told = part_of(name, part)
        if told.setting:
            await self._begin(self._chosen(dict(told.setting)), hands=False)
        if told.values:
            await self._give(dict(told.values))
        for ramp in told.ramps:
            self.lanes.given.ramp(*ramp, self.lanes.step_number)
        self.story, self.paused = (name, part), False

    async def _keep(self, what: str) -> None:
        if what == "csv":
            names = [lane.name for lane in self.lanes.lanes]
            text, name = await self._worker.do(partial(self.lanes.record.as_csv, names)), "drillrig_run.csv"
        elif what == "run":
            recorded = self.lanes.as_recorded()
            text, name = await self._worker.do(lambda: protocol.encode(recorded.as_json())), "drillrig_run.json"
        else:
            raise ValueError(f"control room: {what!r} cannot be kept; allowed: csv, run")
        self.outbox.say(protocol.write("file", name=name, text=text), f"file {what}")
