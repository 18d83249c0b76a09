"""A recipe says how to optimise; what makes no sense is refused by name."""

from dataclasses import fields, replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fledge.errors import OutOfRange
from fledge.learning.recipe import Recipe


def test_the_paper_s_recipe_is_the_paper_s():
    """Section "Experiments": Adam, full batch, 10,000 epochs, 67/33, 1e-4; Keras steps by 0.001."""
    wanted = Recipe(
        epochs=10_000,
        batch=None,
        learning_rate=1e-3,
        schedule="constant",
        weight_decay=0.0,
        init="paper",
        split="row",
        validation=0.33,
        keep="last",
        points=100,
    )
    assert Recipe.paper() == wanted
    assert Recipe.paper(123) == replace(wanted, epochs=123)
    assert Recipe.fast(7).epochs == 7
    assert Recipe.fast().checked().split == "episode"


@settings(max_examples=30)
@given(st.integers(1, 500), st.integers(1, 120))
def test_there_are_about_as_many_points_as_asked_for(epochs, points):
    recipe = Recipe(epochs=epochs, points=points)
    assert 1 <= recipe.stride <= epochs
    measured = -(-epochs // recipe.stride)
    assert min(points, epochs) <= measured < 2 * points or recipe.stride == 1


BAD = [
    ("epochs", 0),
    ("batch", 0),
    ("learning_rate", 0.0),
    ("learning_rate", 1.5),
    ("learning_rate", float("nan")),
    ("schedule", "linear"),
    ("weight_decay", -1.0),
    ("weight_decay", float("nan")),
    ("init", "zero"),
    ("split", "rows"),
    ("validation", 0.0),
    ("validation", 1.0),
    ("keep", "first"),
    ("slack", -0.1),
    ("slack", float("nan")),
    ("points", 0),
]


@pytest.mark.parametrize(("name", "value"), BAD)
def test_a_recipe_names_the_field_that_makes_no_sense(name, value):
    recipe = replace(Recipe.fast(), **{name: value})
    with pytest.raises(OutOfRange) as caught:
        recipe.checked()
    assert f"recipe {name} is {value}: valid is " in str(caught.value)


def test_every_field_of_a_recipe_is_checked():
    assert {name for name, _ in BAD} == {field.name for field in fields(Recipe)}
    for recipe in (Recipe(), Recipe.fast(), Recipe.paper()):
        assert recipe.checked() is recipe
