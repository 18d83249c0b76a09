"""A flight comes back as it was, or the file is refused in one clear line."""

import json
from dataclasses import fields, is_dataclass, replace

import jax
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import IndexType, Writer

from fledge.engines import fly
from fledge.episode import Flight
from fledge.errors import BadFile, FledgeError
from fledge.manoeuvres import FixedAltitude
from fledge.pilots import Servo
from fledge.simulation import Case, Crew
from fledge.storage import FlightLog, list_flights, read_facts, read_flight, recover_flight, write_flight
from fledge.storage.records import to_json
from fledge.world import Arena

pytestmark = pytest.mark.slow


def leaves(record):
    if is_dataclass(record):
        return [leaf for f in fields(record) for leaf in leaves(getattr(record, f.name))]
    return [leaf for item in record for leaf in leaves(item)] if isinstance(record, tuple) else [record]


def same(a: Flight, b: Flight) -> bool:
    """Equal to the bit, but that one NaN is like another."""

    def bits(leaf):
        leaf = np.array(leaf)
        leaf[leaf != leaf] = 0
        return leaf.tobytes(), leaf.dtype, leaf.shape, np.isnan(leaf).tobytes()

    same_facts = replace(a, episode=None) == replace(b, episode=None)
    pairs = zip(leaves(a.episode), leaves(b.episode), strict=True)
    return same_facts and all(bits(x) == bits(y) for x, y in pairs)


def with_leaves(flight: Flight, make) -> Flight:
    return replace(flight, episode=jax.tree.map(make, flight.episode))


@pytest.fixture(scope="module")
def data(flight, tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("flight") / "a.mcap"
    write_flight(path, flight)
    return path.read_bytes()


def refused(path, content: bytes) -> str:
    path.write_bytes(content)
    with pytest.raises(BadFile) as caught:
        read_flight(path)
    line = str(caught.value)
    assert line.startswith(f"{path}: ") and "\n" not in line
    return line.removeprefix(f"{path}: ")


def test_round_trip(tmp_path, flight):
    write_flight(tmp_path / "a.mcap", flight)
    back = read_flight(tmp_path / "a.mcap")
    assert same(back, flight)
    assert np.isposinf(back.episode.verdicts[0].clearance).all()
    assert np.signbit(back.episode.action.turn).any()
    assert back.net == "NaN"
    assert type(back.arena.ceiling) is int and type(back.ideal_radius) is float


def test_round_trip_of_what_the_study_flies(tmp_path):
    case = Case.draw(FixedAltitude(), (3,), rows=10)
    episode = jax.tree.map(lambda leaf: leaf[0], fly([case], Crew(Servo()), [(3,)]))
    flight = Flight(episode, "fixed-altitude", "servo", "none", 3, 0, (0, 1), case.plan.arena)
    assert episode.action.up.dtype == np.float32
    write_flight(tmp_path / "a.mcap", flight)
    assert same(read_flight(tmp_path / "a.mcap"), flight)


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.float16])
def test_round_trip_of_every_float_there_is(tmp_path, flight, dtype):
    rng = np.random.default_rng(0)
    strange = np.array([np.nan, np.inf, -np.inf, -0.0, 0.0, np.finfo(dtype).max, np.finfo(dtype).tiny], dtype)
    for seed in range(5):
        wild = with_leaves(
            flight, lambda leaf: np.concatenate((strange, np.frombuffer(rng.bytes(160), dtype)[:13]))
        )
        write_flight(tmp_path / f"{seed}.mcap", wild)
        assert same(read_flight(tmp_path / f"{seed}.mcap"), wild)


@pytest.mark.parametrize("dtype", [bool, np.int64, np.int32, np.uint8])
def test_round_trip_of_other_numbers(tmp_path, flight, dtype):
    codes = with_leaves(flight, lambda leaf: (np.arange(20) % 2 * 100).astype(dtype))
    write_flight(tmp_path / "a.mcap", codes)
    assert same(read_flight(tmp_path / "a.mcap"), codes)


