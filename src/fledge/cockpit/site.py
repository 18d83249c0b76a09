"""The cockpit's web site: four views of one page, stored flights as JSON, and a WebSocket for everything that is live.

    /fly /demonstrate /watch /train    the page (`static/`)
    /api/flights, /api/flights/NAME    stored flights (`shelf`)
    /ws                                what page and server say to each other (`messages`), and pictures as JPEG

Every client has a mailbox. What must arrive waits there in order; of frames and pictures it keeps the newest, so who
is slow sees fewer of them, and nobody else notices. Who does not read at all for so long that `MOST` messages wait is
sent away, and so is who talks without end.
"""

import asyncio
import logging
import time
from collections import deque
from itertools import count
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, RedirectResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from fledge.cockpit import tells
from fledge.cockpit.deck import Deck
from fledge.cockpit.guard import REFUSED
from fledge.cockpit.messages import decode, encode
from fledge.cockpit.stock import Stock
from fledge.errors import BadFile, FledgeError, UnknownName
from fledge.lab import Malformed

STATIC = Path(__file__).with_name("static")
VIEWS = ("fly", "demonstrate", "watch", "train")
MOST = 200
"""Messages that may wait for a client that does not read; chosen."""
CLIENTS = 32
"""That may be there at once; chosen."""
RATE, BURST = 240.0, 480.0
"""[1/s] messages that a client may send, and how many at once: twice what its sticks may."""
MOST_MALFORMED = 50
"""Messages of a client that were none; chosen: a page sends none."""

logger = logging.getLogger(__name__)


class Mailbox:
    """What one client is yet to be told; filled from any thread, emptied in the loop's."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._letters: deque[Any] = deque()
        self._frame: tells.Frame | None = None
        self._picture: bytes | None = None
        self._news = asyncio.Event()
        self.full = False

    def put(self, told: Any) -> None:
        """A message, or the bytes of a picture."""
        if isinstance(told, bytes):
            self._picture = told
        elif isinstance(told, tells.Frame):
            self._frame = told
        elif len(self._letters) < MOST:
            self._letters.append(told)
        else:
            self.full = True
        self._loop.call_soon_threadsafe(self._news.set)

    async def take(self) -> list[Any]:
        """All there is; waits until there is something."""
        await self._news.wait()
        self._news.clear()
        letters = [self._letters.popleft() for _ in range(len(self._letters))]
        newest, self._frame, self._picture = (self._frame, self._picture), None, None
        return letters + [one for one in newest if one is not None]


class Post:
    """Who has a mailbox, and what goes into which; may be called from any thread."""

    def __init__(self) -> None:
        self.mailboxes: dict[int, Mailbox] = {}

    def __call__(self, client: int | None, told: Any) -> None:
        """Something said to a client, or to all."""
        boxes = [*self.mailboxes.values()] if client is None else [self.mailboxes.get(client)]
        for box in boxes:
            if box is not None:
                box.put(told)


def site(stock: Stock, deck: Deck, post: Post) -> Starlette:
    """The application; whoever runs it starts and stops the deck."""
    numbers = count(1)

    async def page(request: Request) -> Response:
        return FileResponse(STATIC / "index.html")

    async def home(request: Request) -> Response:
        return RedirectResponse("/fly" + (f"?{request.url.query}" if request.url.query else ""))

    async def flights(request: Request) -> Response:
        return JSONResponse({"flights": await run_in_threadpool(stock.shelf.listing)})

    async def flight(request: Request) -> Response:
        return JSONResponse(await run_in_threadpool(stock.shelf.whole, request.path_params["name"]))

    async def live(socket: WebSocket) -> None:
        if len(post.mailboxes) >= CLIENTS:
            await socket.close(REFUSED, f"{CLIENTS} are here already")
            return
        await socket.accept()
        client, box = next(numbers), Mailbox()
        for told in (stock.welcome(), await run_in_threadpool(stock.harvest), stock.school.lesson):
            box.put(told)
        post.mailboxes[client] = box
        deck.join(client)
        tasks = [
            asyncio.create_task(_tell(socket, box)),
            asyncio.create_task(_hear(socket, deck, client, box)),
        ]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            del post.mailboxes[client]
            deck.leave(client)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def refused(request: Request, error: Exception) -> Response:
        status = 404 if isinstance(error, UnknownName) else 422 if isinstance(error, BadFile) else 400
        return JSONResponse({"error": str(error)}, status)

    return Starlette(
        routes=[
            Route("/", home),
            *(Route(f"/{view}", page) for view in VIEWS),
            Route("/api/flights", flights),
            Route("/api/flights/{name:path}", flight),
            WebSocketRoute("/ws", live),
            Mount("/static", StaticFiles(directory=STATIC)),
        ],
        exception_handlers={FledgeError: refused},
    )


async def _tell(socket: WebSocket, box: Mailbox) -> None:
    """Says what is in the mailbox, as fast as the client reads."""
    try:
        while not box.full:
            for told in await box.take():
                await _say(socket, told)
        await socket.close(REFUSED, "you do not read what you are told")
    except (
        WebSocketDisconnect,
        RuntimeError,
    ):  # which Starlette raises for a socket that is closed meanwhile
        return


async def _say(socket: WebSocket, told: Any) -> None:
    if isinstance(told, bytes):
        await socket.send_bytes(told)
        return
    try:
        text = encode(told)
    except FledgeError:  # a number that has no place in a message; the next one will do
        logger.exception("not said")
        return
    await socket.send_text(text)


async def _hear(socket: WebSocket, deck: Deck, client: int, box: Mailbox) -> None:
    """Hands on what the client says."""
    room, filled, malformed = BURST, time.monotonic(), 0
    try:
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            now = time.monotonic()
            room, filled = min(room + RATE * (now - filled), BURST) - 1.0, now
            if room < 0.0:
                await socket.close(REFUSED, f"more than {RATE:g} messages a second")
                return
            said = decode(message.get("text") or message.get("bytes") or "")
            if not isinstance(said, Malformed):
                deck.hear(client, said)
                continue
            malformed += 1
            box.put(tells.Notice(f"not understood: {said.why}"[:500], "error"))
            if malformed > MOST_MALFORMED:
                await socket.close(REFUSED, "too much that is not understood")
                return
    except (WebSocketDisconnect, RuntimeError):
        return
