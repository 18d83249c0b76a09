"""Who may come in, request by request, as an ASGI server would ask."""

import asyncio

import pytest

from fledge.cockpit.guard import HEADERS, REFUSED, Guard

TOKEN = "s3cr3t-token"


async def inside(scope, receive, send):
    """The application behind: lets everybody in."""
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
    elif scope["type"] == "http":
        await send({"type": "http.response.start", "status": 200, "headers": [(b"cache-control", b"public")]})
        await send({"type": "http.response.body", "body": b"welcome"})
    else:
        await send({"type": scope["type"]})


def asked(kind="http", token="", listens="127.0.0.1", query="", scheme="http", **headers):
    """What a guard answers."""
    said = []

    async def receive():
        return {"type": "websocket.connect"}

    async def send(message):
        said.append(message)

    named = [(name.encode(), value.encode("latin-1")) for name, value in headers.items()]
    scope = {"type": kind, "headers": named, "query_string": query.encode(), "scheme": scheme, "path": "/"}
    asyncio.run(Guard(inside, listens, token)(scope, receive, send))
    return said


def let_in(*args, **kwargs):
    first = asked(*args, **kwargs)[0]
    return first.get("status") == 200 or first["type"] == "websocket.accept"


@pytest.mark.parametrize("host", ("127.0.0.1:8000", "localhost", "localhost:80", "[::1]:8000", "127.9.9.9"))
@pytest.mark.parametrize("kind", ("http", "websocket"))
def test_our_own_addresses_are_ours(kind, host):
    assert let_in(kind, host=host)
    assert let_in(kind, host=host, origin=f"http://{host}")


@pytest.mark.parametrize(
    "host",
    ("", "evil.example", "127.0.0.1.evil.example", "10.0.0.1", "localhost.evil.example:80", "[", "a@b:c"),
)
@pytest.mark.parametrize("kind", ("http", "websocket"))
def test_a_name_that_was_made_to_lead_here_is_none_of_ours(kind, host):
    assert not let_in(kind, host=host)
    assert not let_in(kind)


@pytest.mark.parametrize(
    "origin", ("http://evil.example", "null", "http://127.0.0.1:9", "file://", "http://[")
)
def test_other_pages_are_kept_out_by_their_origin(origin):
    for kind in ("http", "websocket"):
        assert not let_in(kind, host="127.0.0.1:8000", origin=origin)


def test_a_refused_websocket_is_closed_with_the_code_for_that():
    assert asked("websocket", host="evil.example")[-1]["code"] == REFUSED


def test_everywhere_is_everywhere_and_a_name_is_that_name():
    assert let_in(listens="0.0.0.0", host="192.168.7.9:8000")
    assert let_in(listens="lab.example", host="lab.example:8000")
    assert not let_in(listens="0.0.0.0", host="lab.example")


def test_without_the_token_nobody_comes_in():
    host = {"host": "127.0.0.1"}
    for kind in ("http", "websocket"):
        assert not let_in(kind, TOKEN, **host)
        assert not let_in(kind, TOKEN, query="token=wrong", **host)
        assert not let_in(kind, TOKEN, cookie="fledge=wrong", **host)
        assert not let_in(kind, TOKEN, cookie="fledge=\xe9", query="token=%C3%A9", **host)
        assert not let_in(kind, TOKEN, cookie="other=" + TOKEN, **host)
        assert let_in(kind, TOKEN, query=f"token={TOKEN}", **host)
        assert let_in(kind, TOKEN, cookie=f"a=b; fledge={TOKEN}", **host)


@pytest.mark.parametrize(("scheme", "secure"), (("http", False), ("https", True)))
def test_the_address_with_the_token_leaves_a_cookie_that_no_script_reads(scheme, secure):
    answer = asked(token=TOKEN, query=f"token={TOKEN}", scheme=scheme, host="127.0.0.1")[0]
    cookie = dict(answer["headers"])[b"set-cookie"].decode()
    assert TOKEN in cookie and "HttpOnly" in cookie and "SameSite=Strict" in cookie
    assert ("Secure" in cookie) == secure
    later = asked(token=TOKEN, cookie=f"fledge={TOKEN}", host="127.0.0.1")[0]
    assert b"set-cookie" not in dict(later["headers"])


def test_every_answer_forbids_what_is_not_ours_and_is_never_kept():
    for host in ("127.0.0.1", "evil.example"):
        headers = dict(asked(host=host)[0]["headers"])
        assert HEADERS.items() <= {name.decode(): value.decode() for name, value in headers.items()}.items()


def test_what_is_no_request_passes():
    assert asked("lifespan") == [{"type": "lifespan"}]
