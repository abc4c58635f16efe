"""Reports of recordings, and of runs whose world was changed."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from hmrsim.events import Event
from hmrsim.events.facilities import DoorClosed
from hmrsim.history.occurrence import Occurrence, SceneSeen
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.protocol.commands import CallService
from hmrsim.protocol.topics import Topic
from hmrsim.report import of_recording, report_of
from hmrsim.report.sink import ReportSink
from hmrsim.report.story import Story
from hmrsim.services import registry as services
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks.loading import world_of
from tests.unit.hmrsim.report.worlds import ALONE, CHARGING, FAULTY, MEETING


class _Late:
    """A sink that passes events on once there is a watcher."""

    watcher = None

    def wants(self, topic):
        """Return whether a watcher would listen to a topic."""
        return topic in (Topic.EVENTS, Topic.MOTION)

    def emit(self, event):
        if self.watcher is not None:
            self.watcher.emit(event)


def _recorded(world, *, since=0.0, battery=None):
    """Return a recording of a run's scripts, which may start late."""
    samples, late = [], _Late()
    simulator = Simulator(world_of(world, "test"), sinks=[late])
    simulator.advance(since)

    def keep(happened):
        stamp = Time.from_nanoseconds(happened.at).model_dump()
        event = happened.event
        if isinstance(event, SceneSeen):
            samples.append((happened.at, "_world/scene", dict(event.fields) | {"stamp": stamp}))
        elif isinstance(event, Event):
            samples.append((happened.at, "_world/events", event.to_json() | {"kind": event.kind, "stamp": stamp}))
        elif battery:
            samples.append((happened.at, f"{battery}/battery_state", _state(simulator, battery)))

    late.watcher = ReportSink(simulator, keep)
    simulator.run_scripts()
    end = samples[-1][0]
    return SimpleNamespace(
        samples=lambda: iter(samples), world=world, info={}, about={"seed": "3"}, end=end, truncated=False
    )


def _state(simulator, robot):
    return simulator.robots[robot].energy.state().model_dump(mode="json")


@pytest.mark.parametrize("world", [ALONE, MEETING, CHARGING])
def test_reports_of_recording_and_trace_agree(report, world):
    recorded, traced = report_of(of_recording(_recorded(world))), report(world)

    assert traced.goals == recorded.goals
    assert (traced.waits, traced.states, traced.lanes) == (recorded.waits, recorded.states, recorded.lanes)
    assert ("recording", True) == (recorded.source.kind, recorded.source.exact)


def test_energy_of_a_recording_is_that_of_its_battery_states():
    """They are in ampere hours at the nominal voltage."""
    (robot,) = report_of(of_recording(_recorded(CHARGING, battery="wall_e"))).robots

    assert pytest.approx(24.0) == robot.energy_used
    assert pytest.approx(24.0) == robot.energy_charged


def test_a_late_recording_takes_running_motions_from_its_scene():
    """One and a half of four metres are left."""
    found = report_of(of_recording(_recorded(ALONE, since=2.5)))
    (robot,) = found.robots

    assert (2.5, 7.5) == (robot.began, found.summary.sim_time)
    assert {"driving": 5.5, "busy": 2.0} == {state: time for state, time in robot.seconds.items() if time}
    assert "It begins 2.5 s after the simulation did; earlier events are missing." in found.source.notes


def test_a_motion_repeated_by_a_scene_counts_once():
    """The robot starts right after a reset, and a scene half a second later repeats its motion."""
    told = _recorded(ALONE)
    scene = next(payload for _, key, payload in told.samples() if key == "_world/scene")
    motion = {"began": 0.0, "from": [0.0, 0.0, 0.0], "to": [4.0, 0.0, 0.0], "duration": 4.0, "lane": ["home", "door"]}
    (robot,) = scene["robots"]
    again = {**scene, "robots": [{**robot, "motion": motion, "goals": []}], "stamp": {"sec": 0, "nanosec": 500_000_000}}
    drive = {**motion, "kind": "motion", "robot": "wall_e", "stamp": {"sec": 0, "nanosec": 1}}
    samples = [
        (1, "_world/scene", {**again, "robots": [{**robot, "motion": None, "goals": []}], "stamp": drive["stamp"]}),
        (1, "_world/events", {"kind": "reset", "scope": 255, "stamp": drive["stamp"]}),
        (1, "_world/events", drive),
        (500_000_000, "_world/scene", again),
    ]
    told.samples, told.end = lambda: iter(samples), 4_000_000_000
    found = report_of(of_recording(told))

    assert (4.0, 1) == (found.summary.distance, sum(lane.drives for lane in found.lanes))


