"""Who is let in: Host, Origin and, on other addresses than this machine's own, a token."""

from __future__ import annotations

import ipaddress
import secrets
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

from drillrig_env.parameters import refuse

COOKIE = "drillrig_room"
LEAST_TOKEN = 16
"""Least length of a token, in characters."""

_LOCAL = {"localhost", "127.0.0.1", "::1"}


def is_local(host: str) -> bool:
    """Whether an address to listen on is this machine's own, which no other machine reaches."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


@dataclass(frozen=True)
class Door:
    """What a request must show. `host` is the address that is listened on, `token` what a page must know, if any.

    On this machine's own address the Host header must name it: a page from elsewhere whose name leads here (DNS
    rebinding) shows another. Everywhere the Origin of a websocket must be the very host that it asks. Raises
    `ValueError` for another address than this machine's own without a token, and for a token that is short.
    """

    host: str
    token: str | None = None

    def __post_init__(self) -> None:
        if self.token is None and not is_local(self.host):
            raise ValueError(
                f"--host {self.host} lets other machines in, and is not allowed without --token; allowed: a --token of "
                f"{LEAST_TOKEN} characters or more that only those know who may come in, or --host 127.0.0.1"
            )
        if self.token is not None and len(self.token) < LEAST_TOKEN:
            raise refuse("control room", "length of --token", len(self.token), "characters", f">= {LEAST_TOKEN}")

    def refuses_host(self, host: str) -> bool:
        """Whether a Host header names another machine than this one."""
        if not is_local(self.host):
            return not host
        name = _name_of(host)
        return name not in _LOCAL | {self.host}

    def refuses_origin(self, origin: str | None, host: str) -> bool:
        """Whether the Origin of a websocket is another than the host that it asks; one without an Origin is no page."""
        if origin is None:
            return False
        try:
            split = urlsplit(origin)
        except ValueError:
            return True
        return split.scheme not in ("http", "https") or split.netloc.lower() != host.lower()

    def knows(self, query: str, cookies: str) -> bool:
        """Whether the token is in the query `?token=` or in the cookie; true where none is wanted."""
        if self.token is None:
            return True
        jar: SimpleCookie = SimpleCookie()
        try:
            jar.load(cookies)
        except CookieError:
            jar = SimpleCookie()
        shown = [*parse_qs(query).get("token", []), *([jar[COOKIE].value] if COOKIE in jar else [])]
        wanted = self.token.encode()
        return any(secrets.compare_digest(one.encode("utf-8", "replace"), wanted) for one in shown)


def _name_of(host: str) -> str:
    """The name in a Host header, without its port."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""
