"""What a simulator logs."""

from __future__ import annotations

import logging
import os
import threading

import pytest

from hmrsim.cli.run_log import EventLog, Later, LogLines
from hmrsim.events import Severity
from hmrsim.events.facilities import DoorOpening
from hmrsim.events.robots import BatteryEmpty
from hmrsim.events.traffic import Deadlock, Rerouted, Waiting
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks import load_world

MEDICINE_ROOM = NavigateToPose.Goal.model_validate({"pose": {"pose": {"position": {"x": 512.0, "y": 215.0}}}})


def logged(sink):
    """Return a simulation of scenario 1 that is logged."""
    return Simulator(load_world("scenario1").world, sinks=[sink])


def test_goals_are_logged_with_target_and_end(caplog):
    """A goal that comes and one that arrives are a line each, with the simulated time."""
    simulator = logged(EventLog())

    with caplog.at_level(logging.INFO):
        simulator.submit(SendGoal("wall_e", "navigate_to_pose", MEDICINE_ROOM))
        simulator.run()

    assert [
        "sim 0.000 | wall_e navigate_to_pose accepted: (512, 215)",
        "sim 1.773 | wall_e navigate_to_pose SUCCEEDED",
    ] == caplog.messages


def test_an_aborted_goal_is_logged_with_the_reason(caplog):
    """The reason is that of the result."""
    simulator = logged(EventLog())

    with caplog.at_level(logging.INFO):
        simulator.submit(SendGoal("wall_e", "pickup", Pickup.Goal(target_name="moon")))
        simulator.run()

    last = caplog.records[-1]
    assert "sim 0.000 | wall_e pickup ABORTED: no item 'moon'; there are: medicine" == last.message
    assert logging.WARNING == last.levelno


def test_the_log_makes_the_simulation_compute_no_samples():
    """It takes events only, and none for each lane."""
    assert [Topic.EVENTS] == [topic for topic in Topic if EventLog().wants(topic)]
    assert [Topic.EVENTS] == [topic for topic in Topic if Later(EventLog()).wants(topic)]


def test_events_are_logged_at_the_level_of_their_severity(caplog):
    """Those that happen too often are not, unless debugging is asked for of the log itself."""
    log = EventLog()

    with caplog.at_level(logging.DEBUG):
        log.emit(EventStamped(2_000_000_000, BatteryEmpty("eve", 0.0, 0.0, (1.0, 2.0))))
        log.emit(EventStamped(2_000_000_000, DoorOpening("gate")))

    assert [("ERROR", "sim 2.000 | eve has an empty battery")] == [(r.levelname, r.message) for r in caplog.records]


def test_beside_a_table_warnings_are_logged(caplog):
    """The table has the goals, and who waits."""
    log = EventLog(Severity.WARNING, goals=False)

    with caplog.at_level(logging.INFO):
        log.emit(GoalChanged(1, "eve", "wait", "0" * 32, GoalStatus.ACCEPTED))
        log.emit(EventStamped(1, Rerouted("eve", (1.0, 2.0))))
        log.emit(EventStamped(1, Waiting("eve", (1.0, 2.0), for_=("ann",))))
        log.emit(EventStamped(1, Deadlock(("ann", "eve"), ())))

    assert ["sim 0.000 | deadlock of ann and eve"] == caplog.messages


def test_goals_can_be_logged_later(caplog):
    """The simulation does not wait for the log; the time in a line is that of the goal."""
    later = Later(EventLog())
    simulator = logged(later)

    with caplog.at_level(logging.INFO):
        simulator.submit(SendGoal("wall_e", "navigate_to_pose", MEDICINE_ROOM))
        simulator.run()
        at_once = list(caplog.messages)
        later.hand_on()

    assert [] == at_once
    assert "sim 1.773 | wall_e navigate_to_pose SUCCEEDED" == caplog.messages[-1]


def test_other_events_are_not_logged(caplog):
    """Executing and canceling are steps in between."""
    log = EventLog()

    with caplog.at_level(logging.INFO):
        log.emit(GoalChanged(1, "wall_e", "wait", "0" * 32, GoalStatus.CANCELING))
        log.emit(
            GoalChanged(1, "wall_e", "wait", "0" * 32, GoalStatus.CANCELED, result=Wait.Result(error_msg="canceled"))
        )

    assert ["sim 0.000 | wall_e wait CANCELED"] == caplog.messages


def test_log_lines_have_level_and_time():
    """Lines of our own packages and warnings of all are written."""
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
def test_log_lines_have_at_least_the_level_asked_for(level, written):
    """What is less grave is left out."""
    lines = []

    with LogLines(lines.append, level):
        for name in ("debug", "info", "error"):
            getattr(logging.getLogger("hmrsim_zenoh.server.server"), name)(name)

    assert written == [line.rpartition("| ")[2] for line in lines]


def test_logging_never_blocks():
    """Neither logging nor its end takes long while stderr is not read."""
    stuck = threading.Event()

    with LogLines(lambda _line: stuck.wait()):
        for i in range(11_000):
            logging.getLogger("hmrsim.cli.run").info("line %d", i)

    stuck.set()
    assert logging.getLogger().getEffectiveLevel() >= logging.WARNING


def test_lines_go_to_stderr_itself(monkeypatch):
    """Without a terminal lines are written past Python's buffers."""
    reading, writing = os.pipe()
    with os.fdopen(reading) as reader, os.fdopen(writing, "w") as writer:
        monkeypatch.setattr("sys.__stderr__", writer)
        with LogLines():
            logging.getLogger("hmrsim.cli.run").info("hello")
        line = reader.readline()

    assert line.endswith("| hello\n")
