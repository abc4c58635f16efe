"""Properties observe the same states and places of robots as the simulator and its reports."""

from __future__ import annotations

import pytest

from hmrsim.geometry import distance
from hmrsim.history.robots import STATES
from hmrsim.properties import Monitor, MonitorSink, Properties
from hmrsim.properties.signals import FAILS
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.report.sink import ReportSink
from hmrsim.report.story import Story
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.demand import NEAR
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks import load_world

EDGE = 1e-6
"""How near to the edge of a circle a robot may be on either side, as stamps are whole nanoseconds."""


class _Comparing:
    """A sink that compares the observed state with the real one at each event."""

    def __init__(self, simulator, world, places):
        self.simulator, self.world = simulator, world
        self.monitor = Monitor(Properties(), world)
        seen = self.monitor.observations
        self.near = {(robot, place): seen.positions.near(robot, place) for robot in world.robots for place in places}
        self.states = {
            (robot, state): seen.is_(seen.history.robots, robot, state) for robot in world.robots for state in STATES
        }
        self.sink = MonitorSink(simulator, self.monitor)
        self.story = Story()
        self.report = ReportSink(simulator, self.story.take)
        self.wrong, self.compared, self.reached = [], 0, 0
        self.at = 0

    def wants(self, topic):
        return topic in (Topic.EVENTS, Topic.MOTION)

    def emit(self, output):
        """Compare at the first output of each instant, when the last one is over."""
        if isinstance(output, (EventStamped, GoalChanged)):
            if output.stamp > self.at:
                self.at = output.stamp
                self.monitor.timeline.look(output.stamp)
                self.compare()
            self.report.emit(output)
            self.sink.emit(output)

    def compare(self):
        radius = NEAR[self.world.units]
        for (robot, place), signal in self.near.items():
            piece = self.simulator.robots[robot].piece
            if piece is not None and piece.leg is not None and piece.leg.ride:
                # It is still in the lift at the instant at which that arrives, of which this is the first output.
                continue
            away = distance(self.simulator.robots[robot].pose().point, self.world.point(place))
            self.compared += 1
            self.reached += signal.value > 0
            if abs(away - radius) > EDGE and (away < radius) is not (signal.value > 0):
                self.wrong.append((self.at, robot, place, away))


@pytest.mark.parametrize(
    ("name", "until"), [("zoo/corridor_swap", 120.0), ("zoo/crossing", 120.0), ("zoo/lift", 120.0), ("warehouse", 12.0)]
)
def test_robots_are_seen_where_they_are(name, until):
    world = load_world(name).world
    places = [*world.places, *world.waypoints][:12]
    made = []

    def watchers(simulator):
        made.append(_Comparing(simulator, world, places))
        return made

    simulator = Simulator(world, RunSettings(), watchers=watchers)
    simulator.advance(until)

    (comparing,) = made
    assert ([], True, True) == (comparing.wrong[:5], comparing.compared > 10, comparing.reached > 0)


@pytest.mark.parametrize(
    ("name", "until"), [("zoo/charger_queue", 600.0), ("zoo/crossing", 120.0), ("warehouse", 20.0)]
)
def test_the_states_of_robots_are_those_of_reports(name, until):
    world = load_world(name).world
    made, spans = [], {}

    def watchers(simulator):
        made.append(_Comparing(simulator, world, []))
        return made

    simulator = Simulator(world, RunSettings(), watchers=watchers)
    (comparing,) = made
    timeline = comparing.monitor.timeline
    for (robot, state), signal in comparing.states.items():
        since = {"at": 0}

        def changed(robot=robot, state=state, signal=signal, since=since):
            if signal.value > 0:
                since["at"] = timeline.now
            else:
                spans[robot, state] = spans.get((robot, state), 0) + timeline.now - since["at"]

        signal.subscribe(changed)
    simulator.advance(until)
    end = round(until * 1e9)
    timeline.look(end)
    timeline.end(end)
    for signal in comparing.states.values():
        signal.set(FAILS)
    comparing.story.end(end)

    told = {
        (track.name, state): sum(ended - began for began, ended, at in track.spans if at == state)
        for track in comparing.story.robot_log.tracks.values()
        for state in STATES
    }
    assert {key: value for key, value in told.items() if value > 5} == pytest.approx(
        {key: value for key, value in spans.items() if value > 5}, abs=1_000
    )
