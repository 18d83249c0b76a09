"""A cockpit's server, as a process, with visitors by WebSocket: flights, seats, recordings, and all that is bad."""

import json
import signal
import socket
import time

import pytest
from processes import process
from visitor import Visitor, cockpit
from websockets.exceptions import InvalidStatus

from fledge.cockpit.asks import Cancel, Discard, Fly, Keep, Pause, Reset, Resume, Seat, Train
from fledge.cockpit.seat import Seats
from fledge.cockpit.tells import Flight, Harvest, Lesson, Notice, Stored, Welcome
from fledge.storage import read_flight
from fledge.world import Reason

SILENCE = Seats().silence
SERVO = Fly("fixed-altitude", "servo", "stop-tube")
CLIMB = Fly("climb", "person", "stop-tube", record="demonstration")


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with cockpit(tmp_path_factory.mktemp("cockpit")) as opened:
        yield opened


@pytest.fixture
def visitor(server):
    with Visitor(server.url) as one:
        yield one


def state(visitor):
    return visitor.last(Flight) and visitor.last(Flight).state


def noticed(visitor, words):
    visitor.until(lambda: any(words in one.text for one in visitor.told if isinstance(one, Notice)))


@pytest.mark.slow
def test_a_person_takes_a_flight_over_and_hands_it_back(server, visitor):
    visitor.sits().begins(SERVO)
    visitor.until(lambda: visitor.uav.mode == "AUTO" and visitor.uav.commander == "pilot")
    before = visitor.uav.sent
    visitor.hold((0.4, 0.0, 0.0, 0.0), arm=True, switch=True)
    visitor.until(lambda: visitor.uav.sent == (0.4, 0.0, 0.0, 0.0))
    assert (visitor.uav.mode, visitor.uav.commander, visitor.uav.reason) == ("MANUAL", "person", "TAKE_OVER")
    assert before != visitor.uav.sent
    visitor.hold(arm=True, hand_back=True)
    visitor.until(lambda: visitor.uav.mode == "RECOVER")
    visitor.hold(arm=True)
    visitor.until(lambda: visitor.uav.mode == "AUTO")


@pytest.mark.slow
def test_any_vehicle_can_be_stopped_and_driven(visitor):
    visitor.sits().begins(SERVO)
    visitor.hold(vehicle=1, arm=True, stop=True)
    visitor.until(lambda: visitor.frame.vehicles[1].mode == "STOPPED")
    assert visitor.frame.vehicles[2].mode in ("AUTO", "SHIELDED")
    visitor.hold((0.2, 0.0, 0.0, 0.0), vehicle=1, arm=True, switch=True)
    visitor.until(lambda: visitor.frame.vehicles[1].commander == "person")
    assert visitor.uav.mode in ("AUTO", "SHIELDED")


@pytest.mark.slow
def test_who_falls_silent_hovers_within_the_watchdogs_time(visitor):
    visitor.sits().begins(SERVO)
    visitor.hold((0.5, 0.0, 0.0, 0.0), arm=True, switch=True)
    visitor.until(lambda: visitor.uav.sent[0] == 0.5)
    began = time.monotonic()
    visitor.let_go()
    visitor.until(lambda: visitor.uav.mode == "STOPPED")
    assert time.monotonic() - began < SILENCE + 0.2
    assert (visitor.uav.commander, visitor.uav.reason) == ("nobody", "LINK_LOST")
    visitor.until(lambda: abs(visitor.uav.sent[0]) < 0.1)


@pytest.mark.slow
def test_whoever_leaves_frees_the_seat_and_the_vehicle_hovers(server):
    with Visitor(server.url) as first, Visitor(server.url) as second:
        first.sits().begins(SERVO)
        first.hold((0.5, 0.0, 0.0, 0.0), arm=True, switch=True)
        second.say(Seat(True))
        second.until(lambda: any(getattr(one, "seat", "") == "waiting" for one in second.told))
        second.say(SERVO)
        noticed(second, "seat first")
        second.until(lambda: second.uav.mode == "MANUAL")
        first.__exit__()
        second.until(lambda: any(getattr(one, "seat", "") == "mine" for one in second.told))
        second.until(lambda: second.uav.mode == "STOPPED")


