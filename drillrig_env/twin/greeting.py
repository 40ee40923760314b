"""What the rig says of itself to a client, whatever it is connected by."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from drillrig_env.deploy.line import VERSION
from drillrig_env.twin.pace import Pace


def greeting(pace: Pace) -> dict[str, Any]:
    """The rig of a station and its state, as docs/line_protocol.md has it."""
    station, rig = pace.station, pace.station.rig
    return {
        "rig": "drillrig twin",
        "version": VERSION,
        "channels": rig.channels,
        "period": rig.period,
        "speed": pace.speed,
        "waits": pace.waits,
        "time": station.time,
        "reference": rig.reference,
        "target": rig.target,
        "highest": rig.usual.largest_reference,
        "state": station.state,
        "delay": rig.delay,
        "drive": rig.usual.speed_loop.as_dict(),
        "parameters": asdict(rig.usual.rig),
        "watchdog": {"periods": station.watchdog.periods, "speed": station.watchdog.fallback_speed},
    }
