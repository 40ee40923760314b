"""The rig behind OPC UA: `drillrig_env.deploy.opcua_nodes` has its nodes."""

from __future__ import annotations

import asyncio
import hmac
import json
import logging
import secrets
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from typing import Any

from drillrig_env.deploy import opcua_nodes as nodes
from drillrig_env.deploy.opcua_rig import opcua
from drillrig_env.twin.greeting import greeting
from drillrig_env.twin.pace import Pace


class OpcUaServer:
    """Serves the station of `pace`, which runs beside it. With a `token` clients must have it.

    `ImportError` without asyncua.
    """

    def __init__(self, pace: Pace, host: str, port: int, token: str = "") -> None:
        self._ua, library = opcua().ua, opcua()
        logging.getLogger("asyncua").setLevel(logging.CRITICAL)  # what clients do is no error of this program
        self.station, self.pace = pace.station, pace
        self.address = f"opc.tcp://{host}:{port}{nodes.PATH}"
        self._token = token
        self._server = library.Server(user_manager=self)
        self._began = datetime.now(UTC)
        self._keys: dict[str, object] = {}
        self._writing: asyncio.Task[None] | None = None
        self._latest: Mapping[str, Any] = {}
        self._came = asyncio.Event()

    async def begin(self) -> None:
        """Begin to serve. `OSError` where the port cannot be had."""
        ua, server = self._ua, self._server
        await server.init()
        server.set_endpoint(self.address)
        server.set_server_name("drillrig twin")
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        server.set_identity_tokens([ua.UserNameIdentityToken if self._token else ua.AnonymousIdentityToken])
        self._space = await server.register_namespace(nodes.URI)
        rig = await server.nodes.objects.add_object(self._id(nodes.RIG), "Rig")
        folder = await rig.add_folder(self._id(nodes.MEASUREMENTS), "Measurements")
        about = json.dumps(greeting(self.pace))
        for parent, name, value in (
            (rig, nodes.ABOUT, about),
            (rig, nodes.TIME, self.station.time),
            (rig, nodes.REFERENCE, self.station.rig.reference),
            (rig, nodes.STATE, self.station.state),
            *((folder, nodes.channel_node(channel), 0.0) for channel in self.station.rig.channels),
        ):
            node = await parent.add_variable(self._id(name), name.rpartition("/")[2], value)
            if parent is folder:
                await node.write_value(ua.DataValue(StatusCode=ua.StatusCode(ua.StatusCodes.BadWaitingForInitialData)))
        text, number = ua.VariantType.String, ua.VariantType.Double
        for name, method, takes, gives in (
            (nodes.ARM, self._arm, [], [text, number, text]),
            (nodes.COMMAND, self._command, [text, number], [text]),
            (nodes.RELEASE, self._release, [text], [text]),
        ):
            await rig.add_method(self._id(name), name.rpartition("/")[2], method, takes, gives)
        await server.start()
        self._writing = asyncio.create_task(self._write())
        self.pace.receivers.append(self.deliver)

    async def end(self) -> None:
        """Serve no more."""
        self.pace.receivers.remove(self.deliver)
        if self._writing is not None:
            self._writing.cancel()
        await self._server.stop()

    def get_user(self, _server: Any, username: Any = None, password: Any = None, certificate: Any = None) -> Any:
        """Whom asyncua takes a client for; None for one that has not the token."""
        from asyncua.crypto.permission_rules import User, UserRole

        known = isinstance(password, str) and hmac.compare_digest(password.encode(), self._token.encode())
        return User(role=UserRole.User) if not self._token or (username == nodes.USER and known) else None

    def deliver(self, message: Mapping[str, Any]) -> None:
        """Let clients see new measurements; where they come too fast to be written, the latest ones."""
        self._latest = message
        self._came.set()

    async def _write(self) -> None:
        while True:
            await self._came.wait()
            self._came.clear()
            message, ua = self._latest, self._ua
            taken = self._began + timedelta(seconds=message["time"])
            for name, value in (
                *((nodes.channel_node(one), message["values"].get(one)) for one in self.station.rig.channels),
                (nodes.REFERENCE, message["reference"]),
                (nodes.STATE, message["state"]),
                (nodes.TIME, message["time"]),
            ):
                age = message.get("ages", {}).get(name.rpartition("/")[2], 0.0)
                good = ua.StatusCodes.BadNoData if value is None else ua.StatusCodes.Good
                shown = ua.DataValue(
                    ua.Variant(value),
                    StatusCode=ua.StatusCode(good),
                    SourceTimestamp=taken - timedelta(seconds=age),
                )
                await self._server.write_attribute_value(self._id(name), shown)

    async def _arm(self, _parent: Any) -> list[Any]:
        key, client = secrets.token_hex(), object()
        try:
            self.station.arm(client)
        except ValueError as error:
            return self._answer("", 0.0, str(error))
        self._keys = {key: client}  # nobody has the rig by an earlier one
        return self._answer(key, self.station.rig.reference, "")

    async def _command(self, _parent: Any, key: Any, reference: Any) -> list[Any]:
        try:
            self.station.command(self._keys.get(key.Value), reference.Value)
        except ValueError as error:
            return self._answer(str(error))
        return self._answer("")

    async def _release(self, _parent: Any, key: Any) -> list[Any]:
        self.station.release(self._keys.get(key.Value))
        return self._answer("")

    def _answer(self, *values: Any) -> list[Any]:
        return [self._ua.Variant(value) for value in values]

    def _id(self, name: str) -> Any:
        return self._ua.NodeId(name, self._space)
