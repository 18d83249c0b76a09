"""Who may come in: the same page in the same browser, with the token where there is one; nobody else's page.

* **Host.** A request names the host it thinks it talks to. Only our own addresses will do, so that no name of somebody
  else's, made to lead here, does (DNS rebinding).
* **Origin.** A browser says which page a WebSocket is opened from; it must be ours.
* **Token.** Beyond this machine one is demanded: in the address the first time, in a cookie from then on. It is
  compared in constant time.

Every answer forbids the browser to load anything from elsewhere, to be framed, and to guess types.
"""

import secrets
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from typing import Any
from urllib.parse import SplitResult, parse_qs, urlsplit

from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

COOKIE = "fledge"
HEADERS = {
    "content-security-policy": "default-src 'self'; img-src 'self' blob: data:; object-src 'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}
REFUSED = 1008
"""WebSocket's code for what a rule forbids (RFC 6455, 7.4.1)."""
NAMES = ("localhost",)


@dataclass(frozen=True, slots=True)
class Guard:
    """Stands before an application."""

    app: ASGIApp
    host: str
    """Where it listens."""
    token: str = ""
    """Empty where everybody on this machine may come in."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request pass, or say why not."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]}
        why = self._why_not(scope, headers)
        if not why:
            await self.app(scope, receive, self._marked(scope, send))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": REFUSED, "reason": why})
        else:
            await JSONResponse({"error": why}, 403)(scope, receive, self._marked(scope, send))

    def _why_not(self, scope: Scope, headers: dict[str, str]) -> str:
        host = headers.get("host", "")
        if not self._ours(host):
            return f"host {host[:80]!r} is not this cockpit's"
        origin = headers.get("origin")
        if origin is not None and _split(origin).netloc != host:
            return f"a page of {origin[:80]!r} has no business here"
        if self.token and not any(secrets.compare_digest(one, self.token) for one in _tokens(scope, headers)):
            return "the token is missing or wrong: open the address that `fledge cockpit` printed"
        return ""

    def _ours(self, host: str) -> bool:
        name = _split(f"//{host}").hostname or ""
        if name in (*NAMES, self.host):
            return True
        try:
            return ip_address(name).is_loopback or ip_address(self.host).is_unspecified
        except ValueError:  # a name, and not ours
            return False

    def _marked(self, scope: Scope, send: Send) -> Send:
        """Adds the headers, and the cookie where the address had the token."""

        async def sending(message: Message) -> None:
            if message["type"] == "http.response.start":
                more = [(name.encode(), value.encode()) for name, value in self._headers(scope).items()]
                known = {name for name, _ in more}
                message["headers"] = [*(one for one in message["headers"] if one[0] not in known), *more]
            await send(message)

        return sending

    def _headers(self, scope: Scope) -> dict[str, str]:
        if not self.token or self.token not in _queried(scope):
            return HEADERS
        secure = "; Secure" if scope["scheme"] in ("https", "wss") else ""
        return HEADERS | {"set-cookie": f"{COOKIE}={self.token}; HttpOnly; SameSite=Strict; Path=/{secure}"}


def _split(address: str) -> SplitResult:
    """The parts of an address; of none, no part."""
    try:
        return urlsplit(address)
    except ValueError:
        return urlsplit("")


def _tokens(scope: Scope, headers: dict[str, str]) -> list[str]:
    """Those that a request has, printable ones."""
    jar: Any = SimpleCookie()
    try:
        jar.load(headers.get("cookie", ""))
    except CookieError:
        return []
    found = [*_queried(scope), *(one.value for name, one in jar.items() if name == COOKIE)]
    return [one for one in found if one.isascii()]


def _queried(scope: Scope) -> list[str]:
    return parse_qs(scope["query_string"].decode("latin-1")).get("token", [])
