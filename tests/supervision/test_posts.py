"""What is known of one vehicle."""

import pytest

from fledge.supervision.inputs import HOVER
from fledge.supervision.modes import Mode
from fledge.supervision.posts import Post, is_in
from fledge.world import Reason


def post(mode: float) -> Post:
    return Post(mode, float(Reason.NONE), 0.0, 0.0, 0.0, 0.0, 1.0, HOVER)


@pytest.mark.parametrize("mode", Mode)
def test_a_vehicle_is_in_one_mode(mode):
    others = [other for other in Mode if other != mode]
    assert is_in(post(float(mode)), mode) and is_in(post(float(mode)), *Mode)
    assert not is_in(post(float(mode)), *others)


def test_a_mode_that_is_no_number_is_none():
    assert not is_in(post(float("nan")), *Mode)
