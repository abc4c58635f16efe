"""The log of changes of statuses."""

from __future__ import annotations

import io
import json
import logging

import pytest
from py_trees.behaviours import Failure, Running, StatusQueue, Success
from py_trees.common import Status
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Retry

from bt_controller.core.subtrees import paths
from bt_controller.loading.trees import Plan
from bt_controller.running.mission import Mission
from bt_controller.watching.display import Transitions


class Log:
    """Ticks a tree and keeps the log of its transitions."""

    def __init__(self, function):
        self.out = io.StringIO()
        self.mission = Mission("wall_e", Plan("test", function, takes_robot=False, confirmed=False))
        self.transitions = Transitions(self.out, [self.mission])

    def tick(self, now):
        self.mission.tick(now)
        self.transitions.ticked(self.mission, now)

    @property
    def lines(self):
        """Return what was logged: time, path, from and to."""
        lines = [json.loads(line) for line in self.out.getvalue().splitlines()]
        return [(line["sim_time"], line["node"], line["from"], line["to"]) for line in lines]


def test_a_line_says_what_became_of_a_behaviour():
    log = Log(lambda: Running("Root"))
    log.tick(1.5)

    line = {"sim_time": 1.5, "robot": "wall_e", "node": "Root", "from": "INVALID", "to": "RUNNING", "message": ""}
    assert [line] == [{**json.loads(each), "message": ""} for each in log.out.getvalue().splitlines()]


def test_an_unchanged_status_is_not_a_transition():
    log = Log(lambda: Sequence("Root", memory=True, children=[Success("A"), Running("B")]))
    log.tick(1.0)
    log.tick(2.0)

    assert [
        (1.0, "Root/A", "INVALID", "SUCCESS"),
        (1.0, "Root/B", "INVALID", "RUNNING"),
        (1.0, "Root", "INVALID", "RUNNING"),
    ] == log.lines


def test_what_is_reset_within_a_tick_is_logged():
    first = [Status.FAILURE, Status.RUNNING]
    log = Log(
        lambda: Selector("Root", memory=False, children=[StatusQueue("A", queue=first, eventually=None), Running("B")])
    )
    log.tick(1.0)
    log.tick(2.0)

    assert [(2.0, "Root/A", "FAILURE", "RUNNING"), (2.0, "Root/B", "RUNNING", "INVALID")] == log.lines[3:]


def test_what_fails_and_is_tried_again_is_logged_each_time():
    log = Log(lambda: Retry("Root", Sequence("Try", memory=True, children=[Success("A"), Failure("B")]), 2))
    log.tick(1.0)
    log.tick(2.0)

    assert [
        (1.0, "Root/Try/A", "INVALID", "SUCCESS"),
        (1.0, "Root/Try/B", "INVALID", "FAILURE"),
        (1.0, "Root/Try", "INVALID", "FAILURE"),
        (1.0, "Root", "INVALID", "RUNNING"),
        (2.0, "Root/Try/A", "SUCCESS", "INVALID"),
        (2.0, "Root/Try/B", "FAILURE", "INVALID"),
        (2.0, "Root/Try/A", "INVALID", "SUCCESS"),
        (2.0, "Root/Try/B", "INVALID", "FAILURE"),
        (2.0, "Root", "RUNNING", "FAILURE"),
    ] == log.lines


def test_what_is_stopped_after_the_last_tick_is_logged():
    log = Log(lambda: Running("Root"))
    log.tick(1.0)
    log.mission.interrupt()
    log.transitions.flush(3.0)

    assert [(1.0, "Root", "INVALID", "RUNNING"), (3.0, "Root", "RUNNING", "INVALID")] == log.lines


def test_siblings_of_one_name_are_numbered():
    inner = Sequence("B", memory=True, children=[Success("C")])
    root = Sequence("A", memory=True, children=[Success("B"), inner, Success("C")])

    assert ["A", "A/B[1]", "A/B[2]", "A/B[2]/C", "A/C"] == [path for _, path in paths(root)]


def test_people_read_it_in_the_log(caplog):
    caplog.set_level(logging.INFO, "bt_controller.watching.display")
    mission = Mission("wall_e", Plan("test", lambda: Running("Root"), takes_robot=False, confirmed=False))
    mission.root.feedback_message = "on its way"
    transitions = Transitions(None, [mission])
    mission.root.update = lambda: Status.RUNNING
    mission.tick(1.5)
    transitions.ticked(mission, 1.5)

    assert ["1.500 wall_e: Root: INVALID -> RUNNING: on its way"] == caplog.messages


@pytest.mark.parametrize(("level", "wanted"), [(logging.INFO, True), (logging.WARNING, False)])
def test_transitions_are_watched_only_if_they_are_logged(caplog, level, wanted):
    caplog.set_level(level, "bt_controller.watching.display")

    assert wanted == Transitions.wanted()