@pytest.mark.slow
def test_a_demonstration_is_kept_with_its_marks_beside_the_synthetic_operators(server, visitor):
    visitor.sits().begins(CLIMB)
    visitor.until(lambda: visitor.frame.rows >= 40)
    visitor.say(Pause())
    visitor.until(lambda: state(visitor) == "paused")
    rows = visitor.frame.rows
    visitor.say(SERVO)
    noticed(visitor, "keep it or throw it away")
    visitor.say(Keep())
    visitor.until(lambda: visitor.last(Stored))
    stored = visitor.last(Stored)
    flight = read_flight(server.folder / "demos" / f"{stored.name}.mcap")
    assert (flight.rows, flight.pilot, flight.net, flight.axes) == (rows, "person", "stop-tube", (2,))
    assert stored.rows == rows and stored.synthetic is not None and 0.0 < stored.synthetic.radius < 100.0
    visitor.until(lambda: dict_of(visitor.last(Harvest))["climb"] == rows)
    listed = json.loads(server.get("/api/flights")[1])["flights"]
    assert listed[0]["name"] == stored.name
    whole = json.loads(server.get(f"/api/flights/{stored.name}")[1])
    assert len(whole["columns"]["t"]) == rows and whole["marks"]["radius"] == pytest.approx(
        stored.marks.radius, abs=1e-4
    )


def dict_of(harvest):
    return {heap.manoeuvre: heap.rows for heap in harvest.heaps}


@pytest.mark.slow
def test_what_is_thrown_away_or_begun_anew_leaves_nothing(server, visitor):
    before = sorted((server.folder / "demos").iterdir())
    visitor.sits().begins(Fly("descend", "person", "stop-tube", record="demonstration"))
    visitor.until(lambda: visitor.frame.rows > 5)
    visitor.hold(arm=False)
    visitor.say(Reset())
    visitor.until(lambda: state(visitor) == "none")
    visitor.until(lambda: state(visitor) == "running" and visitor.frame.rows == 0)
    visitor.say(Discard())
    visitor.until(lambda: state(visitor) == "over")
    assert sorted((server.folder / "demos").iterdir()) == before


@pytest.mark.slow
def test_pause_stops_time_and_resume_lets_it_go_on(visitor):
    visitor.sits().begins(SERVO)
    visitor.say(Pause())
    visitor.until(lambda: state(visitor) == "paused")
    time.sleep(0.3)  # a frame of before may still be under way
    t = visitor.frame.t
    time.sleep(0.3)
    assert visitor.frame.t == t
    visitor.say(Resume())
    visitor.until(lambda: visitor.frame.t > t + 0.2)
    assert 0.5 < visitor.frame.factor < 1.5


@pytest.mark.slow
def test_a_take_over_is_recorded_with_its_source(server, visitor):
    visitor.sits().begins(Fly("fixed-altitude", "servo", "stop-tube", record="flight"))
    visitor.until(lambda: visitor.frame.rows > 5)
    visitor.hold((0.2, 0.0, 0.0, 0.0), arm=True, switch=True)
    rows = visitor.frame.rows
    visitor.until(lambda: visitor.frame.rows > rows + 25)
    visitor.say(Keep())
    visitor.until(lambda: visitor.last(Stored))
    flight = read_flight(server.folder / "demos" / f"{visitor.last(Stored).name}.mcap")
    verdict = flight.episode.verdicts[0]
    by_person = verdict.reason == Reason.TAKE_OVER
    assert 20 <= by_person.sum() < flight.rows
    assert (abs(verdict.command.forward[by_person] - 0.2) < 1e-6).all()


@pytest.mark.slow
def test_what_is_not_on_offer_cannot_be_flown(visitor):
    visitor.sits()
    for fly, words in (
        (Fly("fixed-altitude", "os:system", "stop-tube"), "pilot 'os:system'"),
        (Fly("loop", "servo", "stop-tube"), "manoeuvre 'loop'"),
        (Fly("climb", "../secret.onnx", "stop-tube"), "pilot '../secret.onnx'"),
        (Fly("climb", "servo", "some.module:Net"), "net 'some.module:Net'"),
        (Fly("climb", "servo", "stop-tube", world="attached"), "world 'attached'"),
        (Fly("climb", "servo", "stop-tube", record="demonstration"), "flown by a person"),
        (Train("nothing"), "set-up 'nothing'"),
    ):
        visitor.say(fly)
        noticed(visitor, words)
    visitor.say(Cancel())


@pytest.mark.slow
def test_garbage_is_answered_in_words_and_changes_nothing(visitor):
    visitor.sits().begins(SERVO)
    for said in ('{"kind":"sticks"}', "[" * 1000, b"\xff\xfe", '{"kind":"fly","pilot":NaN}', "", "null"):
        visitor.say(said)
    noticed(visitor, "not understood")
    visitor.until(
        lambda: sum("not understood" in one.text for one in visitor.told if isinstance(one, Notice)) == 6
    )
    t = visitor.frame.t
    visitor.until(lambda: visitor.frame.t > t and visitor.uav.mode in ("AUTO", "SHIELDED"))


