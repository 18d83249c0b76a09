"""A flight, drawn: every format, the same bytes each time, and nothing half-written."""

import pytest
from PIL import Image

from fledge.demonstrations import Order, collect
from fledge.errors import BadFile
from fledge.manoeuvres import Climb
from fledge.pilots import AbstractPilot, Servo
from fledge.replay import FRAMES, draw_flight


class Plain(AbstractPilot):
    """The servo, where JAX cannot look inside: flown in plain Python, nothing to compile."""

    name = "plain"

    def act(self, memory, observation, noise):
        memory, action = Servo().act(memory, observation, noise)
        return memory, action if float(action.up) < 2.0 else None


@pytest.fixture(scope="module")
def flight():
    (flown,) = collect([Order(Climb(), 1, 200)], Plain(), seed=0)
    return flown


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_the_same_flight_gives_the_same_bytes(tmp_path, flight, kind):
    one, two = (draw_flight(flight, tmp_path / f"{name}.{kind}") for name in "ab")
    assert one.read_bytes() == two.read_bytes()


def test_an_animation_moves(tmp_path, flight):
    path = draw_flight(flight, tmp_path / "flight.gif")
    with Image.open(path) as film:
        assert 1 < film.n_frames <= FRAMES


def test_another_format_is_refused(tmp_path, flight):
    with pytest.raises(BadFile, match=r"valid are \.png, \.svg, \.pdf and \.gif"):
        draw_flight(flight, tmp_path / "flight.mp4")
    assert list(tmp_path.iterdir()) == []
