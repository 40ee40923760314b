"""A rig behind OPC UA, as the loop wants it; `drillrig_env.deploy.opcua_nodes` has its nodes."""

from __future__ import annotations

import importlib
import json
import logging
import os
import time as system
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from drillrig_env.deploy import opcua_nodes as nodes
from drillrig_env.deploy.connected import ConnectedRig
from drillrig_env.deploy.greeting import Greeting
from drillrig_env.deploy.readings import Readings
from drillrig_env.extras import missing

_LOOKS = 20  # in a control period, for those
_SILENT = 2.0  # s of the system's time without an answer


def opcua() -> Any:
    """The library. `ImportError` that says what to install where it is missing."""
    try:
        return importlib.import_module("asyncua")
    except ImportError as error:
        raise missing("OPC UA", "asyncua", "opcua") from error


class OpcUaRig(ConnectedRig):
    """A connection to the rig at `address`, "opc.tcp://host:port"; it commands nothing until `arm`.

    Times are the rig's, which runs `speed` times as fast as the system's. `greeting` is what the rig says of itself.
    Raises `ConnectionError` where there is no such rig or it refuses the connection, and later where it no longer
    answers or its watchdog has taken over; `ImportError` without asyncua.
    """

    waits = False

    def __init__(self, address: str, token: str = "") -> None:
        library = opcua()
        sync, self._ua = importlib.import_module("asyncua.sync"), library.ua
        logging.getLogger("asyncua").setLevel(logging.CRITICAL)  # what fails is told by exceptions here
        url = address if address.count("/") > 2 else address + nodes.PATH
        self.address, self._key = address, ""
        self._client = sync.Client(url, timeout=_SILENT, sync_wrapper_timeout=2.0 * _SILENT)
        if token:
            self._client.set_user(nodes.USER)
            self._client.set_password(token)
        try:
            self._call(self._client.connect)
            self._space = self._call(self._client.get_namespace_index, nodes.URI)
            self.greeting = json.loads(self._call(self._node(nodes.ABOUT).read_value))
            said = Greeting.of(self.greeting)
            self.speed, self.period = said.speed, said.period
            self.channels = said.channels
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            self._leave()
            raise ConnectionError(f"{address} is no rig of this kind: {error}") from error
        except BaseException:
            self._leave()
            raise
        self._rig = self._node(nodes.RIG)
        names = [nodes.TIME, nodes.REFERENCE, nodes.STATE, *map(nodes.channel_node, self.channels)]
        self._shown = [self._node(name) for name in names]
        self._readings = Readings(address)

    def clock(self) -> float:
        """A time, s of the rig's."""
        return system.perf_counter() * self.speed

    def sleep(self, seconds: float) -> None:
        """Let a time (s of the rig's) pass."""
        system.sleep(max(0.0, seconds / self.speed))

    def measure(self) -> Mapping[str, Any]:
        """The latest measurements by channel; waited for a little where those of now are just underway."""
        self._look()
        end = self.clock() + self._patience
        while not self._readings.fresh and self.clock() < end:
            self.sleep(self.period / _LOOKS)
            self._look()
        return self._readings.seen()

    def first_reference(self) -> float:
        """The speed reference (rad/s) of the drive now."""
        return float(self._call(self._node(nodes.REFERENCE).read_value))

    def arm(self) -> float:
        """Have the rig from now on; the speed reference (rad/s) of its drive. `ConnectionError` where it refuses."""
        time = float(self._call(self._node(nodes.TIME).read_value))
        self._key, reference, refused = self._method(nodes.ARM)
        if not self._key:
            raise ConnectionError(f"{self.address} refuses: {refused}")
        self._readings.armed_at = time + self.period  # those before may tell of the state that was
        return float(reference)

    def command(self, speed_reference: float) -> None:
        """Give the drive a speed reference (rad/s)."""
        refused = self._method(nodes.COMMAND, self._key, float(speed_reference))
        if refused:
            raise ConnectionError(f"{self.address} refuses: {refused}")

    def release(self) -> None:
        """Give the rig back, its drive at the reference that it has."""
        if self._key:
            self._method(nodes.RELEASE, self._key)
        self._key, self._readings.armed_at = "", None

    def close(self) -> None:
        """End the connection. A rig that has not been given back is left to its watchdog."""
        self._leave()

    def _look(self) -> None:
        """Take in what the rig shows now."""
        time, reference, state, *shown = self._call(self._client.read_attributes, self._shown)
        values, ages = dict[str, Any](), dict[str, float]()
        for name, one in zip(self.channels, shown, strict=True):
            if one.StatusCode.is_good() and one.Value is not None:
                values[name] = one.Value.Value
                ages[name] = (time.SourceTimestamp - one.SourceTimestamp).total_seconds()
        if values:
            told = {"time": time.Value.Value, "reference": reference.Value.Value, "state": state.Value.Value}
            self._readings.take({**told, "values": values, "ages": ages}, self.clock())

    def _method(self, name: str, *values: Any) -> Any:
        return self._call(self._rig.call_method, self._ua.NodeId(name, self._space), *values)

    def _call(self, function: Any, *values: Any) -> Any:
        """Ask the rig for something. `ConnectionError` where it does not answer, or refuses."""
        try:
            return function(*values)
        except self._ua.UaStatusCodeError as error:
            raise ConnectionError(f"{self.address} refuses: {error}") from error
        except (TimeoutError, OSError, self._ua.UaError) as error:
            number = getattr(error, "errno", None)
            what = os.strerror(number) if number else str(error) or f"no answer within {_SILENT:g} s"
            raise ConnectionError(f"there is no rig at {self.address}, or it has gone: {what}") from error

    def _leave(self) -> None:
        with suppress(Exception):  # whatever is left of the connection
            self._client.disconnect()

    def _node(self, name: str) -> Any:
        return self._client.get_node(self._ua.NodeId(name, self._space))