def test_round_trip_of_odd_facts(tmp_path, flight):
    odd = replace(
        flight, ideal_radius=float("inf"), arena=Arena(flight.arena.bounds, float("inf")), pilot="", axes=()
    )
    write_flight(tmp_path / "a.mcap", odd)
    assert same(read_flight(tmp_path / "a.mcap"), odd)


def test_same_flight_same_bytes(tmp_path, flight, data):
    write_flight(tmp_path / "b.mcap", flight)
    assert (tmp_path / "b.mcap").read_bytes() == data


def test_row_by_row_is_the_same_file(tmp_path, flight, data):
    with open(tmp_path / "a.mcap", "wb") as file, FlightLog(file, flight) as log:
        for i in range(flight.rows):
            log.add(jax.tree.map(lambda leaf, i=i: float(leaf[i]), flight.episode))
    assert (tmp_path / "a.mcap").read_bytes() == data


def test_rows_of_mixed_types_are_kept_as_the_wider_one(tmp_path, flight):
    first = jax.tree.map(lambda leaf: float(leaf[0]), flight.episode)
    with open(tmp_path / "a.mcap", "wb") as file, FlightLog(file, flight) as log:
        for reason, intervened in [(0, False), (2, True), (2.5, 1)]:
            verdict = replace(first.verdicts[0], reason=reason, intervened=intervened)
            log.add(replace(first, verdicts=(verdict, *first.verdicts[1:])))
    verdict = read_flight(tmp_path / "a.mcap").episode.verdicts[0]
    assert verdict.reason.tolist() == [0.0, 2.0, 2.5] and verdict.reason.dtype == np.float64
    assert verdict.intervened.tolist() == [0, 1, 1] and verdict.intervened.dtype == np.int64


def test_the_number_of_vehicles_stays(tmp_path, flight):
    fewer = replace(flight.episode, world=replace(flight.episode.world, ugvs=flight.episode.world.ugvs[:2]))
    with open(tmp_path / "a.mcap", "wb") as file, FlightLog(file, flight) as log:
        log.add(flight.episode)
        with pytest.raises(FledgeError, match="2 UGVs: valid are as many as in the rows before"):
            log.add(fewer)
    assert same(read_flight(tmp_path / "a.mcap"), flight)


def test_a_log_that_ends_in_an_error_is_kept(tmp_path, flight):
    with pytest.raises(RuntimeError), open(tmp_path / "a.mcap", "wb") as file, FlightLog(file, flight) as log:
        log.add(flight.episode)
        raise RuntimeError("the vehicle is in a tree")
    assert same(read_flight(tmp_path / "a.mcap"), flight)