@pytest.mark.slow
def test_who_says_too_much_or_too_long_is_sent_away(server):
    with Visitor(server.url) as one:
        one.say("x" * 5000)
        one.until(lambda: one.closed)
        assert one.closed == 1009
    with Visitor(server.url) as one:
        for _ in range(2000):
            try:
                one.say(Pause())
            except Exception:  # it is closed by then
                break
        one.until(lambda: one.closed)
        assert one.closed == 1008
    with Visitor(server.url) as one:
        for _ in range(100):
            try:
                one.say("no message")
            except Exception:  # it is closed by then
                break
        one.until(lambda: one.closed)
        assert one.closed == 1008


@pytest.mark.slow
def test_other_peoples_pages_have_no_business_here(server):
    for origin in ("http://evil.example", "null", server.url.replace("127.0.0.1", "127.0.0.2")):
        with pytest.raises(InvalidStatus):
            Visitor(server.url, origin=origin)
    status, body, _ = server.get("/api/flights", Host="evil.example")
    assert status == 403 and b"evil.example" in body
    assert server.get("/api/flights", Origin="http://evil.example")[0] == 403


@pytest.mark.slow
def test_no_name_leads_out_of_the_folder(server):
    (server.folder / "secret.mcap").write_bytes(b"secret")
    for name in (
        "../secret",
        "..%2fsecret",
        "%2e%2e/secret",
        "/etc/passwd",
        "flights/../../secret",
        "nothing",
    ):
        status, body, _ = server.get(f"/api/flights/{name}")
        assert status == 404 and "error" in json.loads(body), name
    assert server.get("/static/../server.py")[0] == 404
    assert server.get("/static/%2e%2e/server.py")[0] == 404


@pytest.mark.slow
def test_pages_are_one_page_that_loads_nothing_from_elsewhere(server):
    pages = {server.get(f"/{view}")[1] for view in ("fly", "demonstrate", "watch", "train", "")}
    assert len(pages) == 1
    _, page, headers = server.get("/fly")
    policy = headers["content-security-policy"]
    assert "default-src 'self'" in policy and "unsafe" not in policy and "frame-ancestors 'none'" in policy
    assert headers["x-content-type-options"] == "nosniff" and "server" not in headers
    assert b"://" not in page.replace(b"http://www.w3.org/", b"")


@pytest.mark.slow
def test_a_network_learns_and_flies_without_leaving(tmp_path, logbook_of_the_paper):
    with cockpit(tmp_path, "--demos", logbook_of_the_paper) as opened, Visitor(opened.url) as visitor:
        visitor.sits()
        visitor.say(Train("primitive", epochs=2))
        visitor.until(lambda: visitor.last(Lesson).state == "running")
        visitor.say(Train("primitive"))
        noticed(visitor, "trained already")
        visitor.until(lambda: visitor.last(Lesson).state == "done", within=90.0)
        points = [point for one in visitor.told if isinstance(one, Lesson) for point in one.points]
        assert points[-1][0] == 2.0 and all(0.0 < loss < 2.0 for _, *losses in points for loss in losses)
        policy = visitor.last(Lesson).policy
        visitor.until(lambda: policy in visitor.last(Welcome).pilots)
        visitor.begins(Fly("combined", policy, "stop-tube"))
        visitor.until(lambda: visitor.uav.commander == "pilot")
        visitor.say(Train("primitive", epochs=5000))
        visitor.until(lambda: visitor.last(Lesson).points)
        visitor.say(Cancel())
        visitor.until(lambda: visitor.last(Lesson).state == "cancelled")
        visitor.say(Train("dnn-combined", takeovers=True))
        visitor.until(lambda: visitor.last(Lesson).state == "failed")
        assert "flights" in visitor.last(Lesson).problem
        assert [path.name for path in (tmp_path / "policies").iterdir()] == ["primitive-000.onnx"]


@pytest.fixture(scope="module")
def logbook_of_the_paper(tmp_path_factory):
    from fledge.learning.demonstrations import Order
    from fledge.manoeuvres import MANOEUVRES
    from fledge.pilots import HumanModel
    from fledge.runs import logbook

    folder = tmp_path_factory.mktemp("demos")
    logbook.fill(folder, [Order(one, 3, 600) for one in MANOEUVRES], HumanModel(), 0)
    return folder


