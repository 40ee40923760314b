"""The control room: how fast its page is, and what server and browser need for it.

    python -m benchmarks.room            # two minutes
    python -m benchmarks.room --quick    # a first look

A server and Debian's Chromium without a window run on the cores that there are, beside whatever else the machine does:
its load is noted, and the priority that this has (`nice -n -10` goes before other work). Frames are those that the
page has drawn, with both lanes and all of their lines over the last 30 s; shares of a core are processor times of the
server, and of all of the browser's processes. Bytes, four clients and a client that reads nothing are measured by
plain websockets. A client of the room gets the run of two lanes, each with seven signals at 160 samples a second.
"""

from __future__ import annotations

import json
import os
import socket
import statistics
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.browser import Room, chromium, is_drawn, room
from benchmarks.measure import kept, note, print_table, write_json
from drillrig_env.command_line import Parser, command
from drillrig_env.files import read_json
from drillrig_env.parameters import closest

_TICKS = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 100
_NARROW = 16_384  # bytes that the system keeps for a client that reads nothing
_CLIENTS = (
    {"a": "constant", "b": "lqg"},
    {"a": "soft_torque", "b": "z_torque", "rig": "field_2500m"},
    {"a": "ppo_surface", "b": "z_torque", "sensors": "surface", "noise": 1.0},
    {"a": "jump_ease", "b": "constant", "normal_force": 20.0},
)
"""Four clients, each with its own rig and policies."""


def processor_seconds(process: int) -> float:
    """Processor time of a process and of all that it has started, s."""
    children: dict[int, list[int]] = {}
    own: dict[int, float] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                fields = (entry / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            children.setdefault(int(fields[1]), []).append(int(entry.name))
            own[int(entry.name)] = (int(fields[11]) + int(fields[12])) / _TICKS
    total, left = 0.0, [process]
    while left:
        one = left.pop()
        total += own.get(one, 0.0)
        left += children.get(one, [])
    return total


def resident_kilobytes(process: int) -> int:
    """Memory of a process that is in use, kB."""
    return int(Path(f"/proc/{process}/status").read_text().split("VmRSS:")[1].split()[0])


class Client:
    """A client without a page; `setting` and speed (times real time) are what it asks for."""

    def __init__(self, served: Room, setting: Mapping[str, Any], speed: float = 1.0, narrow: bool = False) -> None:
        from websockets.sync.client import connect

        host, port = served.address.removeprefix("http://").split(":")
        reached = socket.socket()
        if narrow:
            reached.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _NARROW)
        reached.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # as browsers do
        reached.connect((host, int(port)))
        connection = connect(f"ws://{host}:{port}/room", sock=reached, max_queue=1 if narrow else 64)
        self.socket = connection.__enter__()
        self.bytes = self.messages = self.steps = self.gaps = 0
        self.say(do="begin", version=1, setting=setting)
        self.until("state")
        self.say(do="speed", times=speed)

    def say(self, **message: Any) -> None:
        """Send a message."""
        self.socket.send(json.dumps(message))

    def take(self, patience: float | None = None) -> dict[str, Any]:
        """Take the next message in; what it says, where it is text. `TimeoutError` where none comes."""
        message = self.socket.recv(patience)
        self.bytes += len(message)
        self.messages += 1
        if isinstance(message, str):
            told: dict[str, Any] = json.loads(message)
            return told
        self.steps += int.from_bytes(message[4:6], "little")
        self.gaps += message[3] & 1
        return {}

    def until(self, kind: str, patience: float | None = None) -> dict[str, Any]:
        """Take messages in up to one of a kind."""
        while True:
            told = self.take(patience)
            if told.get("is") == kind:
                return told

    def read(self, end: float) -> None:
        """Take everything in up to a time (of `time.monotonic`)."""
        while (left := end - time.monotonic()) > 0:
            try:
                self.take(left)
            except TimeoutError:
                return


