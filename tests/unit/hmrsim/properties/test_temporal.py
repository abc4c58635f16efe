"""Our monitor of Signal Temporal Logic agrees with the definition and with an independent monitor."""

from __future__ import annotations

import math
from random import Random
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.properties.temporal import (
    Above,
    Always,
    And,
    Eventually,
    Implies,
    Not,
    Once,
    OnlineMonitor,
    Or,
    Previous,
    Since,
    Until,
)
from tests.cases import case
from tests.profiles import examples
from tests.torture import monitors

if TYPE_CHECKING:
    from hmrsim.properties.temporal import Formula

A, B = Above("a"), Above("b")
SIGNALS = ("a", "b")

bounds = st.integers(-3, 3).map(lambda bound: bound + 0.5)
atoms = st.builds(Above, st.sampled_from(SIGNALS), bounds)
windows = st.tuples(st.integers(0, 3), st.integers(0, 4) | st.just(math.inf)).map(lambda each: (each[0], sum(each)))


def grown(inner):
    """Return a strategy for formulas of other formulas."""
    return st.one_of(
        st.builds(Not, inner),
        st.builds(And, inner, inner),
        st.builds(Or, inner, inner),
        st.builds(Implies, inner, inner),
        st.builds(lambda window, part: Always(*window, part), windows, inner),
        st.builds(lambda window, part: Eventually(*window, part), windows, inner),
        st.builds(lambda window, left, right: Until(*window, left, right), windows, inner, inner),
    )


formulas = st.recursive(atoms, grown, max_leaves=3)
traces = st.lists(st.tuples(st.integers(-4, 4), st.integers(-4, 4)), min_size=1, max_size=10)


def defined(formula: Formula, trace: list[tuple[float, ...]], at: int) -> float:
    """Return the robustness at a time by its definition; a trace has a sample at each whole time.

    Windows without an end end with the trace, and the last sample holds after it.
    """
    last = len(trace) - 1
    inner = [lambda time, part=part: defined(part, trace, time) for part in formula.parts]
    if not formula.parts:
        return trace[min(at, last)][SIGNALS.index(formula.signal)] - formula.bound
    if isinstance(formula, (Always, Eventually, Until)):
        first = at + formula.start
        times = range(first, (max(first, last) if formula.end == math.inf else at + formula.end) + 1)
        return WINDOWED[type(formula)](inner, at, times)
    return INSTANT[type(formula)](*(part(at) for part in inner))


INSTANT = {Not: lambda value: -value, And: min, Or: max, Implies: lambda left, right: max(-left, right)}
WINDOWED = {
    Always: lambda parts, _at, times: min(map(parts[0], times)),
    Eventually: lambda parts, _at, times: max(map(parts[0], times)),
    Until: lambda parts, at, times: max(min(parts[1](time), *map(parts[0], range(at, time + 1))) for time in times),
}


def value_at(changes, at):
    """Return the value of a step function at a time."""
    return [value for time, value in changes if time <= at][-1]


@given(formula=formulas, trace=traces)
@examples(150)
def test_robustness_is_as_defined(formula, trace):
    monitor = OnlineMonitor(formula, SIGNALS)
    changes = [change for at, values in enumerate(trace) for change in monitor.update(at, values)]

    known = range(max(-1, int(max(-1, monitor.known))) + 1)
    assert [defined(formula, trace, at) for at in known] == [value_at(changes, at) for at in known]


@given(formula=formulas, trace=traces, more=traces)
@examples(150)
def test_bounds_hold_for_every_continuation_of_a_trace(formula, trace, more):
    if formula.horizon == math.inf:
        return
    monitor = OnlineMonitor(formula, SIGNALS)
    changes = [change for at, values in enumerate(trace) for change in monitor.update(at, values)]

    least, greatest = ([*changes, *rest] for rest in monitor.finish())

    for at in range(len(trace)):
        with case(at):
            value = defined(formula, trace + more, at)
            assert value_at(least, at) <= value <= value_at(greatest, at)