def test_time_after_the_last_event_counts():
    told = _recorded(ALONE)
    told.end = 25_000_000_000
    found = report_of(of_recording(told))

    assert (25.0, 15.0) == (found.summary.sim_time, found.robots[0].seconds["idle"])


def test_an_invalid_end_is_ignored():
    told = _recorded(ALONE)
    told.end = 2**63

    assert 10.0 == report_of(of_recording(told)).summary.sim_time


@pytest.mark.parametrize(
    ("said", "seed"), [("3", 3), ("0", 0), ("", None), ("-1", None), ("\u0663", None), ("9" * 5000, None)]
)
def test_the_seed_is_that_of_the_recording_if_valid(said, seed):
    told = _recorded(ALONE)
    told.about["seed"] = said

    assert seed == report_of(of_recording(told)).world.seed


@pytest.mark.parametrize("share", [-4.5, 1.5, float("nan"), float("inf"), None, "much", 10**400])
def test_invalid_battery_states_are_skipped(share):
    told = _recorded(CHARGING, battery="wall_e")
    samples = list(told.samples())
    at, key, state = next(each for each in samples if each[1] == "wall_e/battery_state")
    samples.insert(samples.index((at, key, state)) + 1, (at, key, {**state, "percentage": share}))
    told.samples = lambda: iter(samples)

    assert pytest.approx(24.0) == report_of(of_recording(told)).robots[0].energy_used


@pytest.mark.parametrize(("back", "restarts"), [(1_000_000, 0), (1_000_001, 1)])
def test_a_step_back_by_a_millisecond_is_no_restart(back, restarts):
    """Messages may arrive over a network in another order."""
    story = Story()
    for at in (1_000_000_000, 1_000_000_000 - back):
        story.take(Occurrence(at, DoorClosed("d")))

    assert (restarts, 1_000_000_000) == (story.timeline.restarts, story.now)


def test_events_after_the_end_do_not_count():
    """Python may free the processes of robots some time later, which stops the robots."""
    story = Story()
    story.take(Occurrence(1_000_000_000, DoorClosed("d")))
    story.end()
    story.take(Occurrence(2_000_000_000, DoorClosed("d")))

    assert ({"door_closed": 1}, 1_000_000_000) == (story.counts, story.now)


def test_robots_count_while_they_exist(report):
    spawn = services()["spawn_entity"].request.model_validate(
        {"name": "eve", "uri": "robot_type:cart", "initial_pose": {"pose": {"position": {"x": 4.0}}}}
    )
    delete = services()["delete_entity"].request.model_validate({"entity": "eve"})
    commands = [(1.0, CallService("spawn_entity", spawn)), (3.0, CallService("delete_entity", delete))]
    found = report(ALONE, commands=commands)
    robots = {robot.name: (robot.began, robot.ended, robot.seconds["idle"]) for robot in found.robots}

    assert {"wall_e": (0.0, 10.0, 0.0), "eve": (1.0, 3.0, 2.0)} == robots


def test_a_goal_that_runs_out_of_patience_names_the_robot_in_its_way(report):
    world = MEETING | {
        "traffic": {"policy": "reserve", "patience": 5, "reroutes": 0},
        "robots": {
            "early": {"type": "cart", "at": "middle"},
            "late": {"type": "cart", "at": "south", "script": ["Go north"]},
        },
    }
    (error,) = report(world).errors

    assert ("late", 104, "PATIENCE_EXCEEDED") == (error.robot, error.error_code, error.error_name)
    assert "early" == error.waited_for
    assert 5.0 == error.at - error.waiting_since


def test_a_fault_at_the_start_is_in_the_report(report):
    """It is in the first scene, or an event at time 0."""
    found = report(FAULTY | {"faults": [FAULTY["faults"][0] | {"at": 0}]})

    assert [("flat_tyre", 0.0)] == [(fault.name, fault.began) for fault in found.faults]
