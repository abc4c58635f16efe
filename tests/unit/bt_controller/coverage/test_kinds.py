"""The possible outcomes of a node at its place in a tree."""

from __future__ import annotations

import importlib

import pytest
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Failure, Running, Success
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Inverter, Retry, Timeout
from py_trees.timers import Timer

from bt_controller.behaviours.battery_guard import BatteryGuard
from bt_controller.behaviours.robot_actions import Wait
from bt_controller.coverage.kinds import _LEAVES, _PARENTS, possible_outcomes


def possible(root, name):
    """Return what can happen to the node of a name, without RUNNING."""
    return next(outcomes for node, outcomes in possible_outcomes(root).items() if node.name == name) - {"RUNNING"}


def sequence(*children, memory=True):
    return Sequence("Root", memory=memory, children=list(children))


@pytest.mark.parametrize("name", [*_LEAVES, *_PARENTS])
def test_each_kind_exists(name):
    module, _, kind = name.rpartition(".")

    assert issubclass(getattr(importlib.import_module(module, "bt_controller"), kind), object)


@pytest.mark.parametrize(
    ("root", "name", "expected"),
    [
        (sequence(Timer("A", 1.0)), "A", {"SUCCESS"}),
        (sequence(Timer("A", 1.0)), "Root", {"SUCCESS"}),
        (sequence(Wait(1.0, name="A")), "A", {"SUCCESS", "FAILURE"}),
        (sequence(Success("A"), Failure("B")), "Root", {"FAILURE"}),
        (sequence(Wait(1.0, name="A"), Wait(1.0, name="B"), memory=False), "A", {"SUCCESS", "FAILURE"}),
        (sequence(Wait(1.0, name="A"), Wait(1.0, name="B"), memory=False), "B", {"SUCCESS", "FAILURE", "CANCELED"}),
        (sequence(Timeout("T", Wait(1.0, name="A"))), "A", {"SUCCESS", "FAILURE", "CANCELED"}),
        (sequence(Timeout("T", sequence(Timer("A", 1.0)))), "A", {"SUCCESS", "CANCELED"}),
        (BatteryGuard("G", Wait(1.0, name="A"), Wait(1.0, name="B")), "A", {"SUCCESS", "FAILURE", "CANCELED"}),
        (Retry("R", Wait(1.0, name="A"), 3), "A", {"SUCCESS", "FAILURE", "RECOVERED"}),
        (Retry("R", Inverter("I", Wait(1.0, name="A")), 3), "A", {"SUCCESS", "FAILURE"}),
        (Inverter("I", Failure("A")), "I", {"SUCCESS"}),
        (Selector("S", memory=True, children=[Failure("A"), Failure("B")]), "A", {"FAILURE", "RECOVERED"}),
        (Selector("S", memory=True, children=[Failure("A"), Failure("B")]), "B", {"FAILURE"}),
        (Parallel("P", ParallelPolicy.SuccessOnOne(), children=[Running("A"), Success("B")]), "A", {"CANCELED"}),
        (Parallel("P", ParallelPolicy.SuccessOnOne(), children=[Running("A")]), "A", set()),
    ],
)
def test_what_is_possible_depends_on_kind_and_place(root, name, expected):
    assert expected == possible(root, name)


class Own(Behaviour):
    """A leaf of a user's."""

    def update(self):
        return Status.SUCCESS


def test_of_an_unknown_kind_anything_is_possible():
    """It may well be, as far as is known."""
    assert {"SUCCESS", "FAILURE"} == possible(sequence(Own("A")), "A")


def test_a_users_class_is_not_taken_for_a_node_of_the_same_name():
    own = type("ToBlackboard", (Own,), {"__module__": "behaviours.places"})

    assert {"SUCCESS", "FAILURE"} == possible(sequence(own("A")), "A")
