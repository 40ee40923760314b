"""What a policy's file says of itself: JSON by name in the metadata, and a digest of the whole file.

The digest is the SHA-256 of the file with zeros in its place, so that it can be checked without the library that
wrote the file.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

NO_DIGEST = "0" * 64
"""What stands in the place of the digest while it is made."""


def as_properties(about: Mapping[str, Any]) -> dict[str, str]:
    """What is to be known, as the metadata of a file: JSON by name, and a place for the digest."""
    return {**{name: json.dumps(value) for name, value in about.items()}, "digest": NO_DIGEST}


def read_properties(source: str, properties: Mapping[str, str], latest: int = 1) -> dict[str, Any]:
    """What the metadata of the file `source` says. `ValueError` where it was not written by this project."""
    try:
        found = {name: json.loads(text) for name, text in properties.items() if name != "digest"}
        form = found["format"]
    except (ValueError, KeyError) as error:
        raise ValueError(f"{source} is no policy of DrillRig: its metadata do not tell the format") from error
    if not isinstance(form, int) or form > latest:
        raise ValueError(f"{source} has the format {form!r}; allowed: up to {latest}, or a later DrillRig")
    return {**found, "digest": properties.get("digest", "")}


def digest_of(content: bytes) -> str:
    """The digest of a file's content whose digest is `NO_DIGEST`."""
    return hashlib.sha256(content).hexdigest()


def with_digest(content: bytes) -> bytes:
    """The content of a file with its digest put in the place of `NO_DIGEST`."""
    return content.replace(NO_DIGEST.encode(), digest_of(content).encode())


def check_digest(source: str, content: bytes, digest: str) -> None:
    """Raise `ValueError` where a file is not as it was written."""
    if len(digest) != len(NO_DIGEST) or digest_of(content.replace(digest.encode(), NO_DIGEST.encode())) != digest:
        raise ValueError(f"{source} is damaged or was changed: it is not what its digest says; export it again")
