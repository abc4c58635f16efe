"""The publications of a simulation on a ROS 2 wire, their declaration, and the messages of topics."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.protocol.goal import WORLD
from hmrsim.protocol.outputs import EventStamped, FeedbackSent, GoalChanged, Sampled, StatusChanged
from hmrsim.protocol.topics import Topic
from hmrsim_zenoh.ros2.codec.layout import CdrError
from hmrsim_zenoh.ros2.publishing import goal_topics
from hmrsim_zenoh.ros2.publishing.declarations import Declarations
from hmrsim_zenoh.ros2.publishing.endpoints import (
    AMCL_POSE,
    BATTERY_STATE,
    CLOCK,
    DETECTIONS,
    ODOM,
    PUBLISHED,
    TF,
    Endpoints,
    topic_name,
)
from hmrsim_zenoh.ros2.publishing.goal_topics import GoalTopics
from hmrsim_zenoh.ros2.publishing.health_topics import HealthTopics
from hmrsim_zenoh.ros2.publishing.markers import BASE, transform, xyz
from hmrsim_zenoh.ros2.publishing.parts import Parts
from hmrsim_zenoh.ros2.publishing.publishers import Publishers, TopicPublishers
from hmrsim_zenoh.ros2.publishing.view_topics import ViewTopics
from hmrsim_zenoh.ros2.publishing.views import FOOTPRINT_FRAME
from hmrsim_zenoh.server.interest import SubscriberWatch

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.geometry import Pose
    from hmrsim.protocol.outputs import Output
    from hmrsim.services import Service
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.ros2.keys import TypeHash
    from hmrsim_zenoh.ros2.names import Names
    from hmrsim_zenoh.ros2.wires import Wire

_PLAIN: Final = {Topic.CLOCK: CLOCK, Topic.BATTERY_STATE: BATTERY_STATE, Topic.DETECTIONS: DETECTIONS}
_ODOM, _TF, _TF_OF_ROBOT, _AMCL_POSE = f"/*/{ODOM}", f"/{TF}", f"/*/{TF}", f"/*/{AMCL_POSE}"
"""The topics that derive from odometry: those of robots, and the transforms of all robots on one topic."""

EMITTED: Final = frozenset({GoalChanged, StatusChanged, FeedbackSent, Sampled, EventStamped})
"""The outputs that are published."""

_log = logging.getLogger(__name__)


class Publications:
    """Publishes on one wire; everything except `served`, `ask` and `close` is for the simulation thread.

    Args:
        session: The session to publish on, which the caller closes.
        simulator: The simulation to read; its robots must be those of `follow`.
        changed: Called in another thread when the subscribers of topics may have changed.

    Attributes:
        log: Publishes a line of a node's log, with a level of rcl_interfaces; from any thread.
    """

    def __init__(
        self,
        session: zenoh.Session,
        wire: Wire,
        names: Names,
        *,
        actions: Mapping[str, AnyAction],
        services: Mapping[str, Service],
        simulator: Simulator,
        changed: Callable[[], None],
    ) -> None:
        self._names = names
        self._lost: frozenset[str] = frozenset()
        self._new: set[str] = set()
        self._actions = actions
        self._simulator = simulator
        self._has_tokens = wire.has_types
        self._endpoints = Endpoints(wire, actions, services)
        self._publishers = Publishers(session, wire)
        self._declarations = Declarations(session, wire, self._endpoints.of, self._publishers)
        patterns = {name: wire.key(name) for name in (*PUBLISHED, *goal_topics.FEEDBACK)}
        self._interest = SubscriberWatch(session, patterns, str(zenoh.KeyExpr.autocanonize(wire.key("/**"))), changed)
        self._goals = GoalTopics(wire, self._endpoints, self._publishers, self._interest)
        self._of_topics = TopicPublishers(self._publishers, self._endpoints)
        self._publish = self._of_topics.publish
        self._views = ViewTopics(simulator, self._of_topics, self._interest, changed)
        self._health = HealthTopics(simulator, self._of_topics, self._interest)
        self.log = self._health.log
        # The poses in the last messages on the robots' latched topics.
        self._poses: dict[str, Pose] = {}
        self._poses_wanted = False
        self._parts = Parts(names)
        self._emitters: dict[type, Callable[[Any], None]] = {
            GoalChanged: self._emit_change,
            StatusChanged: self._goals.emit_status,
            FeedbackSent: lambda event: self._goals.emit_feedback(event, self._names),
            Sampled: self._emit_sample,
            EventStamped: self._emit_event,
        }

    def start(self) -> None:
        """Publish the initial state of new robots, and declare nodes and endpoints in the background."""
        self._of_topics.forget(self._names.serves.keys() - self._lost)
        self._new.clear()
        for robot in self._names.serves:
            if robot not in self._lost and not self._goals.knows(robot):
                self._new.add(robot)
                self._goals.begin(robot, self._names)
                if robot != WORLD:
                    self._publish_pose(robot)
        parts = self._parts
        self._declarations.want(parts.all, parts.standing(self._endpoints.tokens) if self._has_tokens else None)

    def follow(self, names: Names, lost: Collection[str] = ()) -> bool:
        """Publish for these robots from now on, except for the *lost* ones.

        Returns:
            Whether anything has changed.
        """
        gone = frozenset(lost)
        self._views.follow()
        if names == self._names and gone == self._lost:
            return False
        before, self._names, self._lost = self._names, names, gone
        for robot, actions in before.serves.items():
            if robot in gone or names.serves.get(robot) != actions or names.aliases != before.aliases:
                self._goals.end(robot)
                self._poses.pop(robot, None)
        self._parts = Parts(names, gone)
        self.start()
        return True

    def close(self) -> None:
        """Stop declaring, before the session is closed; waits up to 1 s for the declaration in progress."""
        self._declarations.close()

    def join(self) -> None:
        """Wait for the thread to end, after the session was closed."""
        self._interest.join()

    def served(self, name: str) -> Collection[TypeHash]:
        """Return types and hashes of the endpoints with a name; from any thread."""
        part = self._parts.of(name)
        return self._endpoints.types_of(part).get(name, ()) if part else ()

    def is_new(self, name: str) -> bool:
        """Return whether a name belongs to a robot that the last change has added."""
        part = self._parts.of(name)
        return part is not None and part.robot in self._new

    def ask(self, name: str) -> None:
        """Declare the endpoints with a name, which a client or subscriber looks for; from any thread."""
        part = self._parts.of(name)
        if part is not None:
            self._declarations.ask(part)
            self._views.ask(part, name)

    def look(self) -> int:
        """Check for new subscribers; return how often anything has changed."""
        return self._interest.look()

    def look_for_feedback(self, action: str, *, of_world: bool) -> int:
        """Check for new subscribers to the feedback of an action; return how often anything has changed."""
        return self._interest.look(self._goals.kinds(action, of_world=of_world))

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic has to be sampled for a subscriber; statuses always are needed."""
        if topic is Topic.ODOM:
            self._publish_poses()
            self._views.look()
        return self._wants_sample(topic) or any(each.wants(topic) for each in (self._goals, self._views, self._health))

    def _wants_sample(self, topic: Topic) -> bool:
        if topic is Topic.ODOM:
            return any(self._interest[name] for name in (_ODOM, _TF, _TF_OF_ROBOT, _AMCL_POSE))
        return topic in _PLAIN and self._interest[topic_name(WORLD if topic is Topic.CLOCK else "*", _PLAIN[topic])]

    def emit(self, output: Output) -> None:
        """Publish an output of one of the types in `EMITTED`."""
        try:
            self._emitters[type(output)](output)
        except CdrError as error:
            _log.warning("not published in ROS: %s", error)

    def _emit_sample(self, sample: Sampled) -> None:
        if isinstance(sample.message, Odometry):
            self._emit_odom(sample.robot, sample.message)
        elif self._wants_sample(sample.topic):
            self._publish(sample.robot or WORLD, _PLAIN[sample.topic], sample.message)
        if sample.topic is Topic.CLOCK:
            self._views.tick()
            self._health.tick()

    def _emit_odom(self, robot: str, odom: Odometry) -> None:
        at = odom.pose.pose.position, odom.pose.pose.orientation
        if self._interest[_ODOM]:
            self._publish(robot, ODOM, odom)
        if self._interest[_TF]:
            self._publish(WORLD, TF, {"transforms": [transform(odom.header, odom.child_frame_id, *at)]})
        if self._interest[_TF_OF_ROBOT]:
            # Nav2's frames, which lack the robot's name.
            header = {"stamp": odom.header.stamp, "frame_id": FOOTPRINT_FRAME}
            frames = [transform(odom.header, FOOTPRINT_FRAME, *at), transform(header, BASE, xyz())]
            self._publish(robot, TF, {"transforms": frames})
        if self._interest[_AMCL_POSE]:
            self._publish(robot, AMCL_POSE, {"header": odom.header, "pose": odom.pose})

    def _emit_event(self, output: EventStamped) -> None:
        self._views.event(output)
        self._health.event(output)

    def _emit_change(self, event: GoalChanged) -> None:
        self._health.change(event)
        if event.status.terminal:
            self._goals.forget(event.goal_id)
            if event.robot in self._poses and self._actions[event.action].holds_base and self._has_moved(event.robot):
                self._publish_pose(event.robot)

    def _publish_poses(self) -> None:
        """Publish all robots' poses for the first subscriber: a robot may have moved without one."""
        before, self._poses_wanted = self._poses_wanted, self._interest[_AMCL_POSE]
        if self._poses_wanted and not before:
            for robot in self._poses:
                self._publish_pose(robot)

    def _publish_pose(self, name: str) -> None:
        robot = self._simulator.roster.robots[name]
        self._poses[name] = robot.estimated(robot.pose())
        odom: Any = self._simulator.readings.odom(robot).message
        self._publish(name, AMCL_POSE, {"header": odom.header, "pose": odom.pose})

    def _has_moved(self, name: str) -> bool:
        """Return whether a robot is elsewhere than in the last message on its latched topic."""
        robot = self._simulator.roster.robots[name]
        return self._interest[_AMCL_POSE] or robot.estimated(robot.pose()) != self._poses[name]
