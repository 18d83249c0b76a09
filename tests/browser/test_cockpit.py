"""The cockpit in a real browser: Debian's Chromium, driven by Playwright, with a gamepad that a script moves.

The gamepad is the browser's own interface with another device behind it; everything from there on is real: the page,
the WebSocket, the server's process, the simulator and the lab's twin.
"""

import json
import os
import shutil
import time
from math import hypot

import pytest
from visitor import cockpit

from fledge.cockpit.seat import Seats
from fledge.learning.demonstrations import Order
from fledge.manoeuvres import MANOEUVRES
from fledge.pilots import HumanModel
from fledge.runs import logbook
from fledge.storage import read_flight
from fledge.world import Reason

CHROMIUM = shutil.which("chromium")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None and os.environ.get("CI") != "true", reason="no chromium here"),
]

FORWARD, LEFT, UP = 3, 2, 1
"""Axes of a standard gamepad; down and right are positive."""
LAND, TAKE_OVER, HAND_BACK, ARM = 0, 3, 2, 9
"""Buttons of it, as the page maps them."""
PAD = """
window.pad = {id: "Scripted pad", index: 0, connected: true, mapping: "standard", timestamp: 0,
  axes: [0, 0, 0, 0], buttons: Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0}))};
navigator.getGamepads = () => [window.pad];
"""
NEUTRAL = 0.06
"""Share of a stick about its middle in which the page hears nothing."""


class Tab:
    """A page of the cockpit, and the frames it was sent."""

    def __init__(self, browser, url, **options):
        self.frames, self.errors = [], []
        self.page = browser.new_page(viewport={"width": 1280, "height": 720}, **options)
        self.page.set_default_timeout(30_000)
        self.page.add_init_script(PAD)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda line: self.errors.append(line.text))
        self.page.on("websocket", lambda socket: socket.on("framereceived", self._receive))
        self.page.goto(url)

    def _receive(self, payload):
        if isinstance(payload, str) and '"kind":"frame"' in payload:
            self.frames.append(json.loads(payload))

    @property
    def uav(self):
        return self.frames[-1]["vehicles"][0]

    def until(self, condition, within=40.0):
        end = time.monotonic() + within
        while not condition():
            assert time.monotonic() < end, (self.frames[-1:], self.errors)
            self.page.wait_for_timeout(20)

    def sticks(self, **axes):
        """Full scale is 1: forward, left, up."""
        raw = [0.0, 0.0, 0.0, 0.0]
        for index, name in ((FORWARD, "forward"), (LEFT, "left"), (UP, "up")):
            share = max(-1.0, min(1.0, axes.get(name, 0.0)))
            raw[index] = -(
                share + (NEUTRAL if share > 0 else -NEUTRAL if share < 0 else 0.0) * (1 - abs(share))
            )
        self.page.evaluate("raw => { window.pad.axes = raw; }", raw)

    def press(self, button, seconds=0.1):
        self.page.evaluate("i => { window.pad.buttons[i].pressed = true; }", button)
        self.page.wait_for_timeout(1000 * seconds)
        self.page.evaluate("i => { window.pad.buttons[i].pressed = false; }", button)

    def follow(self, seconds, axes=("forward", "left")):
        """Keep blue dot and circle where they should be; whether all UGVs were in view, frame by frame."""
        end, seen = time.monotonic() + seconds, len(self.frames)
        while time.monotonic() < end:
            frame = self.frames[-1]
            p, metres = frame["picture"], self.uav["z"] / 374.7
            wanted = {
                "forward": 1.2 * (180.0 - p["v"]) * metres,
                "left": 1.2 * (320.0 - p["u"]) * metres,
                "up": 1.5 * (p["radius"] - p["ideal_radius"]) / p["ideal_radius"],
            }
            self.sticks(**{axis: wanted[axis] for axis in axes})
            self.page.wait_for_timeout(40)
        self.sticks()
        return [
            all(0.0 <= u <= 640.0 and 0.0 <= v <= 360.0 for u, v in frame["picture"]["marks"])
            for frame in self.frames[seen:]
        ]

    def start(self, pilot, world="simulator", manoeuvre="fixed-altitude"):
        page = self.page
        for name, value in (("world", world), ("manoeuvre", manoeuvre), ("pilot", pilot)):
            if page.locator(f"#{name}").is_enabled():
                page.select_option(f"#{name}", value)
        page.click("#start")
        page.wait_for_selector("#arm:enabled")
        self.arm()

    def arm(self, within=40.0):
        """As a person does: press, look, and press anew where that was too early."""
        end = time.monotonic() + within
        while self.uav["mode"] in ("INIT", "READY"):
            assert time.monotonic() < end, (self.frames[-1:], self.errors)
            self.press(ARM, 0.2)
            self.page.wait_for_timeout(1_500)


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        options = ["--no-sandbox", "--disable-background-networking"]
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        yield opened
        opened.close()


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cockpit")
    logbook.fill(folder / "demos", [Order(one, 2, 480) for one in MANOEUVRES], HumanModel(), 0)
    with cockpit(folder) as opened:
        yield opened