def settle(served: Room, clients: Sequence[Client]) -> None:
    """Let clients stand, and wait until the server has loaded and prepared all that it needs for them."""
    for client in clients:
        client.say(do="pause", paused=True)
    still, last = 0, processor_seconds(served.process.pid)
    while still < 3:
        for client in clients:
            client.read(time.monotonic() + 0.5 / len(clients))
        now = processor_seconds(served.process.pid)
        still, last = (still + 1, now) if now - last < 0.05 else (0, now)
    for client in clients:
        client.say(do="pause", paused=False)


@contextmanager
def warm_room(*words: str) -> Iterator[Room]:
    """A server that has loaded and prepared what it needs for a page."""
    with room(*words) as served:
        client = Client(served, {})
        settle(served, [client])
        client.socket.close()
        yield served


def measure_first_picture(repeats: int) -> dict[str, Any]:
    """From the command to the first picture on a page, kernels compiled, s."""
    waits = []
    with chromium() as browser:
        for _ in range(repeats):
            page = browser.new_page(viewport={"width": 1600, "height": 1000})
            began = time.perf_counter()
            with room() as served:
                page.goto(served.address)
                is_drawn(page)
                waits.append(time.perf_counter() - began)
                page.close()
    return {"seconds": statistics.median(waits), "runs": waits}


def measure_page(speed: float, seconds: float) -> dict[str, Any]:
    """What one page does at a speed (times real time) over some seconds, after 30 s of the run."""
    with warm_room() as served, chromium() as browser:
        page = browser.new_page(viewport={"width": 1600, "height": 1000})
        page.goto(served.address)
        is_drawn(page)
        page.select_option("#times", "10")
        is_drawn(page, 31.0)
        page.select_option("#times", f"{speed:g}")
        page.wait_for_timeout(1000)
        drawn = "() => [Number(document.body.dataset.drawn), performance.now()]"
        first, begin = page.evaluate(drawn)
        server, all_of_it = processor_seconds(served.process.pid), processor_seconds(os.getpid())
        page.wait_for_timeout(1000.0 * seconds)
        last, end = page.evaluate(drawn)
        took = (end - begin) / 1000.0
        server = processor_seconds(served.process.pid) - server
        browser_share = processor_seconds(os.getpid()) - all_of_it - server
    return {
        "frames_per_second": (last - first) / took,
        "server_share": server / took,
        "browser_share": browser_share / took,
    }


def measure_bytes(speed: float, seconds: float) -> dict[str, Any]:
    """What one client is sent at a speed."""
    with warm_room() as served:
        client = Client(served, {}, speed)
        client.read(time.monotonic() + 2.0)
        client.bytes = client.messages = 0
        client.read(time.monotonic() + seconds)
        client.socket.close()
    return {"bytes_per_second": client.bytes / seconds, "messages_per_second": client.messages / seconds}


def measure_map(moves: int) -> dict[str, Any]:
    """From a new value of a slider to the map that follows it, ms."""
    waits, before = [], None
    with warm_room() as served:
        client = Client(served, {"b": "soft_torque"})
        settle(served, [client])
        for move in range(moves):
            name, value = (("normal_force", 5.0 + move % 30), ("mu_s", 0.5 + 0.01 * (move % 20)))[move % 2]
            client.say(do="give", values={name: value + 1e-3 * move})
            began = time.perf_counter()
            wanted = client.until("charts")["lanes"][0]["map"]["critical_now"]
            waits.append(1000.0 * (time.perf_counter() - began))
            assert wanted != before
            before = wanted
            client.read(time.monotonic() + 0.5)
        client.socket.close()
    waits.sort()
    return {"median_ms": statistics.median(waits), "nine_in_ten_ms": waits[int(0.9 * moves)], "slowest_ms": waits[-1]}


