"""Run a simulated rig in a process of its own, behind a line that a controller connects to.

  drillrig twin                                        # the chapter's rig, sticking and slipping, in real time
  drillrig run ppo_surface --connect 127.0.0.1:5025    # in another terminal
  drillrig twin --rig my_rig.toml --loss 0.1 --jitter 0.05 --fault current:frozen:20:30
  drillrig twin --opcua 4840                           # OPC UA besides (extra opcua): opc.tcp://127.0.0.1:4840

The drive keeps its speed until a client arms it. Where the client's commands no longer come, the watchdog takes over
after some control periods, ramps to its own speed, and waits to be armed again. All that happens is printed. Noise,
losses and jitter follow from the seed. From other computers it can be reached with --host, and then wants a token.
docs/line_protocol.md has the protocol, docs/hardware.md all the rest.
"""

from __future__ import annotations

import asyncio
import os
import selectors
import signal
from collections.abc import Coroutine, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from drillrig_env.allowed import COUNT, NOT_NEGATIVE, POSITIVE, Allowed, File, Made
from drillrig_env.command_line import Failed, Parser, Terminated, command
from drillrig_env.deploy.events import Event, Events
from drillrig_env.deploy.opcua_rig import opcua
from drillrig_env.deploy.token import read_token
from drillrig_env.flags import add_fields, add_friction_argument, add_rig_argument, given_fields, of_kind
from drillrig_env.twin.channel import Wire
from drillrig_env.twin.faults import KINDS, Fault

if TYPE_CHECKING:
    from drillrig_env.twin.pace import Pace
    from drillrig_env.twin.rig import SimulatedRig

HERE = ("127.0.0.1", "localhost", "::1")
PORT = 5025
_PORTS = Allowed(0, 65_535, whole=True)


class _Printed(Events):
    """Events that are printed and not kept: a twin may run for long."""

    def add(self, time: float, state: str, kind: str, reason: str) -> None:
        print(Event(time, state, kind, reason), flush=True)


@command
def main(arguments: Sequence[str] | None = None, prog: str = "drillrig twin") -> None:
    """Parse the command line, and serve a rig until Ctrl-C."""
    parser = _parser(prog)
    chosen = parser.parse_args(arguments)
    if chosen.host not in HERE and chosen.token_file is None:
        parser.error(f"--host {chosen.host} is not allowed without --token-file; allowed: {', '.join(HERE)}")
    if chosen.wait and chosen.opcua is not None:
        parser.error("--wait is not allowed with --opcua, which asks for no time")
    try:
        token = "" if chosen.token_file is None else read_token(chosen.token_file)
        pace = _pace(chosen)
        if chosen.opcua is not None:
            opcua()
    except ValueError as error:
        parser.error(str(error))
    except ImportError as error:
        raise Failed(str(error)) from error
    with asyncio.Runner(loop_factory=lambda: asyncio.SelectorEventLoop(selectors.SelectSelector())) as runner:
        runner.run(_until_terminated(_serve(pace, chosen, token)))


def _parser(prog: str) -> Parser:
    parser = Parser(prog=prog, description=__doc__)
    add = parser.add_argument
    add_rig_argument(parser)
    add_friction_argument(parser, "the chapter's, in the scales of the rig")
    port = of_kind(_PORTS)
    add("--port", type=port, default=PORT, help=f"of the line; 0: any that is free (default: {PORT})")
    ports = of_kind(Allowed(1, _PORTS.high, whole=True))
    add("--opcua", type=ports, metavar="PORT", help="serve OPC UA besides (default: not)")
    add("--host", default=HERE[0], help=f"address to listen at (default: {HERE[0]}, this computer alone)")
    add("--token-file", type=of_kind(File()), metavar="FILE", help="whose first line a client must have")
    add("--speed", type=of_kind(POSITIVE), default=1.0, help="times real time (default: 1)")
    add("--wait", action="store_true", help="let time pass only while the client asks for it, --speed at most")
    add("--seed", type=of_kind(Allowed(0, whole=True)), help="of load, start, noise and losses (default: 0)", default=0)
    add("--speed-target", type=of_kind(POSITIVE, "rad/s"), metavar="RAD/S", help="(default: drawn)")
    add("--normal-force", type=of_kind(NOT_NEGATIVE, "N"), metavar="N", help="at the bit (default: drawn)")
    add("--start", choices=("stick_slip", "steady", "rest"), default="stick_slip", help="(default: stick_slip)")
    add("--sensors", choices=("surface", "encoders", "state"), default="surface", help="(default: surface)")
    add("--noise", type=of_kind(NOT_NEGATIVE), help="times the instruments' usual (default: by sensors)")
    add("--delay", type=of_kind(Allowed(0, 2, whole=True)), help="of the instruments, control steps (default: theirs)")
    add_fields(parser, Wire)
    kinds = Made(Fault.parse, "channel:kind:from:to")
    add(
        "--fault",
        type=of_kind(kinds),
        action="append",
        default=[],
        metavar="CHANNEL:KIND:FROM:TO",
        help=f"an instrument that fails from a time to another (s); {', '.join(KINDS)}; may be given several times",
    )
    add("--watchdog-periods", type=of_kind(COUNT), default=3, help="silent control periods until it acts (default: 3)")
    return parser