@pytest.fixture
def tab(browser, server):
    opened = Tab(browser, server.url + "/fly")
    yield opened
    opened.page.close()
    assert not opened.errors


def test_a_person_takes_off_follows_the_ugvs_for_half_a_minute_and_lands(tab):
    tab.start("person", "twin")
    tab.until(lambda: tab.frames[-1]["note"] == "fly", within=90.0)
    views = tab.follow(30.0)
    assert len(views) > 300 and all(views), [i for i, seen in enumerate(views) if not seen]
    assert tab.uav["commander"] == "person" and tab.frames[-1]["note"] == "fly"
    assert tab.page.get_attribute("#commander", "data-value") == "person"
    tab.press(LAND, 0.5)
    tab.until(lambda: tab.uav["mode"] == "LAND")
    tab.until(lambda: tab.uav["z"] < 0.1, within=60.0)


def test_a_policy_is_taken_over_and_handed_back(tab):
    tab.start("servo")
    tab.press(TAKE_OVER)
    tab.until(lambda: tab.uav["mode"] == "MANUAL")
    tab.sticks(forward=0.3)
    tab.until(lambda: abs(tab.uav["sent"][0] - 0.3) < 0.05)
    tab.until(lambda: tab.page.get_attribute("#commander", "data-value") == "person")
    tab.sticks()
    tab.until(lambda: abs(tab.uav["sent"][0]) < 0.05)
    tab.press(HAND_BACK, 0.3)
    tab.until(lambda: tab.uav["mode"] == "AUTO" and tab.uav["commander"] == "pilot")
    # A stick that is moved far enough takes over by itself.
    tab.sticks(left=0.8)
    tab.until(lambda: tab.uav["mode"] == "MANUAL" and tab.uav["sent"][1] > 0.5)
    tab.sticks()


def test_a_tab_that_is_closed_in_flight_leaves_a_hovering_vehicle(browser, server):
    pilot, spectator = (Tab(browser, server.url + "/fly") for _ in range(2))
    pilot.start("servo")
    pilot.press(TAKE_OVER)
    pilot.sticks(forward=0.5)
    spectator.until(lambda: spectator.frames and spectator.uav["mode"] == "MANUAL")
    spectator.until(lambda: spectator.uav["sent"][0] > 0.4)
    flying = len(spectator.frames)
    pilot.page.close()
    spectator.until(lambda: spectator.uav["mode"] == "STOPPED")
    stopped = next(one for one in spectator.frames[flying:] if one["vehicles"][0]["mode"] == "STOPPED")
    assert stopped["silent"] < Seats().silence + 0.1 and stopped["vehicles"][0]["reason"] == "LINK_LOST"
    spectator.until(lambda: spectator.frames[-1]["t"] > stopped["t"] + 3.0)
    before, after = ((one["x"], one["y"]) for one in (spectator.frames[-30]["vehicles"][0], spectator.uav))
    assert hypot(before[0] - after[0], before[1] - after[1]) < 0.1
    spectator.page.close()


