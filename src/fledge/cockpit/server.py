"""Opens the cockpit: a socket, the deck's thread, and uvicorn until somebody ends it."""

import secrets
import socket
import ssl
from ipaddress import ip_address
from pathlib import Path
from typing import Any, NamedTuple

import uvicorn

from fledge.cockpit.asks import LONGEST_NAME
from fledge.cockpit.deck import Deck
from fledge.cockpit.guard import Guard
from fledge.cockpit.messages import LONGEST_HEARD
from fledge.cockpit.site import Post, site
from fledge.cockpit.stock import Stock
from fledge.errors import BadFile, FledgeError

PING = 5.0
"""[s] after which a browser that says nothing is asked whether it is there, and as long again until it is given up."""
BACKLOG = 64


class Address(NamedTuple):
    """Where it is open, and to whom."""

    host: str
    port: int
    token: str = ""
    certificate: Path | None = None
    key: Path | None = None

    @property
    def url(self) -> str:
        """What to open in a browser."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        question = f"?token={self.token}" if self.token else ""
        return f"http{'s' if self.certificate else ''}://{host}:{self.port}/fly{question}"


def address(host: str, port: int, certificate: Path | None, key: Path | None) -> Address:
    """The address, with a new token where others than this machine can reach it."""
    return Address(host, port, "" if _is_loopback(host) else secrets.token_urlsafe(16), certificate, key)


def recipe(where: Address) -> list[str]:
    """What people are told who open it to others without a certificate."""
    if where.certificate or _is_loopback(where.host):
        return []
    return [
        "without TLS browsers give no gamepad to pages from elsewhere, and whoever is on the way reads the token;",
        "make a certificate, then give --certificate cert.pem --key key.pem:",
        "  openssl req -x509 -newkey rsa:2048 -nodes -days 365 -subj /CN=fledge \\",
        f"    -addext subjectAltName=IP:{where.host} -keyout key.pem -out cert.pem",
    ]


class Cockpit:
    """An open cockpit."""

    def __init__(
        self, where: Address, demos: Path, policies: Path, attached: tuple[str, int] | None = None
    ) -> None:
        """Open it; `attached` is where the sticks of a running flight are, if it is for that one.

        Raises:
            FledgeError: the port is taken, the certificate is none, or a folder cannot be written.
        """
        self._socket = _opened(where)
        self.where = where._replace(port=self._socket.getsockname()[1])
        post = Post()
        self.stock = Stock(demos, policies, post, attached)
        self._deck = Deck(self.stock, post)
        config = uvicorn.Config(
            Guard(site(self.stock, self._deck, post), where.host, where.token),
            ws="websockets-sansio",
            ws_max_size=LONGEST_HEARD,
            ws_ping_interval=PING,
            ws_ping_timeout=PING,
            ws_per_message_deflate=False,  # a frame is small, and compressing it takes the time of a tick
            h11_max_incomplete_event_size=16 * LONGEST_NAME + 8192,
            timeout_graceful_shutdown=2,
            log_config=None,  # else uvicorn closes every handler that the process had
            log_level="warning",
            access_log=False,
            server_header=False,
            proxy_headers=False,
            lifespan="off",
            ssl_certfile=where.certificate,
            ssl_keyfile=where.key,
        )
        try:
            config.load()
        except (OSError, ssl.SSLError) as error:
            self._socket.close()
            raise BadFile(
                where.certificate or "--certificate", f"no certificate with its key: {error}"
            ) from error
        self._server = uvicorn.Server(config)

    def run(self) -> dict[str, Any]:
        """Serve until Ctrl-C or SIGTERM; what came of it, in plain JSON values."""
        self._deck.start()
        try:
            self._server.run([self._socket])
        except KeyboardInterrupt:  # which uvicorn raises again once it is done
            pass
        finally:
            self._deck.stop()
            self.stock.close()
            self._socket.close()
        return self._deck.summary()


def _opened(where: Address) -> socket.socket:
    try:
        info = socket.getaddrinfo(where.host, where.port, type=socket.SOCK_STREAM)[0]
        opened = socket.socket(info[0], socket.SOCK_STREAM)
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        opened.bind(info[4])
        opened.listen(BACKLOG)
    except OSError as error:
        raise FledgeError(
            f"cannot listen at {where.host}:{where.port}: {error.strerror or error}; valid is a free --port"
        ) from error
    return opened


def _is_loopback(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
