"""Inputs that families share: the robot's pose, the goals of a tree, and writes to an entry."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.blackboard import Blackboard

from bt_controller.core.node import EACH_PERIOD, Node
from bt_controller.core.ports import POSE, POSES, STRING, input_port
from hmrsim.interfaces.geometry_msgs import PoseStamped

if TYPE_CHECKING:
    from bt_controller.core.ports import Port
    from bt_controller.core.topics import Topics
    from hmrsim.interfaces.nav_msgs import Odometry

GLOBAL_FRAME: Final[Port] = input_port(STRING, "Ignored: all poses are in the map frame", required=False)
BASE_FRAME: Final[Port] = input_port(STRING, "Ignored: a robot's pose is that of its base", required=False)


class Located(Node):
    """A node that reads its robot's pose."""

    def setup(self, **kwargs: Any) -> None:
        """Watch the topic of the robot's odometry.

        Raises:
            NotServed: The robot has gone.
            PortError: A port's value in the file is invalid.
        """
        super().setup(**kwargs)
        self._topics: Topics = kwargs["topics"]
        self._robots_name: str = kwargs["robot"]
        self._topics.watch(self._robots_name, "odom")

    def next_tick_time(self) -> float:
        """Return that the pose has to be polled."""
        return EACH_PERIOD

    @property
    def odometry(self) -> Odometry:
        """The robot's odometry: its pose and velocity."""
        latest: Odometry = self._topics.latest(self._robots_name, "odom")
        return latest

    @property
    def here(self) -> PoseStamped:
        """The robot's pose in the map frame."""
        odometry = self.odometry
        return PoseStamped(header=odometry.header, pose=odometry.pose.pose)


GOAL_PORTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        "goal": input_port(POSE, "Destination", default="{goal}", required=False),
        "goals": input_port(POSES, "Destinations in order", default="{goals}", required=False),
    }
)


def goals_of(node: Node) -> tuple[Any, Any]:
    """Return the values of a node's ports ``goal`` and ``goals``; None for a missing one."""
    return node.read("goal"), node.read("goals")


class Watching(Node):
    """A node that detects writes to the entry of its port ``entry`` since its last check."""

    KEYS: ClassVar = ("entry",)

    _seen = 0

    def updated(self) -> bool:
        """Return whether the entry was written, even with the same value; at first, since the start of the tree."""
        key = self._get_blackboard_key("entry")
        if key not in Blackboard.storage:
            return False
        before, self._seen = self._seen, Blackboard.storage.writes[key]  # type: ignore[attr-defined]  # `Entries`
        return before != self._seen
