"""The secret that a rig asks its clients for, from a file: everybody on the computer can read a command line."""

from __future__ import annotations

from pathlib import Path

from drillrig_env.parameters import refuse

_SHORTEST, _LONGEST = 16, 1024


def read_token(path: str | Path) -> str:
    """The first line of a file as a token. `ValueError` where it is too short to be one, or cannot be read."""
    try:
        first = Path(path).read_text(encoding="utf-8").partition("\n")[0].strip()
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"token: {str(path)!r} is no file that can be read: {error}") from error
    if not _SHORTEST <= len(first) <= _LONGEST:
        allowed = f'{_SHORTEST} to {_LONGEST}, such as of python -c "import secrets; print(secrets.token_hex())"'
        raise refuse("token", "length of the first line", len(first), "characters", allowed)
    return first