def _pace(chosen: Any) -> Pace:
    """The rig of a command line, with its drive and its time. `ValueError` for what is not allowed."""
    from drillrig_env.twin.pace import Pace
    from drillrig_env.twin.station import Station

    rig = _rig(chosen)
    wire = Wire(**given_fields(chosen, Wire))
    station = Station(rig, wire, chosen.fault, chosen.watchdog_periods, chosen.seed, _Printed())
    return Pace(station, chosen.speed, chosen.wait)


def _rig(chosen: Any) -> SimulatedRig:
    from drillrig_env.env.scenario import Scenario
    from drillrig_env.scales import Scales
    from drillrig_env.seeds import VALIDATION_SEEDS
    from drillrig_env.twin.rig import SimulatedRig

    scenario = Scenario.named("default", Scales.of(chosen.rig))
    if chosen.friction is not None:
        scenario = replace(scenario, friction=chosen.friction)
    options = {name: getattr(chosen, name) for name in ("speed_target", "normal_force", "start")}
    return SimulatedRig(
        VALIDATION_SEEDS.start + chosen.seed,
        chosen.sensors,
        chosen.noise,
        chosen.delay,
        {name: value for name, value in options.items() if value is not None},
        rig=chosen.rig,
        scenario=scenario,
    )


async def _until_terminated(serving: Coroutine[Any, Any, None]) -> None:
    """Serve until SIGTERM, which is waited for: an exception at any moment could get lost amid the event loop."""
    loop, task, asked = asyncio.get_running_loop(), asyncio.ensure_future(serving), asyncio.Event()

    def terminate() -> None:
        asked.set()
        task.cancel()

    with suppress(NotImplementedError):  # on Windows it ends the process
        loop.add_signal_handler(signal.SIGTERM, terminate)
    try:
        await task
    except asyncio.CancelledError:
        if asked.is_set():
            raise Terminated from None
        raise


async def _serve(pace: Pace, chosen: Any, token: str) -> None:
    """Serve a rig until it is over."""
    from drillrig_env.twin.server import LineServer

    rig, server = pace.station.rig, LineServer(pace, token)
    pace.station.advance()  # compiles what is not compiled yet, before anybody looks
    with _said_in_a_sentence(chosen.host, chosen.port):
        listening = await server.listen(chosen.host, chosen.port)
    host, port = listening.sockets[0].getsockname()[:2]
    print(f"rig: {rig.target:.3g} rad/s wanted, {rig.core.episodes['normal_force'][0]:.3g} N, {chosen.start}")
    print(f"measures each {rig.period:g} s: {', '.join(f'{name} ({unit})' for name, unit in rig.channels.items())}")
    print(f"listening at {host}:{port}; Ctrl-C ends it", flush=True)
    try:
        if chosen.opcua is None:
            await pace.run()
        else:
            await _serve_opcua_too(pace, chosen, token)
    finally:
        listening.close()
    raise Failed(f"the rig's day is over, {rig.time:.6g} s; start it anew")


async def _serve_opcua_too(pace: Pace, chosen: Any, token: str) -> None:
    from drillrig_env.twin.opcua import OpcUaServer

    opcua = OpcUaServer(pace, chosen.host, chosen.opcua, token)
    with _said_in_a_sentence(chosen.host, chosen.opcua):
        await opcua.begin()
    try:
        print(f"listening at {opcua.address}", flush=True)
        await pace.run()
    finally:
        await opcua.end()


@contextmanager
def _said_in_a_sentence(host: str, port: int) -> Iterator[None]:
    """What becomes of an address that cannot be had."""
    try:
        yield
    except OSError as error:
        number = error.errno or 0
        reason = (os.strerror(number) if number > 0 else error.strerror or str(error)).lower()
        raise Failed(f"{host}:{port} cannot be listened at: {reason}; give another port") from error
