"""Where a rig keeps what in the address space of OPC UA; the same for its server and its clients.

| node | holds |
|---|---|
| `Objects/Rig/About` | what the rig says of itself, as in the line protocol, a JSON text |
| `Objects/Rig/Time` | its time in s; the source time stamp is when all the measurements were taken |
| `Objects/Rig/SpeedReference`, `State` | of its drive, rad/s; who has it |
| `Objects/Rig/Measurements/top_speed`, ... | a channel each, in SI units, with the time stamp of its source |
| `Objects/Rig/Arm()` | the method that has the rig: a key, and its speed reference; or an empty key and why not |
| `Objects/Rig/Command(key, reference)` | gives its drive a speed reference, rad/s; empty, or why it was refused |
| `Objects/Rig/Release(key)` | gives it back |
"""

from __future__ import annotations

URI = "urn:drillrig"
"""The namespace."""

USER = "drillrig"
"""Who has the token as password."""

PATH = "/drillrig"
RIG, MEASUREMENTS = "Rig", "Rig/Measurements"
ABOUT, TIME, REFERENCE, STATE = "Rig/About", "Rig/Time", "Rig/SpeedReference", "Rig/State"
ARM, COMMAND, RELEASE = "Rig/Arm", "Rig/Command", "Rig/Release"


def channel_node(channel: str) -> str:
    """The node of a channel."""
    return f"{MEASUREMENTS}/{channel}"
