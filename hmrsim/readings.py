"""The latest of what is published, made when somebody asks for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.errors import GoalRejected
from hmrsim.gateway import Refused, Sampled, Topic
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.geometry_msgs import PoseWithCovariance, Twist, TwistWithCovariance, Vector3
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim.sim_time import nanoseconds

if TYPE_CHECKING:
    import simpy

    from hmrsim.dispatcher import Dispatcher
    from hmrsim.gateway import Published, Read
    from hmrsim.robot import Robot
    from hmrsim.roster import Roster


class Readings:
    """Reads the world.

    Args:
        env: Its clock.
        roster: Its robots.
        dispatcher: Their goals.
    """

    def __init__(self, env: simpy.Environment, roster: Roster, dispatcher: Dispatcher) -> None:
        self._env = env
        self._roster = roster
        self._dispatcher = dispatcher

    def read(self, command: Read) -> Published | Refused:
        """Return what would be published now."""
        try:
            match command.topic:
                case Topic.STATUS:
                    return self._dispatcher.status(command.robot, command.action)
                case Topic.ODOM:
                    return self.odom(self._roster.robots[command.robot])
                case _:
                    return self.clock()
        except (GoalRejected, KeyError):
            return Refused("robot", command.robot, f"no such robot or action: {command.robot}/{command.action}")

    def clock(self) -> Sampled:
        """Return the time."""
        return Sampled(Topic.CLOCK, "", Clock(clock=Time.from_nanoseconds(nanoseconds(self._env.now))))

    def odom(self, robot: Robot) -> Sampled:
        """Return where a robot is, and its velocity as the robot itself sees it."""
        where = robot.pose_stamped()
        ahead, turning = robot.velocity()
        message = Odometry(
            header=where.header,
            child_frame_id=f"{robot.name}/base_link",
            pose=PoseWithCovariance(pose=where.pose),
            twist=TwistWithCovariance(twist=Twist(linear=Vector3(x=ahead), angular=Vector3(z=turning))),
        )
        return Sampled(Topic.ODOM, robot.name, message)
