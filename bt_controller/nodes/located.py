"""Nodes that read the robot's pose, in the map frame, from its odometry."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from bt_controller.core.node import EACH_PERIOD, Node
from bt_controller.core.ports import STRING, input_port
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
        """Watch the robot's odometry.

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
        """The robot's pose."""
        odometry = self.odometry
        return PoseStamped(header=odometry.header, pose=odometry.pose.pose)
