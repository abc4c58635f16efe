"""The topics for RViz and Foxglove: maps, markers, models, plans, footprints and scans.

Each is computed only while it has a subscriber.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from hmrsim.engine.sim_time import stamp
from hmrsim.events.robots import RouteTaken
from hmrsim.events.simulation import Deleted, SimulationReset, Spawned, Teleported, WorldLoaded
from hmrsim.protocol.goal import WORLD
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.snapshot import scene
from hmrsim_zenoh.ros2.publishing import views
from hmrsim_zenoh.ros2.publishing.endpoints import (
    FOOTPRINT,
    MAP_TOPIC,
    MARKERS,
    PLAN,
    ROBOT_DESCRIPTION,
    SCAN,
    TF_STATIC,
    THINGS,
    topic_name,
)
from hmrsim_zenoh.ros2.publishing.markers import WorldMarkers
from hmrsim_zenoh.ros2.publishing.scan import Scanner

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import EventStamped
    from hmrsim.robots.robot import Robot
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World
    from hmrsim_zenoh.ros2.publishing.endpoints import Part
    from hmrsim_zenoh.ros2.publishing.publishers import TopicPublishers
    from hmrsim_zenoh.server.interest import SubscriberWatch

_LATCHED: Final = (MAP_TOPIC, TF_STATIC, ROBOT_DESCRIPTION, MARKERS, THINGS)
_STREAMS: Final = (PLAN, FOOTPRINT, SCAN)
"""The topics that are published regularly, for those robots whose topics have had a subscriber."""

_REPLACES_THINGS: Final = (Spawned, Deleted, Teleported, SimulationReset, WorldLoaded)
"""The events after which items and doors are read anew."""

_PLAN_SECONDS: Final = 1.0
"""Simulated seconds between two messages of an unchanged plan, as Nav2's default tree plans once per second."""


_PLAN, _THINGS = f"/*/{PLAN}", f"/{THINGS}"


