"""The messages of topics in ROS: odometry and what derives from it, batteries, detections and the clock."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.geometry_msgs import (
    PoseWithCovarianceStamped,
    Quaternion,
    Transform,
    TransformStamped,
    Vector3,
)
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.std_msgs import Header
from hmrsim.interfaces.tf2_msgs import TFMessage
from hmrsim.protocol.goal import WORLD
from hmrsim.protocol.topics import Topic
from hmrsim_zenoh.ros2.publishing.endpoints import AMCL_POSE, BATTERY_STATE, CLOCK, DETECTIONS, ODOM, TF

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.outputs import Sampled
    from hmrsim_zenoh.ros2.publishing.endpoints import Endpoints
    from hmrsim_zenoh.ros2.publishing.publishers import Publisher, Publishers
    from hmrsim_zenoh.ros2.wires import Wire
    from hmrsim_zenoh.server.interest import SubscriberWatch

ROBOT_TF: Final = "robot's tf"
"""A robot's own transforms, ``/<robot>/tf`` as in Nav2 with several robots; `TF` has those of all robots."""

_PLAIN: Final = {Topic.CLOCK: CLOCK, Topic.BATTERY_STATE: BATTERY_STATE, Topic.DETECTIONS: DETECTIONS}
OF_ODOM: Final = (ODOM, TF, ROBOT_TF, AMCL_POSE)
"""The topics that derive from odometry."""

_BASE, _FOOTPRINT = "base_link", "base_footprint"
_NONE: Final = Transform(translation=Vector3(), rotation=Quaternion())


def patterns(wire: Wire) -> dict[str, str]:
    """Return the keys on which each kind of topic is published."""
    of_robots = {topic: wire.key(f"/*/{topic}") for topic in (ODOM, BATTERY_STATE, DETECTIONS, AMCL_POSE)}
    return of_robots | {ROBOT_TF: wire.key(f"/*/{TF}"), TF: wire.key(f"/{TF}"), CLOCK: wire.key(f"/{CLOCK}")}


def amcl_pose(odom: Odometry) -> PoseWithCovarianceStamped:
    """Return a robot's estimated pose."""
    return PoseWithCovarianceStamped.model_construct(header=odom.header, pose=odom.pose)


def tf_of_all(odom: Odometry) -> TFMessage:
    """Return a robot's transform for the topic of all robots, with the robot's name in the frame."""
    return TFMessage.model_construct(transforms=[_base(odom, odom.child_frame_id)])


def tf_of_robot(odom: Odometry) -> TFMessage:
    """Return a robot's transforms for its own topic, with Nav2's frames, which lack the robot's name."""
    held = Header.model_construct(stamp=odom.header.stamp, frame_id=_FOOTPRINT)
    base = TransformStamped.model_construct(header=held, child_frame_id=_BASE, transform=_NONE)
    return TFMessage.model_construct(transforms=[_base(odom, _FOOTPRINT), base])


def _base(odom: Odometry, child: str) -> TransformStamped:
    pose = odom.pose.pose
    at = Vector3.model_construct(x=pose.position.x, y=pose.position.y, z=pose.position.z)
    transform = Transform.model_construct(translation=at, rotation=pose.orientation)
    return TransformStamped.model_construct(header=odom.header, child_frame_id=child, transform=transform)


class Topics:
    """Publishes samples to topics that have subscribers."""

    def __init__(self, endpoints: Endpoints, publishers: Publishers, interest: SubscriberWatch[str]) -> None:
        self._endpoints = endpoints
        self._publishers = publishers
        self._interest = interest
        self._known: dict[tuple[str, str], Publisher] = {}

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic's messages have a subscriber."""
        if topic is Topic.ODOM:
            return any(self._interest[kind] for kind in OF_ODOM)
        return topic in _PLAIN and self._interest[_PLAIN[topic]]

    def forget(self) -> None:
        """Drop the cached publishers after robots came or went."""
        self._known.clear()

    def emit(self, sample: Sampled) -> None:
        """Publish a sample."""
        if isinstance(sample.message, Odometry):
            self._emit_odom(sample.robot, sample.message)
        elif sample.topic in _PLAIN and self._interest[_PLAIN[sample.topic]]:
            self._publish(sample.robot or WORLD, _PLAIN[sample.topic], sample.message)

    def _emit_odom(self, robot: str, odom: Odometry) -> None:
        if self._interest[ODOM]:
            self._publish(robot, ODOM, odom)
        if self._interest[TF]:
            self._publish(WORLD, TF, tf_of_all(odom))
        if self._interest[ROBOT_TF]:
            self._publish(robot, TF, tf_of_robot(odom))
        if self._interest[AMCL_POSE]:
            self._publish(robot, AMCL_POSE, amcl_pose(odom))

    def publish_pose(self, sample: Sampled) -> None:
        """Publish a robot's pose from its odometry, with or without subscribers."""
        if isinstance(sample.message, Odometry):
            self._publish(sample.robot, AMCL_POSE, amcl_pose(sample.message))

    def _publish(self, robot: str, topic: str, message: Message) -> None:
        """Publish a message; a latched one is also kept before its publisher is declared."""
        publisher = self._known.get((robot, topic))
        if publisher is None:
            publisher = self._known[robot, topic] = self._publishers.of(self._endpoints.topic(robot, topic))
        if publisher or topic == AMCL_POSE:
            publisher.publish(self._endpoints.message_type(topic).encode(message))
