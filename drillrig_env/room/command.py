"""Open the control room: two rigs live in the browser, and hands on the force and the speed.

  drillrig room                                    # opens the browser; Ctrl-C closes the room
  drillrig room --story bistability --full-screen  # for a lecture
  drillrig room --rig my_rig.toml --policy my_controller.py:MyPolicy
  drillrig room --replay drillrig_run.json         # a run that was kept, or a row: results/demo/results.csv:17

Two lanes, A and B, show the same rig with two controllers. Sliders set target speed, normal force and friction while
the rigs turn; take a lane over by hand and give it back; keep what happened as CSV, or as a run that the environment
replays bit for bit. See docs/room.md.

It listens on this machine alone. With --host other machines can come in, and --token says who may: everyone who opens
the printed address. Whoever is in can choose among the rigs and policies that are there, and nothing else.
"""

from __future__ import annotations

import errno
import socket
import sys
import threading
import webbrowser
from collections.abc import Sequence
from urllib.parse import quote

from drillrig_env.allowed import Allowed
from drillrig_env.command_line import DONE, Failed, Parser, Terminated, command
from drillrig_env.extras import missing
from drillrig_env.flags import add_friction_argument, add_rig_argument, of_kind

PORT = 8347
_SENT = 131_072  # bytes that the system keeps for a client that is slow; more would only make it later
_PORTS = Allowed(0, 65535, whole=True)
_CLIENTS = Allowed(1, 64, whole=True)


@command
def main(arguments: Sequence[str] | None = None, prog: str = "drillrig room") -> int:
    """Parse the command line, and serve the room until Ctrl-C."""
    from drillrig_env.room.stories import STORIES

    parser = Parser(prog=prog, description=__doc__)
    add = parser.add_argument
    add_rig_argument(parser)
    add_friction_argument(parser)
    add("--policy", action="append", default=[], metavar="NAME", help="another policy to choose, or FILE.py:CLASS")
    add("--story", choices=list(STORIES), help=f"begin with a story: {', '.join(STORIES)}")
    add("--full-screen", action="store_true", help="lecture mode: large, and nothing but what is to be seen")
    add("--replay", metavar="FILE", help="begin with a run that was kept, or with a row of a results.csv, FILE:ROW")
    add("--port", type=of_kind(_PORTS), metavar="N", help=f"where it listens (default: {PORT}, or a free one)")
    add("--host", default="127.0.0.1", help="address on which it listens (default: this machine alone, 127.0.0.1)")
    add("--token", help="what whoever comes in must know; needed with another --host")
    add("--clients", type=of_kind(_CLIENTS), default=8, metavar="N", help="pages at once, at most (default: 8)")
    add("--no-browser", action="store_true", help="print the address, and open no browser")
    options = parser.parse_args(arguments)
    try:
        import msgspec  # noqa: F401
        import starlette  # noqa: F401
        import uvicorn
        import websockets  # noqa: F401
    except ImportError as error:
        raise Failed(str(missing("the control room", "starlette, uvicorn, websockets and msgspec", "room"))) from error
    from drillrig_env.room.app import room_app
    from drillrig_env.room.client import Beginning
    from drillrig_env.room.door import Door
    from drillrig_env.room.lanes import Lanes
    from drillrig_env.room.limits import Limits
    from drillrig_env.room.page import page_files
    from drillrig_env.room.setting import Setting
    from drillrig_env.room.stock import Stock
    from drillrig_env.room.warm import playable, warm_up

    try:
        door = Door(options.host, options.token)
        stock = Stock.of(options.rig, options.friction, options.policy)
        for name, why in stock.left_out.items():
            print(f"{name} is left out: {why}", file=sys.stderr)
        setting = Setting(rig=stock.rig).at(stock)
        if options.rig or options.friction:
            setting, otherwise = playable(stock, setting)
            if otherwise:
                print(otherwise, file=sys.stderr)
        recorded = None
        if options.replay is not None:
            from drillrig_env.room.kept import run_of

            recorded = run_of(options.replay)
            Lanes(setting, stock, recorded)  # says what cannot be played
        beginning = Beginning(setting, recorded, options.story, options.full_screen)
    except (ValueError, ImportError, FileNotFoundError) as error:
        parser.error(str(error))
    files = page_files()
    listener = _listener(options.host, options.port)
    app = room_app(stock, files, beginning, door, Limits(clients=options.clients))
    address = _address(options.host, listener.getsockname()[1])
    address += f"/?token={quote(options.token)}" if options.token else "/"

    class Server(uvicorn.Server):
        async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
            """End the clients first, which may wait for something that takes long."""
            app.end()
            await super().shutdown(sockets)

    config = uvicorn.Config(
        app,
        ws="websockets-sansio",
        ws_max_size=Limits().run_bytes,
        ws_per_message_deflate=False,
        log_level="warning",
        server_header=False,
        lifespan="off",
        timeout_graceful_shutdown=1,
        limit_concurrency=options.clients + 64,
    )
    try:
        threading.Thread(target=warm_up, args=(stock, setting), daemon=True).start()
        print(f"control room: {address}\nCtrl-C closes it", flush=True)
        if not options.no_browser:
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
        Server(config).run(sockets=[listener])
    except Terminated:
        raise
    except KeyboardInterrupt:  # how a room is closed
        print("the control room is closed")
    return DONE


def _listener(host: str, port: int | None) -> socket.socket:
    """A socket that listens. `Failed` where the port is taken or the address is none of this machine."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for wanted in (port,) if port is not None else (PORT, 0):
        listener = socket.socket(family, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SENT)
        try:
            listener.bind((host, wanted))
            listener.listen(128)  # whoever opens the address at once waits, and is not refused
        except OSError as error:
            listener.close()
            if port is None and wanted == PORT:
                continue
            nowhere = isinstance(error, socket.gaierror) or error.errno == errno.EADDRNOTAVAIL
            hint = "another --port may be free, and --port 0 takes one that is"
            raise Failed(
                f"the control room cannot listen on {host}, port {wanted}: {error.strerror or error}; "
                f"{'allowed for --host: an address of this machine' if nowhere else hint}"
            ) from error
        return listener
    raise AssertionError("the last port is either had or refused")


def _address(host: str, port: int) -> str:
    """The address to open in a browser."""
    if host in ("0.0.0.0", "::"):
        host = socket.gethostname()
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"