@pytest.mark.slow
def test_a_server_that_is_killed_loses_less_than_the_last_second(tmp_path):
    with cockpit(tmp_path) as opened, Visitor(opened.url) as visitor:
        visitor.sits().begins(CLIMB)
        visitor.until(lambda: visitor.frame.rows > 50)
        rows = visitor.frame.rows
        opened.process.send_signal(signal.SIGKILL)
        opened.process.wait()
    with cockpit(tmp_path) as opened:
        assert read_flight(tmp_path / "demos" / "climb-000.mcap").rows > rows - 20
        assert [*(tmp_path / "demos").glob(".*.tape")] == []


@pytest.mark.slow
def test_a_full_disk_ends_the_recording_and_not_the_flight(tmp_path):
    import resource

    with cockpit(tmp_path) as opened, Visitor(opened.url) as visitor:
        visitor.sits().begins(CLIMB)
        visitor.until(lambda: visitor.frame.rows > 15)
        # From now on this process's files may not grow: what a full disk is to it.
        resource.prlimit(opened.process.pid, resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
        noticed(visitor, "the recording ends here")
        t = visitor.frame.t
        visitor.until(lambda: visitor.frame.t > t + 0.5)
        resource.prlimit(opened.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)
        visitor.say(Keep())
        visitor.until(lambda: visitor.last(Stored))
        assert 0 < visitor.last(Stored).rows


@pytest.mark.slow
def test_what_it_found_is_told_at_the_end(tmp_path):
    with cockpit(tmp_path) as opened, Visitor(opened.url) as visitor:
        visitor.sits().begins(SERVO)
        visitor.hold((0.1, 0.0, 0.0, 0.0), arm=True, switch=True)
        visitor.until(lambda: visitor.frame.t > 4.0)
        assert visitor.frame.answer is not None and visitor.frame.stamp > 0.0 and visitor.frame.sequence > 0
        found = opened.stop()
    assert found["ticks"] > 300 and found["answer_ms"]["count"] > 100
    assert 0.0 < found["answer_ms"]["p50"] < 1000.0


@pytest.mark.slow
def test_a_port_that_is_taken_and_a_certificate_that_is_none_are_said_in_a_line(tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        for arguments, words in (
            (("--port", port), f"cannot listen at 127.0.0.1:{port}"),
            (("--port", 0, "--certificate", "none.pem", "--key", "none.pem"), "none.pem: no certificate"),
            (("--port", 0, "--attach", "127.0.0.1:9"), "127.0.0.1:9: nothing is heard of the flight"),
            (("--port", 0, "--host", "no.such.host.invalid"), "cannot listen at no.such.host.invalid"),
        ):
            with process("cockpit", *arguments, cwd=tmp_path) as running:
                _, err = running.communicate(timeout=60)
                assert running.returncode == 2 and words in err and err.count("\n") <= 2, err


@pytest.mark.slow
def test_beyond_this_machine_a_token_is_asked_for(tmp_path):
    # 0.0.0.0 is every address of this machine; only the loopback one is used here.
    with cockpit(tmp_path, "--host", "0.0.0.0") as opened:
        assert opened.query.startswith("token=")
        opened.url = opened.url.replace("0.0.0.0", "127.0.0.1")
        assert opened.get("/api/flights")[0] == 403
        assert opened.get("/api/flights?token=wrong")[0] == 403
        status, _, headers = opened.get(f"/fly?{opened.query}")
        cookie = headers["set-cookie"].split(";")[0]
        assert (
            status == 200
            and "HttpOnly" in headers["set-cookie"]
            and "SameSite=Strict" in headers["set-cookie"]
        )
        assert opened.get("/api/flights", Cookie=cookie)[0] == 200
        with pytest.raises(InvalidStatus):
            Visitor(opened.url)
        with Visitor(opened.url, additional_headers={"Cookie": cookie}) as visitor:
            visitor.until(lambda: visitor.last(Welcome))


@pytest.mark.slow
def test_a_slow_reader_delays_nobody(server):
    with Visitor(server.url) as pilot:
        pilot.sits().begins(SERVO)
        host, port = server.url.removeprefix("http://").split(":")
        with socket.create_connection((host, int(port))) as frozen:
            key = "dGhlIHNhbXBsZSBub25jZQ=="
            frozen.sendall(
                f"GET /ws HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                f"Origin: {server.url}\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
            )
            t, began = pilot.frame.t, time.monotonic()
            time.sleep(2.0)
            passed, real = pilot.frame.t - t, time.monotonic() - began
        assert passed > 0.5 * real  # two cores, shared with other tests
