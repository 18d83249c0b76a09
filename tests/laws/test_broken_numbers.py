"""A number that is none, anywhere in what comes in."""

from dataclasses import fields, is_dataclass, replace
from math import inf, nan

import pytest
from scripted import WAYS, Says, auto

from fledge.supervision.modes import Mode as M
from fledge.world import VelocityCommand

pytestmark = pytest.mark.slow


def numbers(record, *above):
    """Every number in a record, by its way there."""
    named = (
        [(str(i), value) for i, value in enumerate(record)]
        if isinstance(record, tuple)
        else [(field.name, getattr(record, field.name)) for field in fields(record)]
    )
    for name, value in named:
        if is_dataclass(value) or isinstance(value, tuple):
            yield from numbers(value, *above, name)
        else:
            yield (*above, name)


def put(record, path, value):
    name, *rest = path
    if isinstance(record, tuple):
        items = list(record)
        items[int(name)] = put(items[int(name)], rest, value) if rest else value
        return tuple(items)
    return replace(record, **{name: put(getattr(record, name), rest, value) if rest else value})


EVERY_NUMBER = [path for path in numbers(Says().inputs(0.0, 1)) if path != ("airborne",)]


@pytest.mark.parametrize("bad", (nan, inf, -inf))
@pytest.mark.parametrize("path", EVERY_NUMBER, ids=".".join)
def test_a_number_that_is_none_anywhere_stops_its_vehicle_and_is_named(path, bad):
    """No matter what the net does with it."""
    begin = auto(ugvs=1)
    touched = set()
    flight = begin
    for _ in range(40):
        t = flight.t + 0.02
        memory, decisions = flight.supervisor.step(flight.memory, put(begin.says.inputs(t, 1), path, bad))
        flight = replace(flight, memory=memory, t=t)
        for i, decision in enumerate(decisions):
            command = decision.verdict.command
            assert all(abs(getattr(command, axis)) < inf for axis in VelocityCommand.__slots__)
            if decision.verdict.intervened:
                touched.add(i)
                assert decision.verdict.reason > 0
    assert touched, "somebody is concerned"
    for i in touched:
        command = decisions[i].verdict.command
        assert (command.forward, command.left, command.turn) == (0.0, 0.0, 0.0) and command.up <= 0.0
    shared = path[0] in ("decided", "heard") or path == ("seen", "t")
    own = (
        {"uav": {0}, "ugvs": {1}}.get(path[1], {int(path[1])} if path[1].isdigit() else set())
        if path[1:]
        else set()
    )
    assert touched == ({0, 1} if shared else own)


def test_who_may_be_on_the_ground_is_taken_for_flying():
    assert WAYS[M.LAND]().fly(1.0, airborne=nan).mode == M.LAND
    assert auto().fly(1.0, airborne=nan, arm=0.0).mode == M.AUTO
