"""Logs of flights that an echo flew."""

from ticks import Echo, heard

from fledge.episode import Flight
from fledge.lab.shell.logs import Entry, Log
from fledge.world import Arena

ABOUT = Flight(None, "lab", "servo", "stop-tube", 0, 0, (0, 1), Arena.lab())  # pyright: ignore
BRIEF = {"pilot": "servo", "lens": {"focal_px": 374.7}}


def entries(count, controller=None, data=b"frame"):
    """So many ticks of a flight."""
    controller = controller or Echo()
    memory = controller.init()
    for number in range(count):
        came = heard(number, data)
        memory, spoken = controller.step(memory, came)
        yield Entry(number, came, spoken, 300 + number)


def written(path, ticks, **more):
    """The log, after these ticks."""
    with Log(path, ABOUT, BRIEF, **more) as log:
        for entry in ticks:
            log.tick(entry)
    return log
