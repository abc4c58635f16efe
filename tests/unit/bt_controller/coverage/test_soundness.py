"""Outcomes that are impossible by analysis never happen, in trees of any shape."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hypothesis import given, settings
from hypothesis import strategies as st
from py_trees import decorators
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence

from bt_controller.core.node import Condition
from bt_controller.core.port_values import node
from bt_controller.core.sim_time import simulated_time
from bt_controller.coverage import TreeCoverage
from bt_controller.coverage.node_coverage import ENDINGS, RUNNING
from bt_controller.nodes import registry

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

ENDS = (Status.SUCCESS, Status.FAILURE)
ANY = (*ENDS, Status.RUNNING)


class Step(Behaviour):
    """A leaf of which nothing is known."""

    def __init__(self, name: str, statuses: list[Status]) -> None:
        super().__init__(name)
        self._next: Iterator[Status] = iter(statuses)
        self._last = statuses[-1]

    def update(self) -> Status:
        return next(self._next, self._last)


class Look(Condition):
    """A leaf that takes no time."""

    def __init__(self, name: str, statuses: list[Status]) -> None:
        super().__init__(name)
        self._statuses = statuses
        self._ticks = 0

    def update(self) -> Status:
        self._ticks += 1
        return self._statuses[self._ticks % len(self._statuses)]


def leaves() -> st.SearchStrategy[Callable[[], Behaviour]]:
    """Return leaves that may take time, and such that don't."""
    steps = st.lists(st.sampled_from(ANY), min_size=1, max_size=5).map(lambda given: lambda: Step("step", given))
    looks = st.lists(st.sampled_from(ENDS), min_size=1, max_size=5).map(lambda given: lambda: Look("look", given))
    return st.one_of(steps, looks)


DECORATORS: dict[str, Callable[[Behaviour], Behaviour]] = {
    "Inverter": lambda child: decorators.Inverter("d", child),
    "Retry": lambda child: decorators.Retry("d", child, 2),
    "Repeat": lambda child: decorators.Repeat("d", child, 2),
    "OneShot": lambda child: decorators.OneShot("d", child, decorators.common.OneShotPolicy.ON_COMPLETION),
    "FailureIsSuccess": lambda child: decorators.FailureIsSuccess("d", child),
    "FailureIsRunning": lambda child: decorators.FailureIsRunning("d", child),
    "SuccessIsFailure": lambda child: decorators.SuccessIsFailure("d", child),
    "SuccessIsRunning": lambda child: decorators.SuccessIsRunning("d", child),
    "RunningIsFailure": lambda child: decorators.RunningIsFailure("d", child),
    "RunningIsSuccess": lambda child: decorators.RunningIsSuccess("d", child),
    "Timeout": lambda child: decorators.Timeout("d", child, 2.5),
}

IN_XML = {
    "Inverter": {},
    "ForceSuccess": {},
    "ForceFailure": {},
    "RetryUntilSuccessful": {"num_attempts": 2},
    "Repeat": {"num_cycles": 2},
    "KeepRunningUntilFailure": {},
    "RunOnce": {},
    "SingleTrigger": {},
    "Timeout": {"msec": 2500},
    "Delay": {"delay_msec": 1500},
    "RateController": {"hz": 0.5},
}
CONTROLS = (
    *("Sequence", "SequenceWithMemory", "ReactiveSequence", "Fallback", "ReactiveFallback", "Parallel", "ParallelAll"),
    *("PipelineSequence", "NonblockingSequence", "PersistentSequence", "RoundRobin", "RecoveryNode", "TryCatch"),
    *("IfThenElse", "WhileDoElse"),
)
TWO = {"RecoveryNode"}


def above(children: st.SearchStrategy[Callable[[], Behaviour]]) -> st.SearchStrategy[Callable[[], Behaviour]]:
    """Return composites and decorators, of py_trees and of this package."""
    known = registry()
    several = st.lists(children, min_size=2, max_size=3)

    def control(tag: str, given: list[Callable[[], Behaviour]]) -> Callable[[], Behaviour]:
        chosen = given[:2] if tag in TWO else given
        return lambda: node(known[tag], *(each() for each in chosen))

    def decoration(tag: str, given: Callable[[], Behaviour]) -> Callable[[], Behaviour]:
        return lambda: node(known[tag], given(), **IN_XML[tag])

    return st.one_of(
        st.tuples(several, st.booleans()).map(
            lambda given: lambda: Sequence("s", memory=given[1], children=[each() for each in given[0]])
        ),
        st.tuples(several, st.booleans()).map(
            lambda given: lambda: Selector("f", memory=given[1], children=[each() for each in given[0]])
        ),
        several.map(
            lambda given: lambda: Parallel("p", ParallelPolicy.SuccessOnOne(), children=[each() for each in given])
        ),
        st.tuples(st.sampled_from(sorted(DECORATORS)), children).map(
            lambda given: lambda: DECORATORS[given[0]](given[1]())
        ),
        st.tuples(st.sampled_from(CONTROLS), several).map(lambda given: control(*given)),
        st.tuples(st.sampled_from(sorted(IN_XML)), children).map(lambda given: decoration(*given)),
    )


@settings(max_examples=100, deadline=None)
@given(st.recursive(leaves(), above, max_leaves=8))
def test_what_is_impossible_does_not_happen(tree: Callable[[], Behaviour]) -> None:
    Blackboard.clear()
    coverage = TreeCoverage()
    root = tree()
    for each in root.iterate():
        each.setup()
    recorder = coverage.watch("tree", root)
    for second in range(12):
        with simulated_time(float(second)):
            recorder.tick()

    for seen in coverage.nodes("tree"):
        assert {each for each in (*ENDINGS, RUNNING) if seen.counts[each]} <= seen.possible, (
            seen.path,
            seen.kind,
            seen.possible,
        )
