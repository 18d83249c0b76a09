"""Mailboxes: what must arrive does, in order; of what is shown the newest is enough."""

import asyncio
import re

import pytest

from fledge.cockpit import site
from fledge.cockpit.site import MOST, Mailbox, Post
from fledge.cockpit.tells import Frame, Notice, Picture, Vehicle

VEHICLE = Vehicle(0.0, 0.0, 1.0, 0.0, "AUTO", "NONE", "pilot", (0.0, 0.0, 0.0, 0.0), None)
PICTURE = Picture(320.0, 180.0, 108.0, 108.0, ())


def frame(t):
    return Frame(t, (VEHICLE,), PICTURE)


def taken(*letters):
    async def go():
        box = Mailbox()
        for one in letters:
            box.put(one)
        return await box.take(), box

    return asyncio.run(go())


def test_messages_arrive_in_order_and_before_the_newest_frame_and_picture():
    one, two = Notice("one"), Notice("two")
    found, _ = taken(frame(1.0), one, b"old", frame(2.0), two, b"new", frame(3.0))
    assert found == [one, two, frame(3.0), b"new"]


def test_what_was_taken_is_gone():
    async def go():
        box = Mailbox()
        box.put(frame(1.0))
        await box.take()
        box.put(Notice("later"))
        return await box.take()

    assert asyncio.run(go()) == [Notice("later")]


def test_frames_fill_no_mailbox_and_messages_do():
    _, box = taken(*(frame(float(t)) for t in range(10 * MOST)))
    assert not box.full
    found, box = taken(*(Notice(str(i)) for i in range(MOST + 1)))
    assert box.full and found == [Notice(str(i)) for i in range(MOST)]


def test_whoever_waits_is_woken_from_another_thread():
    async def go():
        box = Mailbox()
        waiting = asyncio.create_task(box.take())
        await asyncio.sleep(0)
        await asyncio.to_thread(box.put, Notice("from outside"))
        return await asyncio.wait_for(waiting, 5.0)

    assert asyncio.run(go()) == [Notice("from outside")]


def test_the_post_knows_one_and_all():
    async def go():
        post = Post()
        post.mailboxes |= {1: Mailbox(), 2: Mailbox()}
        post(None, Notice("all"))
        post(2, Notice("two"))
        post(3, Notice("nobody"))
        return [await post.mailboxes[client].take() for client in (1, 2)]

    assert asyncio.run(go()) == [[Notice("all")], [Notice("all"), Notice("two")]]


def test_every_view_has_its_room_on_the_page():
    page = (site.STATIC / "index.html").read_text()
    for view in site.VIEWS:
        assert f'data-view="{view}"' in page


@pytest.mark.parametrize("path", sorted(site.STATIC.rglob("*.js")), ids=lambda path: path.name)
def test_scripts_import_what_there_is(path):
    for target in re.findall(r'from "(\.[^"]+)"', path.read_text()):
        assert (path.parent / target).exists(), target
