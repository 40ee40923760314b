"""Connections to rigs by their address, and whether a rig is what a policy was made for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from drillrig_env.deploy.line_rig import LineRig
from drillrig_env.deploy.loop import Hardware
from drillrig_env.deploy.supervisor import Supervisor
from drillrig_env.parameters import refuse

OPC_UA = "opc.tcp://"

_PERIOD = 1e-6  # by which share control periods may differ
_SAME = 0.02  # share by which gains and parameters may differ without a word


class Connection(Hardware, Protocol):
    """A rig that is connected; times are the rig's, in s, and speeds in rad/s."""

    greeting: dict[str, Any]
    channels: dict[str, str]
    period: float
    speed: float
    waits: bool

    def clock(self) -> float:
        """A time."""

    def sleep(self, seconds: float) -> None:
        """Let a time pass."""

    def ages(self) -> Mapping[str, float]:
        """How old the latest measurements are, by channel."""

    @property
    def target(self) -> float:
        """The speed that the rig's operator wants."""

    def first_reference(self) -> float:
        """The speed reference of the drive, before any measurement tells it."""

    def drive_reference(self) -> float:
        """The speed reference that the drive had when it last told."""

    def arm(self) -> float:
        """Have the rig from now on; the speed reference of its drive."""

    def release(self) -> None:
        """Give the rig back, its drive at the reference that it has."""

    def close(self) -> None:
        """End the connection. A rig that has not been given back is left to its watchdog."""


def connect(address: str, token: str = "") -> Connection:
    """Connect to a rig, by the line protocol or OPC UA.

    `token` is the rig's, where it has one.

    `ValueError` for an address that is none, `ConnectionError` where no rig answers there or it refuses, `ImportError`
    without asyncua.

    >>> connect("rig.example")
    Traceback (most recent call last):
    ValueError: address 'rig.example' is not allowed; allowed: HOST:PORT, such as 127.0.0.1:5025, or opc.tcp://HOST:PORT
    """
    if address.startswith(OPC_UA):
        from drillrig_env.deploy.opcua_rig import OpcUaRig

        return OpcUaRig(address, token)
    return LineRig(address, token)


def compare(supervisor: Supervisor, rig: Connection) -> list[str]:
    """What of a rig is not what the policy was made for, in words, to be minded before anything turns.

    `ValueError` where it cannot work at all: a channel is missing or in another unit, the control period is another.
    """
    controller, told = supervisor.controller, rig.greeting
    for name in supervisor.channels:
        unit = controller.channels.get(name, "N m")
        if rig.channels.get(name) != unit:
            offered = ", ".join(f"{channel} ({unit})" for channel, unit in rig.channels.items())
            raise ValueError(f"{controller.name} wants {name} ({unit}); the rig offers {offered}")
    if abs(rig.period / controller.period - 1.0) > _PERIOD:
        raise refuse(controller.name, "control period of the rig", rig.period, "s", f"{controller.period:g}")
    about, found = controller.file.about, []
    for what, own, other in (
        ("drive", about["drive"], told.get("drive", {})),
        ("rig", about["rig"], told.get("parameters", {})),
    ):
        found += [
            f"{what}: {name} is {other[name]:g}, the policy is for {value:g}"
            for name, value in own.items()
            if isinstance(value, int | float) and name in other and _differ(value, other[name])
        ]
    low, high = about["sensors"]["delay"]
    late = told.get("delay", low)
    if isinstance(late, int | float) and not low <= late <= high:
        found.append(f"instruments are {late} control steps late, the policy is for {low} to {high}")
    return found


def _differ(one: float, other: Any) -> bool:
    return isinstance(other, int | float) and abs(one - other) > _SAME * max(abs(one), abs(other))