class ViewTopics:
    """Publishes the topics that viewers show, each while it has a subscriber.

    Latched topics are published when the token of a new subscriber comes, and when the world or its robots change.

    Args:
        changed: Called in another thread when a latched topic gets a subscriber; `look` has to be called then.
    """

    def __init__(
        self,
        simulator: Simulator,
        publishers: TopicPublishers,
        interest: SubscriberWatch[str],
        changed: Callable[[], None],
    ) -> None:
        self._simulator = simulator
        self._encoded, self._publish = publishers.encoded, publishers.publish
        self._interest = interest
        self._changed = changed
        self._asked: deque[tuple[str, str]] = deque()
        self._shown: dict[tuple[str, str], None] = {}
        self._map: tuple[World, bytes] | None = None
        self._markers = WorldMarkers()
        self._things_changed = self._things_replaced = False
        # The robots whose streams have had a subscriber; cleared when no robot's stream has one any longer.
        self._streamed: dict[str, set[str]] = {topic: set() for topic in _STREAMS}
        self._heard: set[str] = set()
        self._scanner = Scanner(simulator.world)
        self._planned = 0.0
        self._planning: set[str] = set()
        self._make: Mapping[str, Callable[[str], Mapping[str, Any]]] = {
            TF_STATIC: partial(views.static_transforms, simulator),
            ROBOT_DESCRIPTION: partial(views.urdf, simulator),
            MARKERS: self._static_markers,
            THINGS: self._things,
        }

    def ask(self, part: Part, name: str) -> None:
        """Publish a topic for a new subscriber, if it is one that viewers show; from any thread."""
        topic = name[1:] if part.robot == WORLD else name[len(part.robot) + 2 :]
        if topic in _LATCHED or topic in _STREAMS:
            self._asked.append((part.robot, topic))
            self._changed()

    def wants(self, topic: Topic) -> bool:
        """Return whether outputs of the simulation are needed; samples of the clock are, as each one calls `tick`."""
        interest = self._interest
        return (
            (topic is Topic.MOTION and interest[_PLAN])
            or (topic is Topic.EVENTS and interest[_THINGS])
            or (topic is Topic.CLOCK and (interest[_THINGS] or any(interest[f"/*/{stream}"] for stream in _STREAMS)))
        )

    def look(self) -> None:
        """Publish the topics that have new subscribers."""
        while self._asked:
            robot, topic = self._asked.popleft()
            if topic in _LATCHED:
                self._shown[robot, topic] = None
                self._publish_latched(robot, topic)
            else:
                self._streamed[topic].add(robot)
                self._planned = -_PLAN_SECONDS
        # A subscriber's token may arrive before the subscriber itself.
        before, self._heard = self._heard, {topic for topic in _STREAMS if self._interest[f"/*/{topic}"]}
        for topic in before - self._heard:
            self._streamed[topic].clear()

    def follow(self) -> None:
        """Publish the topics again that have subscribers, after robots came or went or the world was replaced."""
        robots = self._simulator.roster.robots

        def shows(robot: str, topic: str) -> bool:
            return self._interest[topic_name(robot if robot == WORLD else "*", topic)]

        for streamed in self._streamed.values():
            streamed.intersection_update(robots)
        self._shown = {key: None for key in self._shown if (key[0] in robots or key[0] == WORLD) and shows(*key)}
        for key in self._shown:
            self._publish_latched(*key)

    def _publish_latched(self, robot: str, topic: str) -> None:
        if robot != WORLD and robot not in self._simulator.roster.robots:
            return
        if topic == MAP_TOPIC:
            self._publish(robot, topic, self._encoded_map())
        else:
            self._publish(robot, topic, self._make[topic](robot))

    def _encoded_map(self) -> bytes:
        """Return the map, which is the same until another world is loaded."""
        world = self._simulator.world
        if self._map is None or self._map[0] is not world:
            values = views.occupancy_grid(self._simulator)
            self._map = world, self._encoded(MAP_TOPIC, values)
        return self._map[1]

    def event(self, output: EventStamped) -> None:
        """Apply an event of the world."""
        event = output.event
        if isinstance(event, RouteTaken):
            if event.robot in self._streamed[PLAN]:
                self._plan(event.robot)
        elif self._interest[_THINGS]:
            self._things_replaced |= isinstance(event, _REPLACES_THINGS)
            self._things_changed |= self._things_replaced or self._markers.change(event)

    def tick(self) -> None:
        """Publish the changes since the last call; called at each sample of the clock."""
        if self._things_changed and self._interest[_THINGS]:
            message = self._things(WORLD) if self._things_replaced else self._markers.things(stamp(self._simulator.now))
            self._things_changed = self._things_replaced = False
            self._publish(WORLD, THINGS, message)
        robots, now = self._simulator.roster.robots, self._simulator.now
        for name in sorted(self._streamed[FOOTPRINT]):
            self._publish(name, FOOTPRINT, views.footprint(robots[name]))
        for name in sorted(self._streamed[SCAN]):
            self._scan(robots[name])
        if self._streamed[PLAN] and not 0.0 <= now - self._planned < _PLAN_SECONDS:
            self._planned = now
            for name in sorted(self._streamed[PLAN]):
                if robots[name].legs_ahead or name in self._planning:
                    self._plan(name)

    def _plan(self, name: str) -> None:
        """Publish the plan of a robot; after it has stopped, once more."""
        robot = self._simulator.roster.robots[name]
        (self._planning.add if robot.legs_ahead else self._planning.discard)(name)
        self._publish(name, PLAN, views.plan(robot))

    def _scan(self, robot: Robot) -> None:
        if self._scanner.world is not self._simulator.world:
            self._scanner = Scanner(self._simulator.world)
        pose = robot.pose()
        header = {**robot.stamped(pose)["header"], "frame_id": f"{robot.name}/{views.SCAN_FRAME}"}
        self._publish(robot.name, SCAN, self._scanner.message(pose, header))

    def _static_markers(self, _robot: str) -> Mapping[str, Any]:
        self._replace_scene()
        return self._markers.markers(stamp(self._simulator.now))

    def _things(self, _robot: str) -> Mapping[str, Any]:
        self._replace_scene()
        return self._markers.things(stamp(self._simulator.now))

    def _replace_scene(self) -> None:
        self._markers.load(self._simulator.world)
        self._markers.follow(scene(self._simulator))
