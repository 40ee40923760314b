"""Pieces of work on Ray: an instance that is started here and ended here, or a cluster that is there.

Ray gives a piece again where its worker or its machine is lost; what a piece raises is an outcome, as everywhere.
"""

from __future__ import annotations

import os
import secrets
import shutil
import signal
import socket
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import nullcontext
from typing import Any, TypeVar

from drillrig_env.command_line import Failed
from drillrig_env.engine.contract import Engine, Outcome, wait_for
from drillrig_env.engine.packing import packed
from drillrig_env.engine.worker import LEAVE, SAVE, Answer, answer, asked_by_interrupt, opened, packed_work
from drillrig_env.extras import missing
from drillrig_env.jit.threads import available_threads

P = TypeVar("P")
R = TypeVar("R")

_ROOM = 4  # pieces for each core that are given before others are done, so that no worker need wait
_LEAST_ROOM = 64  # so that a cluster that grows with what is asked of it sees that more is
_TRIES = 3  # more times that a piece is given whose worker or machine was lost
_CLIENT = "ray://"
_LISTENS = 5.0  # s in which the head of a cluster is to take a connection
_CONNECT = 40.0  # s after which Ray's client has tried often enough
_STORE = 200_000_000  # bytes of memory that an instance of our own shares: pieces are small


