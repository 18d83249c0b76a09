"""Numbers read well, and none says more than is true."""

from fledge.report.wording import flat, listed, number, p_value, percent, shown, signed, word
from fledge.study.metrics import METRICS


def test_numbers_read_well():
    assert number(1234567.25, 1) == "1\N{NARROW NO-BREAK SPACE}234\N{NARROW NO-BREAK SPACE}567.2"
    assert number(-0.5, 1) == "\N{MINUS SIGN}0.5" and number(-0.01, 1) == "0.0" and number(None) == "–"
    assert signed(0.5) == "+0.50" and signed(-0.5) == "\N{MINUS SIGN}0.50" and signed(0.001) == "0.00"
    assert p_value(0.0001) == "<0.001" and p_value(0.05) == "0.050" and p_value(None) == "–"
    assert listed(["a"]) == "a" and listed(["a", "b", "c"]) == "a, b and c"
    assert word(None) == "none" and word(True) == "yes" and word([1, 2.5]) == "1, 2.5"


def test_a_share_that_is_not_whole_is_not_shown_as_whole():
    assert percent(1.0) == "100.00"
    assert percent(0.99999) == ">99.99"
    assert percent(0.9999) == "99.99"


def test_nested_settings_are_flat():
    assert flat({"a": {"b": {"c": 1}, "d": None}}) == [("a.b.c", "1"), ("a.d", "none")]


def test_a_number_is_shown_as_its_metric_has_it():
    assert shown(0.99999, METRICS["in_view"]) == ">99.99"
    assert shown(12.345, METRICS["distance"]) == "12.3"
    assert shown(None, METRICS["effort"]) == "–"