def test_a_climb_is_demonstrated_watched_and_learnt_from(tab, server):
    page = tab.page
    page.click("nav [data-view=demonstrate]")
    page.click("[data-task=climb]")
    page.click("#record")
    tab.until(lambda: tab.frames and tab.frames[-1]["rows"] > 0)
    tab.follow(6.0, axes=("up",))
    page.click("#finish")
    page.click("#keep")
    path = server.folder / "demos" / "climb-002.mcap"
    tab.until(lambda: path.exists())
    flight = read_flight(path)
    assert flight.rows >= 80 and flight.pilot == "person" and flight.axes == (2,)
    assert not (flight.episode.verdicts[0].reason == Reason.TAKE_OVER).any()
    assert abs(flight.episode.action.up).max() > 0.0 and abs(flight.episode.action.forward).max() == 0.0

    page.click("nav [data-view=watch]")
    page.click("[data-flight='climb-002']")
    tab.until(lambda: int(page.get_attribute("#scrub", "max")) == flight.rows - 1)
    page.fill("#scrub", "40")
    tab.until(lambda: page.get_attribute("#clock", "data-value") == "40")
    page.click("#play")
    tab.until(lambda: int(page.get_attribute("#clock", "data-value")) > 50)

    page.click("nav [data-view=train]")
    page.fill("#epochs", "4")
    page.click("#train")
    page.wait_for_selector("#fly-it:visible:enabled", timeout=120_000)
    page.click("#fly-it")
    page.wait_for_selector("#arm:enabled")
    tab.arm()
    tab.until(lambda: tab.uav["commander"] == "pilot")
    assert "primitive-000" in page.inner_text("#commander")


def test_the_flight_that_was_asked_for_last_is_shown_however_late_others_come(tab):
    page, late = tab.page, []
    page.click("nav [data-view=watch]")
    tab.until(lambda: page.inner_text("#watched"))
    page.route("**/climb-000*", lambda route: late.append(route))
    page.click("[data-flight='climb-000']")
    tab.until(lambda: late)
    page.click("[data-flight='climb-001']")
    tab.until(lambda: page.inner_text("#watched") == "climb-001")
    page.fill("#scrub", "40")
    with page.expect_response("**/climb-000*"):
        late[0].continue_()
    page.click("[data-flight='climb-001']")  # it is shown already, and stays where it is
    page.wait_for_timeout(300)
    assert page.inner_text("#watched") == "climb-001"
    assert page.get_attribute("#clock", "data-value") == "40"


def test_a_spectator_sees_and_cannot_touch(browser, server):
    pilot, spectator = (Tab(browser, server.url + "/fly") for _ in range(2))
    pilot.start("servo")
    spectator.until(lambda: spectator.frames)
    assert spectator.page.locator("#takeover").is_disabled()
    spectator.press(TAKE_OVER)
    spectator.sticks(forward=1.0)
    t = spectator.frames[-1]["t"]
    spectator.until(lambda: spectator.frames[-1]["t"] > t + 1.0)
    assert spectator.uav["mode"] in ("AUTO", "SHIELDED")
    for one in (pilot, spectator):
        one.page.close()


def test_a_gamepad_that_is_unplugged_is_missed_in_words(tab):
    tab.start("servo")
    tab.page.evaluate("navigator.getGamepads = () => [null]")
    tab.page.wait_for_selector("#banner:visible")
    assert "pad" in tab.page.inner_text("#banner").lower()


def test_it_is_reached_by_keyboard_alone(tab):
    page = tab.page
    page.click("#start")
    page.wait_for_selector("#arm:enabled")
    page.keyboard.press("g")
    tab.until(lambda: tab.uav["mode"] in ("AUTO", "SHIELDED"))
    page.keyboard.press("t")
    tab.until(lambda: tab.uav["mode"] == "MANUAL")
    page.keyboard.down("ArrowUp")
    tab.until(lambda: tab.uav["sent"][0] > 0.1)
    page.keyboard.up("ArrowUp")
    page.keyboard.press("Escape")
    tab.until(lambda: abs(tab.uav["sent"][0]) < 0.05)


@pytest.mark.parametrize("view", ("fly", "demonstrate", "watch", "train"))
@pytest.mark.parametrize(("width", "height"), ((1280, 720), (1024, 768), (820, 1180)))
def test_every_view_fits_its_screen(browser, server, view, width, height):
    tab = Tab(browser, f"{server.url}/{view}")
    tab.page.set_viewport_size({"width": width, "height": height})
    tab.page.wait_for_timeout(300)
    wide = tab.page.evaluate("document.documentElement.scrollWidth")
    assert wide <= width
    if view == "fly":
        assert tab.page.evaluate("document.documentElement.scrollHeight") <= height
    names = "[...document.querySelectorAll('button, select, input')].filter(one => one.checkVisibility())"
    nameless = tab.page.evaluate(
        f"{names}.filter(one => !(one.ariaLabel || one.labels?.length || one.textContent.trim() || one.title))"
        ".map(one => one.outerHTML)"
    )
    assert nameless == []
    tab.page.close()
    assert not tab.errors