class OnRay(Engine):
    """Ray by its `address`: "local" starts an instance here, "auto" joins the cluster of this machine, or ray://HOST:PORT.

    It begins with its block, or with the first pieces. Raises `ImportError` where Ray is not installed, and `Failed`
    where there is no cluster at the address.
    """

    def __init__(self, address: str = "local", jobs: int | None = None) -> None:
        super().__init__(jobs)
        try:
            import ray
        except ImportError:
            raise missing(f"--on {'ray' if address == 'local' else address}", "ray", "scale") from None
        self.where = "ray" if address == "local" else address
        self._ray: Any = ray
        self._address = address
        self._begun = False
        self._folder: str | None = None
        self._known: tuple[Any, str, Any] | None = None

    def __enter__(self) -> OnRay:
        self.begin()
        return self

    def begin(self) -> None:
        """Start or join it, where that is not done yet."""
        if self._begun:
            return
        if self._ray.is_initialized():
            raise Failed("Ray has been started in this process already; end it with ray.shutdown(), or use one engine")
        for name, value in _SETTINGS.items():
            os.environ.setdefault(name, value)
        own: dict[str, Any] = {}
        if self._address == "local":
            cores = self.jobs or available_threads()
            self._folder = tempfile.mkdtemp(prefix="drillrig-")  # what Ray would leave behind
            own = {"num_cpus": cores, "object_store_memory": _STORE, "include_dashboard": False}
            own["_temp_dir"] = self._folder
            print("starting Ray here, about 10 s", file=sys.stderr, flush=True)
        handlers = _handlers()
        try:
            if self._address.startswith(_CLIENT):
                _look_for(self._address)
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "Ray Client connection timed out")  # which is said below
                self._ray.init(address=self._address, log_to_driver=False, logging_level="ERROR", **own)
        except (OSError, ValueError, RuntimeError) as error:
            self.end()
            self._ray.shutdown()  # a client that did not connect would leave Ray's functions those of a client
            reason = (str(error).strip() or type(error).__name__).splitlines()[0]
            raise Failed(f"--on {self.where}: {_NO_CLUSTER.get(self._address, 'no answer')} ({reason})") from error
        finally:
            for number, handler in handlers.items():  # Ray has set its own
                signal.signal(number, handler)
        self._begun = True

    def end(self) -> None:
        """Leave the cluster, or end the instance that was started here."""
        if self._begun:
            self._known = None
            self._ray.shutdown()
            self._begun = False
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None

    def outcomes(
        self,
        work: Callable[[P], R],
        pieces: Iterable[P],
        *,
        apart: bool = False,
        meanwhile: Callable[[], object] | None = None,
    ) -> Iterator[Outcome[R]]:
        """As in `Engine`."""
        self.begin()
        key, content = self._sent(work)
        task = self._ray.remote(num_cpus=1, max_retries=_TRIES, max_calls=1 if apart else 0)(_answer_here)
        running: dict[Any, int] = {}
        waiting = enumerate(pieces)

        def ended(within: float | None = None) -> Iterator[Outcome[R]]:
            for reference in self._ready(running, meanwhile, within):
                number = running.pop(reference)
                yield self._seen(self._outcome(number, reference))

        try:
            while True:
                for number, piece in self._next(waiting, self._room() - len(running)):
                    running[task.remote(key, content, packed(piece), apart)] = number
                if not running:
                    return
                yield from ended()
        except (KeyboardInterrupt, GeneratorExit) as stop:
            for pause in (SAVE, LEAVE - SAVE) if apart else ():
                for reference in running:  # the first asks for a stop, the second has the piece save at once
                    self._ray.cancel(reference, force=False)
                end = time.monotonic() + pause
                while running and (left := end - time.monotonic()) > 0.0:
                    last = list(ended(left))
                    if isinstance(stop, KeyboardInterrupt):
                        yield from last
            raise
        finally:
            for reference in running:
                self._ray.cancel(reference, force=True)

    def _sent(self, work: Any) -> tuple[str, Any]:
        """The key of the work and a reference to it, for as long as it is the last."""
        if self._known is None or self._known[0] is not work:
            self._known = work, secrets.token_hex(8), self._ray.put(packed_work(work))
        return self._known[1], self._known[2]

    def _room(self) -> int:
        """How many pieces may be given at a time."""
        return self.jobs or max(_LEAST_ROOM, _ROOM * int(self._ray.cluster_resources().get("CPU", 1)))

    def _ready(
        self, running: dict[Any, int], meanwhile: Callable[[], object] | None, within: float | None
    ) -> list[Any]:
        """References to pieces that have ended, at least one of them, or none `within` s."""

        def look(seconds: float) -> list[Any]:
            done: list[Any]
            done, _ = self._ray.wait(list(running), num_returns=1, timeout=seconds, fetch_local=True)
            return done

        return wait_for(look, meanwhile, within)

    def _outcome(self, number: int, reference: Any) -> Outcome[Any]:
        errors = self._ray.exceptions
        try:
            told: Answer = self._ray.get(reference)
        except errors.TaskCancelledError:
            return Outcome(number, error=Failed("the piece was cancelled"))
        except errors.RayError as error:
            reason = str(error).strip().splitlines()[0]
            lost = f"a piece was lost {_TRIES + 1} times: {type(error).__name__}: {reason}"
            return Outcome(number, error=Failed(lost))
        return opened(number, told, elsewhere=True)


_SETTINGS = {
    "RAY_USAGE_STATS_ENABLED": "0",  # nobody has asked for it
    "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",  # as Ray wants it, and says so otherwise
    "RAY_ENABLE_UV_RUN_RUNTIME_ENV": "0",
}

_NO_CLUSTER = {
    "local": "Ray does not start",
    "auto": "there is no cluster that this machine is part of; `ray start --head` starts one, --on ray an own instance",
}


def _look_for(address: str) -> None:
    """Say that the head of a cluster is being asked, and for how long. `OSError` where nobody listens there."""
    print(f"--on {address}: asking, for up to {_CONNECT:.0f} s", file=sys.stderr, flush=True)
    host, _, port = address.removeprefix(_CLIENT).rpartition(":")
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=_LISTENS).close()
    except OSError as error:
        raise ConnectionError((error.strerror or str(error)).lower()) from error


def _answer_here(key: str, content: bytes, piece: bytes, apart: bool) -> Answer:
    """Do a packed piece in a worker of the cluster."""
    with asked_by_interrupt() if apart else nullcontext():
        return answer(key, content, piece)


def _handlers() -> dict[int, Any]:
    if threading.current_thread() is not threading.main_thread():
        return {}
    return {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
