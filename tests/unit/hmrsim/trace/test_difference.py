"""The first difference of two runs."""

from __future__ import annotations

import pytest

from hmrsim.cli.trace_file import difference_from
from hmrsim.trace.difference import first_difference

WAS = '{"kind":"header"}\n{"kind":"status","robot":"eve","stamp":{"nanosec":500000000,"sec":3},"status":4}\n'
NOW = WAS.replace('"status":4', '"status":6')


def test_equal_runs_have_no_difference():
    assert first_difference(WAS, WAS) is None


def test_the_first_difference_has_both_lines():
    difference = first_difference(WAS, NOW)

    assert difference is not None
    assert (
        "first difference: line 2, at 3.500 s, robot eve\n"
        "  was 3.500000000 s eve status status=4\n"
        "  is  3.500000000 s eve status status=6"
    ) == difference.describe()


def test_a_run_that_ends_earlier_differs():
    difference = first_difference(WAS, WAS.splitlines()[0])

    assert difference is not None
    assert difference.describe().endswith("\n  is  nothing: it ends before")


@pytest.mark.parametrize("line", ["", "[]", "no JSON"])
def test_a_line_that_is_no_event_is_shown_raw(line):
    difference = first_difference(line + "x", NOW)

    assert difference is not None
    assert difference.describe().startswith("first difference: line 1, at the start\n")


def order_of_a_set() -> str:
    return " ".join({f"robot_{number}" for number in range(50)})


def test_without_a_trace_the_run_is_repeated_in_other_processes():
    """Sets have another order there."""
    assert "two runs of now differ, too" in difference_from("", order_of_a_set(), order_of_a_set)


def test_equal_repetitions_are_reported():
    assert "the code of the controller" in difference_from("", "'abc'", repr, "abc")


def test_a_kept_trace_is_compared():
    assert "line 2, at 3.500 s" in difference_from(WAS, NOW, lambda: "")