def measure_clients(speed: float, seconds: float) -> dict[str, Any]:
    """Four clients at once, each its own rig: control steps that came beside those that were due, and the server."""
    with warm_room() as served:
        clients = [Client(served, setting, speed) for setting in _CLIENTS]
        settle(served, clients)
        periods = []
        for client in clients:
            client.say(do="alive")
            client.say(do="speed", times=speed)
            periods.append(float(client.until("state")["period"]))
            client.steps = 0
        server, begin = processor_seconds(served.process.pid), time.monotonic()
        end = begin + seconds
        while time.monotonic() < end:
            for client in clients:
                client.read(min(time.monotonic() + 0.02, end))
        server = processor_seconds(served.process.pid) - server
        for client in clients:
            client.read(time.monotonic() + 0.1)
            client.socket.close()
        due = [speed * (seconds + 0.3) / period for period in periods]
    shares = [client.steps / wanted for client, wanted in zip(clients, due, strict=True)]
    return {"server_share": server / seconds, "slowest_share_of_due": min(shares)}


def measure_slow(seconds: float) -> dict[str, Any]:
    """A client that reads nothing, at ten times real time, and another beside it."""
    with warm_room() as served:
        slow, other = Client(served, {}, 10.0, narrow=True), Client(served, {})
        other.read(time.monotonic() + 1.0)
        before, other.steps = resident_kilobytes(served.process.pid), 0
        other.read(time.monotonic() + seconds)
        grown = resident_kilobytes(served.process.pid) - before
        arrived = other.steps
        slow.read(time.monotonic() + 3.0)
        slow.socket.close()
        other.socket.close()
    return {"grown_kilobytes": grown, "gaps_told": slow.gaps, "other_share_of_due": arrived / (10.0 * seconds)}


def tabulate(results: Mapping[str, Any]) -> None:
    """Print what was measured."""
    rows = [
        (f"{name}, {speed}" if speed else name, what, f"{value:.4g}")
        for name, found in results["cases"].items()
        for speed, values in (found.items() if all(isinstance(v, Mapping) for v in found.values()) else [("", found)])
        for what, value in values.items()
        if isinstance(value, int | float)
    ]
    print_table(("case", "what", "value"), rows)


@command
def main(arguments: Sequence[str] | None = None, prog: str = "python -m benchmarks.room") -> None:
    """Parse the command line, measure, print and write."""
    parser = Parser(prog=prog, description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a few seconds of each")
    parser.add_argument("--json", type=Path, default=Path("results/benchmarks/room.json"), help="where to write")
    parser.add_argument("--only", help="this case alone, such as map; what the file has of the others is kept")
    chosen = parser.parse_args(arguments)
    seconds = 3.0 if chosen.quick else 10.0
    repeats, moves = (1, 10) if chosen.quick else (3, 60)
    results: dict[str, Any] = {"quick": chosen.quick, "seconds": seconds, "cases": {}}
    results["nice"] = os.nice(0) if hasattr(os, "nice") else 0
    results["load_before"] = os.getloadavg()[0]
    cases: dict[str, Callable[[], dict[str, Any]]] = {
        "first picture": lambda: measure_first_picture(repeats),
        "page": lambda: {f"{speed:g}": measure_page(speed, seconds) for speed in (1.0, 10.0)},
        "bytes": lambda: {f"{speed:g}": measure_bytes(speed, seconds) for speed in (1.0, 10.0)},
        "map": lambda: measure_map(moves),
        "four clients": lambda: {f"{speed:g}": measure_clients(speed, seconds) for speed in (1.0, 10.0)},
        "a client that reads nothing": lambda: measure_slow(seconds),
    }

    if chosen.only is not None:
        if chosen.only not in cases:
            parser.error(f"--only {chosen.only!r} is not known; {closest(chosen.only, cases)}")
        if chosen.json.is_file():
            results["cases"] = read_json(chosen.json, "measure all cases first")["results"]["cases"]
        cases = {chosen.only: cases[chosen.only]}

    def tell() -> None:
        tabulate(results)
        write_json(chosen.json, results)

    with kept(chosen.json, tell):
        for name, measure in cases.items():
            results["cases"][name] = measure()
            note(f"{name}: {results['cases'][name]}")
            results["load_after"] = os.getloadavg()[0]
            write_json(chosen.json, results, announce=False)


if __name__ == "__main__":
    raise SystemExit(main())
