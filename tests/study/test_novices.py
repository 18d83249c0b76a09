"""Novices are policies that fly: two, and unlike each other."""

from dataclasses import replace

import numpy as np
import pytest

from fledge.learning.demonstrations import Order
from fledge.learning.recipe import Recipe
from fledge.study import novices
from fledge.study.experiments import Progress


@pytest.mark.slow
def test_there_are_two_and_they_differ(monkeypatch):
    monkeypatch.setattr(novices, "ORDERS", tuple(Order(one.manoeuvre, 2, 200) for one in novices.ORDERS))
    monkeypatch.setattr(
        novices, "SETUPS", tuple(replace(one, recipe=Recipe.fast(2)) for one in novices.SETUPS)
    )
    *progress, trained = novices.novices(3)
    assert all(isinstance(event, Progress) for event in progress) and progress[-1].done == 2
    assert set(trained) == {"primitive", "primitive-paper"}
    state = np.ones((1, 11))
    said = [policy(state) for policy in trained.values()]
    assert all(np.abs(action).max() <= 1.0 for action in said)
    assert not np.array_equal(*said)
