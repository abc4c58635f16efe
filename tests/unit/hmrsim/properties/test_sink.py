"""Watching a simulation while it runs."""

from __future__ import annotations

import pytest

from hmrsim.engine.sim_time import stamp
from hmrsim.events import from_json
from hmrsim.properties import Ended, Monitor, MonitorSink, properties_of
from hmrsim.protocol.outputs import EventStamped
from hmrsim.protocol.topics import Topic
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.testing import simulation
from hmrsim.world_checks.loading import world_of
from tests.watching import OFF, ward

WORLD = {
    "waypoints": {"home": [0, 0], "shelf": [5, 0]},
    "lanes": [["home", "shelf"]],
    "robot_types": {"cart": {"components": {"battery": {"capacity": 100.0}}}},
    "robots": {"eve": {"type": "cart", "at": "home", "script": ["Go shelf", "Wait 10", "Go home"]}},
}


@pytest.fixture
def run():
    """Return the function that runs the robot's script under a monitor of some properties."""

    def watched(said, built_in=OFF, until=60.0):
        world = world_of(dict(WORLD), "world")
        monitor = Monitor(properties_of({"properties": said, "built_in": dict(built_in)}), world)
        sinks = []

        def watchers(simulator):
            sinks.append(MonitorSink(simulator, monitor))
            return sinks

        simulator = Simulator(world, RunSettings(), watchers=watchers)
        simulator.advance(until)
        sinks[0].sample_batteries()
        monitor.end(round(until * 1e9), Ended("succeeded"))
        return monitor, sinks[0]

    return watched


@pytest.mark.parametrize(
    ("said", "wanted"),
    [
        ({}, {Topic.EVENTS}),
        ({"x": {"never": {"event": "picked"}}}, {Topic.EVENTS}),
        ({"x": {"never": {"battery": "eve", "below": 0.1}}}, {Topic.EVENTS}),
        ({"x": {"never": {"robot": "eve", "at": "shelf"}}}, {Topic.EVENTS, Topic.MOTION}),
    ],
)
def test_motions_are_computed_only_for_properties_about_places(said, wanted):
    world = world_of(dict(WORLD), "world")
    sink = MonitorSink(Simulator(world), Monitor(properties_of({"properties": said}), world))

    assert wanted == {topic for topic in Topic if sink.wants(topic)}


def test_batteries_are_read_at_every_event(run):
    """At 0.01 a second it is at 0.8 after 20 s, without a battery event."""
    monitor, _ = run({"low": {"always": {"battery": "eve", "above": 0.83}}})

    assert [20.0] == [violation.at / 1e9 for violation in monitor.violations]


def test_events_of_goals_have_status_and_result(run):
    monitor, _ = run({"done": {"sometimes": {"event": "status", "where": {"status": 4, "action": "wait"}}}})

    assert "status (status 4, action wait), once" == monitor.verdicts()[0].text


def test_built_in_properties_apply_to_scripts(run):
    monitor, _ = run({}, built_in={})

    assert ([], "3 goals have ended once") == (monitor.violations, monitor.verdicts()[0].text)


def test_a_mission_after_a_reset_is_watched_from_its_start_at_later_times():
    tree = "bt_controller.examples.hospital:mission"
    said = {"properties": {"x": {"never": {"robot": "eve", "at": "lab"}}}}
    with simulation("hospital", tree=tree) as run:
        simulator = run.simulator
        monitor = Monitor(properties_of(said), simulator.world)
        simulator._sinks.append(MonitorSink(simulator, monitor))
        simulator.interest.refresh()
        run.to_the_end()
        first = run.now
        run.client.get(run.client.keys.world("reset_simulation"), payload=b"{}")
        run.to_the_end()
        monitor.end(None, Ended("succeeded"))

    once, again = (violation.at / 1e9 for violation in monitor.violations)
    assert (71.543, 71.543) == (round(once, 3), round(again - first, 3))


def test_publishing_a_violation_does_not_advance_the_instant():
    said = {
        "closed": {"never": {"door": "gate", "is": "open"}},
        "opens": {"eventually": {"door": "gate", "is": "open"}, "within": 7},
    }
    world = ward()
    monitor = Monitor(properties_of({"properties": said, "built_in": dict(OFF)}), world)

    def publish(violation):
        event = {"kind": "property_violated", **violation.as_dict()}
        del event["fatal"]
        emit(event)

    def emit(event):
        simulator.publisher.emit(EventStamped(stamp(simulator.now), from_json(event)))

    simulator = Simulator(world, watchers=lambda each: [MonitorSink(each, monitor, publish)])
    for at, kind in ((5.0, "door_opened"), (10.0, "door_closed")):
        simulator.advance(at)
        emit({"kind": kind, "door": "gate"})
    monitor.end(stamp(20.0), Ended("succeeded"))

    assert [("closed", 5.0)] == [(each.property, each.at / 1e9) for each in monitor.violations]


@pytest.mark.parametrize(
    "said", [{"never": {"robot": "*", "at": "lab"}}, {"patrolling": ["hall"], "robot": "*", "every": 5}]
)
def test_a_property_about_places_needs_motions_before_the_first_robot(said):
    world = ward(robots={}, demand=[])
    monitor = Monitor(properties_of({"properties": {"x": said}, "built_in": dict(OFF)}), world)
    sink = MonitorSink(Simulator(world), monitor)
    wanted = sink.wants(Topic.MOTION)

    spawned = {"kind": "spawned", "entity": "eve", "type": "nurse", "at": [0.0, 0.0]}
    sink.emit(EventStamped(stamp(1.0), from_json(spawned)))
    monitor.end(stamp(20.0), Ended("succeeded"))

    assert (True, "eve") == (wanted, monitor.violations[0].subject)