@given(trace=traces)
@examples(100)
def test_a_window_without_an_end_ends_with_the_trace(trace):
    monitor = OnlineMonitor(Always(0, math.inf, Implies(A, Eventually(0, math.inf, B))), SIGNALS)
    for at, values in enumerate(trace):
        monitor.update(at, [value + 0.5 for value in values])

    least, greatest = monitor.finish()

    shifted = [tuple(value + 0.5 for value in values) for values in trace]
    assert {value_at(least, 0), value_at(greatest, 0)} == {
        min(max(-a, *(b for _, b in shifted[at:])) for at, (a, _) in enumerate(shifted))
    }


def looking_back(inner):
    """Return a strategy for formulas without windows."""
    return st.one_of(
        st.builds(Not, inner),
        st.builds(And, inner, inner),
        st.builds(Or, inner, inner),
        st.builds(Implies, inner, inner),
        st.builds(Previous, inner, st.booleans()),
        st.builds(Since, inner, inner, st.booleans()),
        st.builds(Once, inner),
    )


def defined_back(formula: Formula, trace: list[tuple[float, ...]], at: int) -> float:
    """Return the robustness of a formula without windows at a sample by its definition."""
    inner = [lambda time, part=part: defined_back(part, trace, time) for part in formula.parts]
    before = math.inf if getattr(formula, "initially", False) else -math.inf
    match formula:
        case Previous():
            return inner[0](at - 1) if at else before
        case Once():
            return max(map(inner[0], range(at + 1)))
        case Since():
            left, right = inner
            began = [min([right(time), *map(left, range(time + 1, at + 1))]) for time in range(at + 1)]
            return max([*began, min([before, *map(left, range(at + 1))])])
    return INSTANT[type(formula)](*(part(at) for part in inner)) if inner else defined(formula, trace, at)


@given(formula=st.recursive(atoms, looking_back, max_leaves=4), trace=traces)
@examples(200)
def test_operators_of_the_past_are_as_defined(formula, trace):
    value = formula.value(SIGNALS)

    assert [defined_back(formula, trace, at) for at in range(len(trace))] == [value(sample) for sample in trace]


def test_an_operator_of_the_past_can_be_inside_a_window():
    monitor = OnlineMonitor(Implies(Once(A), Eventually(0, 2, B)), SIGNALS)
    samples = [(-1.0, -1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]

    changes = [change for at, sample in enumerate(samples) for change in monitor.update(at, sample)]

    assert [(0, 1.0), (1, -1.0), (2, 1.0)] == changes


def test_a_window_in_an_operator_of_the_past_is_an_error():
    """Such operators can't look ahead."""
    with pytest.raises(ValueError, match="windows"):
        OnlineMonitor(Once(Eventually(0, 2, A)), SIGNALS)


def test_robustness_agrees_with_mstlo():
    mstlo = pytest.importorskip("mstlo_python", reason="the independent monitor mstlo is not installed")

    for number in range(200):
        with case(number):
            assert not monitors.difference(monitors.case(Random(number)), mstlo)


def test_a_verdict_comes_as_soon_as_it_is_certain():
    monitor = OnlineMonitor(Eventually(0, 10, A), ["a"])

    told = [monitor.update(0, [1.0]), monitor.update(5, [-1.0]), monitor.update(12, [2.0]), monitor.update(16, [2.0])]

    assert [[], [], [(0, 1.0), (2, 2.0)], []] == [[*each] for each in told]


def test_the_state_of_a_window_does_not_grow_with_the_trace():
    monitor = OnlineMonitor(Always(0, 10, A), ["a"])
    for at in range(2_000):
        monitor.update(at, [float(at % 7)])

    assert len(monitor._node._queue) <= 12


def test_a_value_that_equals_its_bound_is_not_above_it():
    assert OnlineMonitor(Above("a", 1.0), ["a"]).update(0, [1.0])[0][1] < 0


def test_an_unknown_signal_is_an_error_with_the_known_ones():
    with pytest.raises(ValueError, match="there is no signal 'b'; there are a"):
        OnlineMonitor(B, ["a"])


def test_samples_that_go_back_are_an_error():
    monitor = OnlineMonitor(A, ["a"])
    monitor.update(3, [1.0])

    with pytest.raises(ValueError, match="a sample at 3 after one at 3"):
        monitor.update(3, [2.0])


@pytest.mark.parametrize("window", [(-1, 2), (3, 2), (math.inf, math.inf)])
def test_a_window_that_ends_before_it_begins_is_an_error(window):
    with pytest.raises(ValueError, match="expected 0 <= start <= end"):
        Always(*window, A)
