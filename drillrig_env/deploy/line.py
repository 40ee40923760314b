"""The line protocol between a rig and its controller: one JSON object a line, over TCP; see docs/line_protocol.md.

What both sides have in common: how a line is written and read, how long it may be, and which version this is.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

VERSION = 1
LONGEST = 16_384
"""Bytes of the longest line that either side takes."""


class BadLine(ValueError):  # noqa: N818  # a sentence, as the others that are told to a client
    """What came is no line of the protocol."""


def encode(message: Mapping[str, Any]) -> bytes:
    """A message as a line. `ValueError` for a number that is not finite, which JSON has not."""
    return json.dumps(message, allow_nan=False, separators=(",", ":")).encode() + b"\n"


def decode(line: bytes) -> dict[str, Any]:
    """The message in a line. `BadLine` for anything but a JSON object."""
    try:
        message = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise BadLine(f"{_shown(line)} is no JSON") from error
    if not isinstance(message, dict):
        raise BadLine(f"{_shown(line)} is not allowed; allowed: a JSON object")
    return message


class Lines:
    """Cuts what comes over a stream into lines."""

    def __init__(self) -> None:
        self._rest = b""

    def take(self, content: bytes) -> Iterator[bytes]:
        """The lines that are whole with this content. `BadLine` where one is longer than `LONGEST`."""
        *whole, self._rest = (self._rest + content).split(b"\n")
        for line in whole:
            if len(line) > LONGEST:
                raise _too_long()
            if line.strip():
                yield line
        if len(self._rest) > LONGEST:
            raise _too_long()


def _too_long() -> BadLine:
    return BadLine(f"a line of more than {LONGEST} bytes; allowed: up to {LONGEST}")


def _shown(line: bytes, length: int = 40) -> str:
    text = repr(line.decode("utf-8", "replace").strip())
    return text if len(text) <= length else f"{text[:length]}..."
