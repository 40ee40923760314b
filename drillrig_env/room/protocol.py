"""What a page may say, message by message, each checked before anything is done; docs/room_protocol.md is its page.

A message is a JSON object whose entry `do` says what it is. It is read by `msgspec`: an unknown entry, a missing one or
one of another kind is refused with a sentence. Whether a value is allowed, the rig says.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import msgspec

VERSION = 1
"""Of the protocol; the page says which one it speaks, and another one is refused."""


class Message(msgspec.Struct, tag_field="do", forbid_unknown_fields=True):
    """What all messages have in common: `do` is the name of the class in small letters."""


class Begin(Message, tag="begin"):
    """The first message: the page's version of the protocol, and the setting that its link holds."""

    version: int
    setting: dict[str, str | int | float | None] = {}


class Set(Message, tag="set"):
    """Other choices; the run begins anew."""

    setting: dict[str, str | int | float | None]


class Give(Message, tag="give"):
    """Values from the coming control step on: speed_target, normal_force, mu_s, mu_k, v_b."""

    values: dict[str, int | float | str]


class Ramp(Message, tag="ramp"):
    """A value that goes somewhere within so many seconds."""

    name: str
    to: int | float | str
    seconds: int | float | str


class Take(Message, tag="take"):
    """Take a lane over by hand, at a speed reference (rad/s) or, with null, at the one that it has."""

    lane: str
    reference: int | float | str | None = None


class GiveBack(Message, tag="give_back"):
    """Give a lane back to its policy."""

    lane: str


class Pause(Message, tag="pause"):
    """Stop the clock, or let it go on."""

    paused: bool


class One(Message, tag="step"):
    """One control step while the clock stands."""


class Speed(Message, tag="speed"):
    """How many times as fast as real time, 0.1 to 10."""

    times: int | float


class Restart(Message, tag="restart"):
    """Begin anew, with the same seed or with the next one."""

    new_seed: bool = False


class Tell(Message, tag="story"):
    """Go to a part of a story; an empty name ends it."""

    name: str
    part: int = 0


class Keep(Message, tag="keep"):
    """Ask for the run: "csv" for its rows, "run" for what the environment plays again."""

    what: str


class Replay(Message, tag="replay"):
    """Play a recorded run, the content of such a file."""

    run: dict[str, Any]


class Alive(Message, tag="alive"):
    """Nothing but that somebody is there."""


Request: TypeAlias = (
    Begin | Set | Give | Ramp | Take | GiveBack | Pause | One | Speed | Restart | Tell | Keep | Replay | Alive
)
"""Every message."""

_decoder = msgspec.json.Decoder(Request, strict=True)
_encoder = msgspec.json.Encoder()


def read(text: str | bytes) -> Request:
    """A message. `ValueError` with a sentence for what is none."""
    try:
        request: Request = _decoder.decode(text)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ValueError(f"control room: not a message of the protocol: {error}") from error
    return request


def write(kind: str, **entries: Any) -> str:
    """An answer: a JSON object whose entry `is` says what it is. NaN and infinity become null."""
    return encode({"is": kind, **entries})


def encode(content: Any) -> str:
    """Plain values as JSON; NaN and infinity become null."""
    return _encoder.encode(content).decode()


def field_of(request: Request) -> str:
    """The control to which a message belongs, for the sentence beside it."""
    match request:
        case Set(setting=changes) if changes:
            return next(iter(changes))
        case Give(values=values) if values:
            return next(iter(values))
        case Ramp(name=name):
            return f"ramp {name}"
        case Take(lane=lane) | GiveBack(lane=lane):
            return f"hand {lane}"
    return type(request).__struct_config__.tag or ""  # type: ignore[return-value]
