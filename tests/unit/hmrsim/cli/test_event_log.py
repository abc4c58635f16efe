"""The log of a simulation."""

from __future__ import annotations

import logging
import os
import threading
from types import SimpleNamespace

import pytest

from hmrsim.cli.event_log import BufferedSink, EventLog, LogDisplay, LogLines, summary, text_of
from hmrsim.events import Severity
from hmrsim.events.facilities import DoorOpening
from hmrsim.events.goals import GoalAccepted, GoalStatusChanged
from hmrsim.events.robots import BatteryEmpty, Stopped
from hmrsim.events.traffic import Deadlock, Rerouted, Waiting
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import DockRobot, FollowWaypoints, NavigateToPose, Wait
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks import load_world
from tests.shipped import shipped

MEDICINE_ROOM = NavigateToPose.Goal.model_validate({"pose": {"pose": {"position": {"x": 512.0, "y": 215.0}}}})


def logged(sink):
    return Simulator(load_world("scenario1").world, sinks=[sink])


def test_goals_are_logged_with_target_and_end(caplog):
    simulator = logged(EventLog())

    with caplog.at_level(logging.INFO):
        simulator.submit(SendGoal("wall_e", "navigate_to_pose", MEDICINE_ROOM))
        simulator.run()

    assert [
        "sim 0.000 | wall_e navigate_to_pose accepted: (512, 215)",
        "sim 1.773 | wall_e navigate_to_pose SUCCEEDED",
    ] == caplog.messages


def test_an_accepted_goal_is_logged_once(caplog):
    """Clients and the page also receive it as an event."""
    log = EventLog()

    with caplog.at_level(logging.INFO):
        log.emit(EventStamped(0, GoalAccepted("eve", "wait", "1" * 32, {"time": {"sec": 5}})))
        log.emit(GoalChanged(0, "eve", "wait", "1" * 32, GoalStatus.ACCEPTED, Wait.Goal(time=Duration(sec=5))))

    assert ["sim 0.000 | eve wait accepted: 5 s"] == caplog.messages


def test_an_aborted_goal_is_logged_with_the_reason(caplog):
    simulator = logged(EventLog())

    with caplog.at_level(logging.INFO):
        simulator.submit(SendGoal("wall_e", "pickup", Pickup.Goal(target_name="moon")))
        simulator.run()

    last = caplog.records[-1]
    assert "sim 0.000 | wall_e pickup ABORTED: no item 'moon'; there are: medicine" == last.message
    assert logging.WARNING == last.levelno


def test_the_log_makes_the_simulation_compute_no_samples():
    """Samples of motion cost time, and the log needs none."""
    assert [Topic.EVENTS] == [topic for topic in Topic if EventLog().wants(topic)]
    assert [Topic.EVENTS] == [topic for topic in Topic if BufferedSink(EventLog()).wants(topic)]


def test_events_are_logged_at_the_level_of_their_severity(caplog):
    log = EventLog()

    with caplog.at_level(logging.DEBUG):
        log.emit(EventStamped(2_000_000_000, BatteryEmpty("eve", 0.0, 0.0, (1.0, 2.0))))
        log.emit(EventStamped(2_000_000_000, DoorOpening("gate")))

    assert [("ERROR", "sim 2.000 | eve has an empty battery")] == [(r.levelname, r.message) for r in caplog.records]


def test_beside_the_table_only_warnings_are_logged(caplog):
    log = EventLog(Severity.WARNING, goals=False)

    with caplog.at_level(logging.INFO):
        log.emit(GoalChanged(1, "eve", "wait", "0" * 32, GoalStatus.ACCEPTED))
        log.emit(EventStamped(1, Rerouted("eve", (1.0, 2.0))))
        log.emit(EventStamped(1, Waiting("eve", (1.0, 2.0), for_=("ann",))))
        log.emit(EventStamped(1, Deadlock(("ann", "eve"), ())))

    assert ["sim 0.000 | deadlock of ann and eve"] == caplog.messages


def test_a_late_log_has_the_time_of_the_goal(caplog):
    later = BufferedSink(EventLog())
    simulator = logged(later)

    with caplog.at_level(logging.INFO):
        simulator.submit(SendGoal("wall_e", "navigate_to_pose", MEDICINE_ROOM))
        simulator.run()
        at_once = list(caplog.messages)
        later.forward()

    assert [] == at_once
    assert "sim 1.773 | wall_e navigate_to_pose SUCCEEDED" == caplog.messages[-1]


def test_intermediate_statuses_are_not_logged(caplog):
    log = EventLog()

    with caplog.at_level(logging.INFO):
        log.emit(GoalChanged(1, "wall_e", "wait", "0" * 32, GoalStatus.CANCELING))
        log.emit(
            GoalChanged(1, "wall_e", "wait", "0" * 32, GoalStatus.CANCELED, result=Wait.Result(error_msg="canceled"))
        )

    assert ["sim 0.000 | wall_e wait CANCELED"] == caplog.messages


