"""A crowd that never rests: robots on lanes, each of which gets a new random goal when it has arrived."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from hmrsim.events.robots import MotionBegan
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.protocol.commands import GetResult, SendGoal
from hmrsim.protocol.goal import GoalStatus, ResultResponse
from hmrsim.protocol.outputs import Answered, EventStamped
from hmrsim.protocol.topics import Topic
from hmrsim.world.model import World
from hmrsim.world_checks import LoadedWorld

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.simulator import Simulator

SIDE = 32
"""Waypoints along each side of the grid."""

LANE_SECONDS = 5.0
"""What a lane takes on average: lanes are about 5 m long, robots drive 1 m/s."""

_JITTER = 1.0


def grid_world(robots: int, *, side: int = SIDE, seed: int = 1) -> World:
    """Return a world of that many robots, ``robot_0`` and so on, at random waypoints of a grid."""
    chance = random.Random(seed)
    waypoints = {
        f"w{row:02}{column:02}": tuple(LANE_SECONDS * at + chance.uniform(-_JITTER, _JITTER) for at in (column, row))
        for row, column in itertools.product(range(side), repeat=2)
    }
    across = [[f"w{row:02}{column:02}" for column in range(side)] for row in range(side)]
    lines = [*across, *zip(*across, strict=True)]
    starts = list(waypoints)
    return World.model_validate(
        {
            "name": f"{robots} robots on a grid",
            "waypoints": waypoints,
            "lanes": [pair for line in lines for pair in itertools.pairwise(line)],
            "robots": {f"robot_{number}": {"at": chance.choice(starts)} for number in range(robots)},
        }
    )


def under(world: World, policy: str) -> World:
    """Return the same world under another policy, with what it says of capacities."""
    plain = world.model_dump(mode="json", by_alias=True)
    said = {key: value for key, value in plain["traffic"].items() if policy != "free" and key != "policy"}
    return World.model_validate(plain | {"traffic": {"patience": None, **said, "policy": policy}})


def loaded(world: World) -> LoadedWorld:
    """Return a world that no file has, as `Host` takes it."""
    return LoadedWorld(world=world, path=Path("benchmark.yaml"), warnings=())


def plan_everything(simulator: Simulator) -> None:
    """Plan a trip to every waypoint, so that no search is left to be made during a measurement."""
    points = list(simulator.world.points.values())
    for start, goal in itertools.pairwise([*points, points[0]]):
        simulator.graph.plan(start, goal, 1.0)


class Wanderers:
    """A sink that sends each robot to a random waypoint, waits for the result, and sends it on.

    It takes the way of every client: a command for the goal, one for its result, and the answer to the latter.
    Robots first wait for a random part of a second, so that they don't keep step, and when a goal has failed, which
    may be at once.

    Args:
        world: The world.
        seed: Of chance.
        points: Where they go to; all points of the world that have a name if not given.
    """

    def __init__(self, world: World, seed: int = 1, points: Iterable[tuple[float, float]] | None = None) -> None:
        self._simulator: Simulator | None = None
        self._chance = random.Random(seed)
        self._numbers = itertools.count(1)
        self._goals = [
            NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=Point(x=x, y=y))))
            for x, y in (world.points.values() if points is None else points)
        ]

    def start(self, simulator: Simulator, robots: Iterable[str]) -> None:
        """Send these robots of a simulator off, whose sink this is; before its thread starts, if it has one."""
        self._simulator = simulator
        for robot in robots:
            self._rest(robot)

    def emit(self, output: Output) -> None:
        """Send on the robot whose result has come."""
        if isinstance(output, Answered) and isinstance(output.reply_to, _Wanderer):
            answer = output.answer
            if isinstance(answer, ResultResponse) and answer.status is GoalStatus.ABORTED:
                self._rest(output.reply_to)
            else:
                self._send(output.reply_to, "navigate_to_pose", self._chance.choice(self._goals))

    def wants(self, _topic: Topic) -> bool:
        """Return False: results come unasked."""
        return False

    def _rest(self, robot: str) -> None:
        self._send(robot, "wait", Wait.Goal(time=Duration.from_seconds(self._chance.random())))

    def _send(self, robot: str, action: str, goal: Message) -> None:
        if self._simulator is None:
            raise AssertionError
        goal_id = f"{next(self._numbers):032x}"
        self._simulator.submit(SendGoal(robot, action, goal, goal_id))
        self._simulator.submit(GetResult(robot, action, goal_id, _Wanderer(robot)))


class Lanes:
    """A sink that counts lanes as they are driven."""

    def __init__(self) -> None:
        self.driven = 0

    def emit(self, output: Output) -> None:
        """Count the lanes that a robot begins, or is going to."""
        if isinstance(output, EventStamped) and isinstance(output.event, MotionBegan):
            lanes = [output.event.lane, *(each["lane"] for each in output.event.then)]
            self.driven += sum(lane is not None for lane in lanes)

    def wants(self, topic: Topic) -> bool:
        """Return whether it takes a topic."""
        return topic is Topic.MOTION


class _Wanderer(str):
    """The name of a robot that wanders, as the address of its results."""

    __slots__ = ()