def test_of_a_log_cut_short_what_is_whole_is_recovered(tmp_path, flight):
    path, ends = tmp_path / "a.mcap", []
    with open(path, "wb") as file, FlightLog(file, flight) as log:
        for i in range(flight.rows):
            log.add(jax.tree.map(lambda leaf, i=i: float(leaf[i]), flight.episode))
            log.writer.flush()
            ends.append(file.tell())
    whole = path.read_bytes()
    assert same(recover_flight(path), flight)
    for rows, (end, after) in enumerate(zip(ends, ends[1:], strict=False), start=1):
        for cut in (end, (end + after) // 2):
            path.write_bytes(whole[:cut])
            assert same(recover_flight(path), with_leaves(flight, lambda leaf, rows=rows: leaf[:rows]))
            with pytest.raises(BadFile, match="cut short"):
                read_flight(path)
    for data in (b"", whole[:100], whole[: ends[0] // 2], b"not a flight"):
        path.write_bytes(data)
        with pytest.raises(BadFile):
            recover_flight(path)


def test_unfit_episodes_are_refused_and_leave_no_file(tmp_path, flight):
    short = replace(flight.episode, ideal_spread=flight.episode.ideal_spread[:-1])
    for episode, line in [
        (short, r"ideal_spread has shape \(19,\) and world.t has \(20,\): valid is one shape"),
        (jax.tree.map(lambda leaf: leaf[:0], flight.episode), "at least one row"),
        (jax.tree.map(lambda leaf: leaf[None], flight.episode), r"valid is one shape \(rows,\)"),
        (replace(flight.episode, ideal_spread=np.array(["a"] * 20)), "ideal_spread is of dtype <U1"),
        (replace(flight.episode, ideal_spread=np.zeros(20, complex)), "valid are numbers of at most 64 bits"),
    ]:
        with pytest.raises(FledgeError, match=line):
            write_flight(tmp_path / "a.mcap", replace(flight, episode=episode))
    assert list(tmp_path.iterdir()) == []


def check(schema: dict, value, root: bool = True) -> None:
    """What Foxglove asks of a JSON schema, and whether a message is of it."""
    assert isinstance(schema["type"], str) and (not root or schema["type"] == "object")
    if schema["type"] == "object":
        assert isinstance(value, dict)
        for name, part in value.items():
            check(schema["properties"][name], part, root=False)
    elif schema["type"] == "array":
        for part in value:
            check(schema["items"], part, root=False)
    elif schema["type"] == "number":
        assert type(value) in (int, float) or value in ("NaN", "Infinity", "-Infinity")
    else:
        assert {"integer": int, "boolean": bool, "string": str}[schema["type"]] is type(value)


def test_foxglove_finds_strict_json_and_schemas(tmp_path, flight, capfd):
    wild = np.array([np.nan, np.inf, -np.inf, 1.0] * 5)
    stuck = replace(flight, episode=replace(flight.episode, ideal_spread=wild))
    write_flight(tmp_path / "a.mcap", stuck)
    seen: dict[str, int] = {}
    with open(tmp_path / "a.mcap", "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        for schema, channel, message in reader.iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            shape = json.loads(schema.data, parse_constant=pytest.fail)
            assert shape["title"] == schema.name
            check(shape, json.loads(message.data, parse_constant=pytest.fail))
            seen[schema.name] = seen.get(schema.name, 0) + 1
        (facts, _) = reader.iter_metadata()
        assert {name: json.loads(text) for name, text in facts.metadata.items()}["seed"] == 2**70
        assert reader.get_summary().statistics.message_end_time == round(flight.episode.world.t[-1] * 1e9)
    assert seen == {"fledge.Row": 20, "foxglove.FrameTransforms": 20, "foxglove.SceneUpdate": 1}
    assert capfd.readouterr() == ("", "")


def messages(path, topic):
    with open(path, "rb") as file:
        found = make_reader(file).iter_messages(topics=[topic])
        return [(message.log_time, json.loads(message.data)) for _, _, message in found]


def test_the_frames_are_where_the_vehicles_are(tmp_path, flight):
    write_flight(tmp_path / "a.mcap", flight)
    world = flight.episode.world
    t, message = messages(tmp_path / "a.mcap", "/fledge/frames")[3]
    uav, ugv, *_ = message["transforms"]
    assert t == 150_000_000 and uav["timestamp"] == {"sec": 0, "nsec": 150_000_000}
    assert uav["translation"]["z"] == pytest.approx(world.uav.position.z[3], abs=1e-6)
    assert uav["rotation"]["w"] == pytest.approx(world.uav.attitude.w[3], abs=1e-6)
    assert ugv["child_frame_id"] == "ugv1" and ugv["translation"]["z"] == 0.0
    assert ugv["translation"]["y"] == pytest.approx(world.ugvs[0].y[3], abs=1e-6)
    assert 2.0 * np.arctan2(ugv["rotation"]["z"], ugv["rotation"]["w"]) == pytest.approx(
        world.ugvs[0].heading[3], abs=1e-5
    )


def test_the_scene_has_arena_obstacle_and_vehicles(tmp_path, flight):
    write_flight(tmp_path / "a.mcap", flight)
    ((_, scene),) = messages(tmp_path / "a.mcap", "/fledge/scene")
    boxes = {entity["id"]: entity for entity in scene["entities"]}
    assert set(boxes) == {"arena", "obstacle1", "uav", "ugv1", "ugv2", "ugv3"}
    assert boxes["arena"]["cubes"][0]["size"] == {"x": 10.0, "y": 8.0, "z": 6.0}
    assert boxes["obstacle1"]["cubes"][0]["pose"]["position"] == {"x": 1.5, "y": 1.75, "z": 0.15}
    assert boxes["ugv2"]["frame_id"] == "ugv2"


def test_a_lost_vehicle_has_no_frames_but_its_row(tmp_path, flight):
    gone = with_leaves(flight, np.copy)
    gone.episode.world.ugvs[1].heading[5:8] = np.nan, np.inf, -np.inf
    write_flight(tmp_path / "a.mcap", gone)
    assert len(messages(tmp_path / "a.mcap", "/fledge/frames")) == 17
    assert same(read_flight(tmp_path / "a.mcap"), gone)


# What a flight was, without its rows


def facts_of(flight: Flight) -> dict:
    """All that a flight says of itself, as JSON has it."""
    some = {field.name: getattr(flight, field.name) for field in fields(Flight) if field.name != "episode"}
    return {name: to_json(value) for name, value in some.items()} | {"rows": flight.rows}


def test_the_facts_are_those_of_the_whole_flight(tmp_path, flight):
    odd = replace(flight, ideal_radius=float("inf"), pilot="", axes=())
    for one in (flight, odd, with_leaves(flight, lambda leaf: leaf[:1])):
        write_flight(tmp_path / "a.mcap", one)
        assert read_facts(tmp_path / "a.mcap") == facts_of(read_flight(tmp_path / "a.mcap")) == facts_of(one)


def test_no_row_is_read_for_them(tmp_path, flight):
    """A flipped bit among the rows is the business of those who want the rows."""
    write_flight(tmp_path / "a.mcap", flight)
    with open(tmp_path / "a.mcap", "r+b") as file:
        (chunk, *_) = make_reader(file).get_summary().chunk_indexes
        file.seek(chunk.chunk_start_offset + chunk.chunk_length // 2)
        (byte,) = file.read(1)
        file.seek(-1, 1)
        file.write(bytes([byte ^ 1]))
    assert read_facts(tmp_path / "a.mcap") == facts_of(flight)
    with pytest.raises(BadFile):
        read_flight(tmp_path / "a.mcap")


def facts_or_line(path, content: bytes) -> dict | str:
    path.write_bytes(content)
    try:
        return read_facts(path)
    except BadFile as error:
        assert "\n" not in str(error)
        return str(error).removeprefix(f"{path}: ")


def test_the_facts_of_a_flight_cut_anywhere_are_refused(tmp_path, data):
    for size in [*range(0, 40), *range(40, len(data), 61), *range(len(data) - 60, len(data))]:
        line = facts_or_line(tmp_path / "a.mcap", data[:size])
        assert line == refused(tmp_path / "a.mcap", data[:size])


def test_of_a_damaged_flight_there_are_facts_or_a_line(tmp_path, flight, data):
    rng = np.random.default_rng(3)
    wanted = set(facts_of(flight))
    for place in rng.integers(8, len(data) - 8, 300):
        broken = bytearray(data)
        broken[place] ^= 1 << rng.integers(8)
        found = facts_or_line(tmp_path / "a.mcap", bytes(broken))
        assert isinstance(found, str) or set(found) == wanted
    for size in [1, 100, 10_000]:
        for content in (rng.bytes(size), data[:8] + rng.bytes(size) + data[-8:]):
            assert isinstance(facts_or_line(tmp_path / "a.mcap", content), str)


@pytest.mark.parametrize(
    "change",
    [
        {"format": "2"},
        {"seed": '"seven"'},
        {"pilot": "3"},
        {"axes": "3"},
        {"net": "{"},
        {"net": None},
        {"more": "1"},
        {"rows": "null"},
        {"rows": "0"},
        {"rows": None},
    ],
    ids=str,
)
def test_facts_of_others_are_refused_as_their_flights_are(tmp_path, flight, change):
    path = tmp_path / "a.mcap"
    write_flight(path, flight)
    metadata, rows = parts(path)
    (name, value), record = *change.items(), "fledge.end" if "rows" in change else "fledge.flight"
    metadata[record] = {**metadata[record], name: value}
    if value is None:
        del metadata[record][name]
    content = mcap(path, metadata.items(), rows)
    assert refused(path, content) and isinstance(facts_or_line(path, content), str)


def test_facts_are_refused_where_there_are_none(tmp_path, flight):
    path = tmp_path / "a.mcap"
    write_flight(path, flight)
    metadata, rows = parts(path)
    for some in (
        [],
        [("fledge.flight", metadata["fledge.flight"])],
        [("fledge.end", metadata["fledge.end"])],
    ):
        content = mcap(path, some, rows)
        assert refused(path, content) == facts_or_line(path, content)
    for wrong in (tmp_path / "nowhere.mcap", tmp_path):
        with pytest.raises(BadFile, match="cannot be read"):
            read_facts(wrong)


def test_lists_flights_by_name(tmp_path):
    for name in ["b.mcap", "a.mcap", ".c.mcap", ".a.mcap.1.partial", "d.json"]:
        (tmp_path / name).touch()
    assert list_flights(str(tmp_path)) == [tmp_path / "a.mcap", tmp_path / "b.mcap"]
    for wrong in ["nowhere", "a.mcap"]:
        with pytest.raises(BadFile, match="there is no such folder"):
            list_flights(tmp_path / wrong)


def test_a_flight_cut_anywhere_is_refused(tmp_path, data):
    for size in [*range(0, 40), *range(40, len(data), 61), *range(len(data) - 60, len(data))]:
        line = refused(tmp_path / "a.mcap", data[:size])
        assert "cut short" in line or "not an MCAP file" in line


def test_a_flight_with_its_middle_missing_is_refused(tmp_path, data):
    for size in range(8, len(data) - 8, 61):
        refused(tmp_path / "a.mcap", data[:size] + data[-8:])
        refused(tmp_path / "a.mcap", data[:size] + data[size + 1 :])


def test_a_flipped_bit_gives_the_same_flight_or_none(tmp_path, flight, data):
    rng = np.random.default_rng(1)
    taken = 0
    for place in rng.integers(8, len(data) - 8, 300):
        broken = bytearray(data)
        broken[place] ^= 1 << rng.integers(8)
        (tmp_path / "a.mcap").write_bytes(broken)
        try:
            assert same(read_flight(tmp_path / "a.mcap"), flight)
            taken += 1
        except BadFile as error:
            assert "\n" not in str(error)
    assert taken < 150  # only in the index at the end, which is not needed


def test_rubbish_is_refused(tmp_path, data):
    rng = np.random.default_rng(2)
    assert "it begins with b'#!/bin/s'" in refused(tmp_path / "a", b"#!/bin/sh\n")
    for size in [1, 100, 10_000]:
        refused(tmp_path / "a", rng.bytes(size))
        refused(tmp_path / "a", data[:8] + rng.bytes(size) + data[-8:])
        refused(tmp_path / "a", data[:8] + bytes(size) + data[-8:])


def test_no_file_and_no_regular_file(tmp_path):
    with pytest.raises(BadFile, match="a.mcap: cannot be read: No such file or directory"):
        read_flight(tmp_path / "a.mcap")
    with pytest.raises(BadFile, match="cannot be read: Is a directory"):
        read_flight(tmp_path)


def mcap(path, metadata=(), rows=(), **options) -> bytes:
    """An MCAP by somebody else."""
    with open(path, "wb") as file:
        writer = Writer(file, **options)
        writer.start()
        for name, record in metadata:
            writer.add_metadata(name, record)
        channel = writer.register_channel("/fledge/row", "json", 0)
        for i, row in enumerate(rows):
            writer.add_message(channel, i, row, i, sequence=i)
        writer.finish()
    return path.read_bytes()


def parts(path):
    with open(path, "rb") as file:
        reader = make_reader(file)
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        return metadata, [m.data for _, _, m in reader.iter_messages(topics=["/fledge/row"])]


def test_flights_of_others_are_refused_and_say_why(tmp_path, flight):
    path = tmp_path / "a.mcap"
    write_flight(path, flight)
    metadata, rows = parts(path)
    facts, end = metadata["fledge.flight"], metadata["fledge.end"]

    def line(facts=facts, end=end, rows=rows, **options):
        return refused(path, mcap(path, [("fledge.flight", facts), ("fledge.end", end)], rows, **options))

    foreign = "an MCAP file without the record 'fledge.flight': valid is a flight stored by fledge"
    assert refused(path, mcap(path, [], [b"{}"])) == foreign
    bare = dict.fromkeys(
        ["repeat_channels", "repeat_schemas", "use_statistics", "use_summary_offsets"], False
    )
    nothing = IndexType.NONE
    assert refused(path, mcap(path, [], [b"{}"], index_types=nothing, **bare)) == foreign
    assert line({"format": "2"}) == "a flight of format '2': this fledge reads '1'"
    assert line({}).startswith("a flight of format None")
    assert line(rows=rows[:-1]) == "damaged: 19 rows, where its record says 20; valid is 1 or more"
    assert "0 rows" in line(end={**end, "rows": "0"}, rows=[])
    assert "20 rows" in line(end={**end, "rows": "null"})
    assert "KeyError 'rows'" in line(end={})
    assert "seed is 'seven': valid is int" in line({**facts, "seed": '"seven"'})
    assert "seed is True: valid is int" in line({**facts, "seed": "true"})
    assert "pilot is 3: valid is str" in line({**facts, "pilot": "3"})
    assert "axes is 3: valid is a list" in line({**facts, "axes": "3"})
    high, blind = facts["arena"].replace("6", '"high"'), facts["lens"].replace("700.5", "0.0")
    assert "arena.ceiling is 'high': valid is a number" in line({**facts, "arena": high})
    assert "lens focal_px is 0.0: valid is 1 to 100000 px" in line({**facts, "lens": blind})
    assert "lens has 3: valid are focal_px, width_px, height_px, levelled" in line({**facts, "lens": "3"})
    assert "the record has " in line({name: facts[name] for name in facts if name != "net"})
    assert "the record has " in line({**facts, "more": "1"})
    assert "damaged" in line({**facts, "net": "{"})
    assert "damaged" in line(rows=[*rows[:-1], b'{"world": 3}'])
    assert "episode has [" in line(end={**end, "rows": "1"}, rows=[b"3"])
    assert "damaged" in line(rows=[*rows[:-1], rows[-1].replace(b"Infinity", b"infinite")])
    assert "damaged" in line(end={**end, "columns": end["columns"].replace("float64", "object")})
    assert "damaged: float64 where its record says int64" in line(
        end={**end, "columns": end["columns"].replace("float64", "int64")}
    )
    unfinished = mcap(path, [("fledge.flight", facts)], rows)
    assert refused(path, unfinished) == "cut short: a flight without the record 'fledge.end'"


def test_an_untouched_rewrite_is_read(tmp_path, flight):
    path = tmp_path / "a.mcap"
    write_flight(path, flight)
    metadata, rows = parts(path)
    mcap(path, metadata.items(), rows, use_chunking=False, index_types=IndexType.NONE)
    with pytest.raises(BadFile):  # an index without metadata speaks for a foreign file
        read_flight(path)
    mcap(path, metadata.items(), rows, use_chunking=False)
    assert same(read_flight(path), flight)


KILLED = """
    import sys
    from fledge.storage import read_flight, write_flight

    flight = read_flight(sys.argv[1])
    print("ready", flush=True)
    while True:
        write_flight(sys.argv[2], flight)
"""


def test_a_writer_killed_at_any_time_leaves_a_whole_flight_or_none(tmp_path, flight, data, python):
    write_flight(tmp_path / "a.mcap", flight)
    for i in range(4):
        writer = python(KILLED, tmp_path / "a.mcap", tmp_path / f"{i}.mcap")
        assert writer.stdout.readline() == "ready\n"
        with pytest.raises(Exception, match="timed out"):
            writer.wait(0.002 + 0.013 * i)
        writer.kill()
        writer.wait()
    for path in list_flights(tmp_path):
        assert path.read_bytes() == data


def test_a_full_disk(flight):
    with pytest.raises(OSError, match="No space left"), open("/dev/full", "wb", buffering=0) as file:
        with FlightLog(file, flight) as log:
            log.add(flight.episode)
