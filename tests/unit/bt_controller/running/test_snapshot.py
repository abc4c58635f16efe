"""Snapshots of trees, and the reasons of their failures."""

from __future__ import annotations

from enum import Enum

import pytest
from py_trees.behaviours import Failure, Running, Success
from py_trees.blackboard import Blackboard
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Inverter
from py_trees.display import unicode_tree

from bt_controller.core.node import Control
from bt_controller.coverage import TreeCoverage
from bt_controller.loading.trees import Plan
from bt_controller.running.mission import Mission
from bt_controller.running.snapshot import board_values, nodes_of, reasons, tip
from hmrsim.interfaces.geometry_msgs import Point
from hmrsim_zenoh.wire.descriptions import TreeState


def ticked(root):
    """Return the behaviors of a tree after a tick."""
    root.tick_once()
    return nodes_of(root)


def mission(function):
    return Mission("wall_e", Plan("test", function, takes_robot=False, confirmed=False))


class PipelineSequence(Control):
    """A control with the name of Nav2's."""


class RecoveryNode(Control):
    """As nothing of py_trees does."""


class Found(Enum):
    """A value on a blackboard."""

    LEFT = "left"


class TestSymbols:
    """Each kind of behavior has its symbol."""

    def test_a_tree_is_drawn_as_py_trees_draws_it(self):
        root = Parallel(
            "Parallel",
            policy=ParallelPolicy.SuccessOnAll(),
            children=[
                Sequence("Remembers", memory=True, children=[Success("A")]),
                Sequence("Forgets", memory=False, children=[Inverter("Not", Success("B"))]),
                Selector("Chooses", memory=True),
                Selector("Chooses again", memory=False),
            ],
        )

        assert unicode_tree(root).splitlines() == [node.line(status=False) for node in nodes_of(root)]

    @pytest.mark.parametrize(("kind", "symbol"), [(PipelineSequence, "[-]"), (RecoveryNode, "{*}"), (Success, "-->")])
    def test_nodes_of_files_have_symbols_too(self, kind, symbol):
        assert f"{symbol} Node" == nodes_of(kind("Node"))[0].line(status=False)

    def test_the_place_in_a_file_is_given(self):
        node = RecoveryNode("Node")
        node.origin = "nav.xml:7"

        assert "nav.xml:7" == nodes_of(node)[0].to_json()["origin"]

    @pytest.mark.parametrize("message", ["a\nb", "a\x1bb"])
    def test_a_message_can_not_garble_the_terminal(self, message):
        leaf = Success("Leaf")
        leaf.tick_once()
        leaf.feedback_message = message

        assert "--> Leaf [✓] -- a b" == nodes_of(leaf)[0].line()


def sequence(name, *children):
    return Sequence(name, memory=True, children=children)


def selector(name, *children):
    return Selector(name, memory=False, children=children)


@pytest.mark.parametrize(
    ("root", "names"),
    [
        (sequence("Root", Success("First"), sequence("Inner", Success("A"), Failure("B"), Success("C"))), ["B"]),
        (selector("Root", Failure("A"), sequence("B", Failure("C"))), ["A", "C"]),
        (sequence("Root", selector("Choice", Failure("A"), Success("B")), Failure("C")), ["C"]),
        (sequence("Root", Inverter("Not", Success("A"))), ["Not"]),
        (selector("Root", Failure("A"), Success("B")), []),
    ],
    ids=[
        "the step that failed",
        "all choices",
        "no failed child of a successful selector",
        "a decorator that fails although its child does not",
        "nothing in a tree that has not failed",
    ],
)
def test_the_reasons_of_a_failure_are_the_deepest_failed_behaviors(root, names):
    assert names == [node.name for node in reasons(ticked(root))]


@pytest.mark.parametrize(
    ("root", "name"),
    [
        (sequence("Root", Success("A"), Running("B"), Success("C")), "B"),
        (sequence("Root", Success("A"), Failure("B")), "B"),
        (sequence("Root", Success("A")), "Root"),
    ],
    ids=["what runs", "what failed in the end", "the root where nothing is left to say"],
)
def test_the_tip_is_the_current_behavior(root, name):
    assert name == tip(ticked(root)).name


class TestBlackboard:
    """A snapshot has the entries of the blackboard as JSON values."""

    def test_values_are_listed_by_key(self):
        storage = {"/b": [Found.LEFT, 1.5], "/a/code": 208, "/p": {"at": Point(x=1.0)}, "/e": ()}

        at = {"x": 1.0, "y": 0.0, "z": 0.0}
        assert {"a/code": 208, "b": ["left", 1.5], "e": [], "p": {"at": at}} == board_values(storage)

    def test_infinity_is_null(self):
        """JSON has no number for it."""
        assert {"a": None} == board_values({"/a": float("inf")})

    @pytest.mark.parametrize("value", [object(), [object()], print])
    def test_what_json_can_not_say_is_left_out(self, value):
        assert {"b": 1} == board_values({"/a": value, "/b": 1})

    @pytest.mark.parametrize(
        "key", ["/Spin_0f8fad5b-d9cb-469f-a165-70867728950e/error", "/Wait_0f8fad5bd9cb469fa16570867728950e/x__const"]
    )
    def test_keys_that_py_trees_made_up_are_left_out(self, key):
        """Such keys differ from run to run and have no meaning."""
        assert {} == board_values({key: 1})

    def test_a_snapshot_has_the_blackboard_of_its_robot_if_asked(self):
        other, one = mission(lambda: Success("Root")), mission(lambda: Success("Root"))
        with one._board.in_use:
            Blackboard.set("code", 208)

        known = [each.snapshot(0.0, blackboard=True).blackboard for each in (other, one)]
        assert [{}, {"code": 208}, None] == [*known, one.snapshot(0.0).blackboard]


class TestEnd:
    """A snapshot shows if its tree has ended."""

    def test_a_tree_that_is_over_has_ended(self):
        one = mission(lambda: Failure("Root"))
        before = one.snapshot(0.0).ended
        one.tick(0.0)

        assert (False, True) == (before, one.snapshot(0.0).ended)

    def test_a_tree_that_was_stopped_has_ended(self):
        one = mission(lambda: Running("Root"))
        one.tick(0.0)
        one.interrupt()

        snapshot = one.snapshot(0.0)
        assert (True, Status.INVALID) == (snapshot.ended, snapshot.status)


def test_json_is_what_the_schema_says():
    one = mission(lambda: Sequence("Root", memory=True, children=[Success("A"), Running("B")]))
    one.tick(1.5)
    told = one.snapshot(1.5, blackboard=True).to_json()

    assert told == TreeState.model_validate(told).model_dump(mode="json", exclude_defaults=True)


def test_json_has_the_coverage_if_it_is_counted():
    steps = [Failure("A"), Success("B")]
    plan = Plan("test", lambda: Selector("Root", memory=True, children=steps), takes_robot=False, confirmed=False)
    one = Mission("wall_e", plan, coverage=TreeCoverage())
    one.tick(1.5)
    told = one.snapshot(1.5, blackboard=True).to_json()

    assert told == TreeState.model_validate(told).model_dump(mode="json", exclude_defaults=True)
    assert {"counts": {"FAILURE": 1, "RECOVERED": 1}, "never": []} == told["nodes"][1]["coverage"]