def test_log_lines_have_level_and_time():
    lines = []

    with LogLines(lines.append):
        logging.getLogger("hmrsim.cli.run").info("sim %.3f | hospital begins", 0)
        logging.getLogger("somebody.else").info("nobody wants to know")
        logging.getLogger("somebody.else").warning("slow")

    assert ["[INFO", "[WARNING"] == [line.partition("] ")[0] for line in lines]
    assert lines[0].endswith(" | sim 0.000 | hospital begins")


@pytest.mark.parametrize(
    ("level", "written"),
    [(logging.DEBUG, ["debug", "info", "error"]), (logging.INFO, ["info", "error"]), (logging.ERROR, ["error"])],
)
def test_log_lines_have_at_least_the_level(level, written):
    lines = []

    with LogLines(lines.append, level):
        for name in ("debug", "info", "error"):
            getattr(logging.getLogger("hmrsim_zenoh.server.server"), name)(name)

    assert written == [line.rpartition("| ")[2] for line in lines]


def test_logging_never_waits_for_stderr():
    stuck = threading.Event()

    with LogLines(lambda _line: stuck.wait()):
        for i in range(11_000):
            logging.getLogger("hmrsim.cli.run").info("line %d", i)

    stuck.set()
    assert logging.getLogger().getEffectiveLevel() >= logging.WARNING


def test_lines_bypass_the_buffer_of_stderr(monkeypatch):
    reading, writing = os.pipe()
    with os.fdopen(reading) as reader, os.fdopen(writing, "w") as writer:
        monkeypatch.setattr("sys.__stderr__", writer)
        with LogLines():
            logging.getLogger("hmrsim.cli.run").info("hello")
        line = reader.readline()

    assert line.endswith("| hello\n")


@pytest.mark.parametrize(
    ("event", "text"),
    [
        (Waiting("eve", (1.0, 2.0), for_=("ann", "bob")), "waits for ann and bob"),
        (GoalAccepted("eve", "wait", "1" * 32, {"time": {"sec": 5}}), "wait accepted: 5 s"),
        (GoalAccepted("eve", "wait", "1" * 32, {"time": "long"}), "wait accepted"),
        (GoalAccepted("eve", "juggle", "1" * 32, {"balls": 3}), "juggle accepted"),
        (GoalStatusChanged("eve", "wait", "1" * 32, 6, {"error_msg": "no"}), "wait ABORTED: no"),
        (GoalStatusChanged("eve", "wait", "1" * 32, 2), ""),
        (Stopped("eve", (1.0, 2.0)), ""),
    ],
)
def test_the_text_of_an_event_has_the_goal_of_known_actions(event, text):
    assert text == text_of(event)


def pose(x, y):
    return PoseStamped(pose=Pose(position=Point(x=x, y=y)))


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        (NavigateToPose.Goal(pose=pose(512.0, 215.5)), "(512, 215.5)"),
        (NavigateToPose.Goal(), "(0, 0)"),
        (DockRobot.Goal(dock_id="charger_4"), "charger_4"),
        (Pickup.Goal(target_name="medicine"), "medicine"),
        (Wait.Goal(time=Duration(sec=2, nanosec=500_000_000)), "2.5 s"),
        (FollowWaypoints.Goal(poses=[pose(float(i), 0.0) for i in range(5)]), "(0, 0), (1, 0), (2, 0), and 2 more"),
        (Pickup.Goal.model_validate_json(Pickup.Goal(target_name="linen").model_dump_json()), "linen"),
    ],
)
def test_a_summary_omits_default_values(goal, words):
    assert words == summary(goal)


def test_events_are_logged_at_levels_without_goals(caplog):
    display = LogDisplay("ward", logging.ERROR)

    with caplog.at_level(logging.ERROR):
        for event in (DoorOpening("gate"), BatteryEmpty("eve", 0.0, 0.0, (1.0, 2.0))):
            for sink in display.sinks:
                sink.emit(EventStamped(0, event))
        for tell in display.on_wait:
            tell()

    assert ["sim 0.000 | eve has an empty battery"] == caplog.messages


def test_the_log_begins_with_the_traffic_policy(caplog):
    simulator = SimpleNamespace(now=0.0, world=shipped("cafe").world)
    host = SimpleNamespace(simulator=simulator, pacing=SimpleNamespace(state=SimpleNamespace(waiting_for=())))

    with caplog.at_level(logging.INFO), LogDisplay("cafe", logging.INFO).shown(host):
        pass

    assert ["sim 0.000 | cafe begins", "sim 0.000 | traffic policy: priority"] == caplog.messages[:2]
