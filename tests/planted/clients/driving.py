"""Goals of one robot, queries about the world, and repetitions of steps, shared by all planted functions."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import DockRobot, NavigateToPose, Wait
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh import Client, GoalRejectedError, RequestError
from hmrsim_zenoh.client.goal_handle import GoalHandle
from hmrsim_zenoh.errors import Unreachable

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message

ATTEMPTS = 10
PAUSE = 20.0
"""Simulated seconds between two attempts; a repair takes half a minute."""

Handle = GoalHandle[Any, Any]


class Driver:
    """One robot, and the goals that it is sent.

    Attributes:
        robot: Its name.
    """

    def __init__(self, client: Client, robot: str) -> None:
        self.robot = robot
        self._client = client
        self._places = places(client)

    def start(self, action: str, goal: Message, **options: Any) -> Handle:
        """Send a goal without waiting."""
        handle: Handle = self._client.action_client(self.robot, registry()[action]).send_goal(goal, **options)
        return handle

    def start_to(self, target: str | tuple[float, float], **options: Any) -> Handle:
        x, y = self._places[target] if isinstance(target, str) else target
        pose = PoseStamped(pose=Pose(position=Point(x=x, y=y)))
        return self.start("navigate_to_pose", NavigateToPose.Goal(pose=pose), **options)

    def start_pickup(self, item: str) -> Handle:
        return self.start("pickup", Pickup.Goal(target_name=item))

    def start_place(self, item: str) -> Handle:
        return self.start("place", Place.Goal(attached_object_name=item))

    def go(self, target: str | tuple[float, float]) -> bool:
        return succeeds(self.start_to(target))

    def pickup(self, item: str) -> bool:
        return succeeds(self.start_pickup(item))

    def place(self, item: str) -> bool:
        return succeeds(self.start_place(item))

    def wait(self, seconds: float) -> bool:
        return succeeds(self.start("wait", Wait.Goal(time=Duration.from_seconds(seconds))))

    def dock(self, dock: str) -> bool:
        return succeeds(self.start("dock_robot", DockRobot.Goal(dock_id=dock)))

    def insist(self, step: Callable[[], bool]) -> bool:
        """Try a step up to some times, with pauses; return whether it has succeeded."""
        for attempt in range(ATTEMPTS):
            if attempt:
                self._client.sleep(PAUSE)
            if step():
                return True
        return False

    def near(self, item: dict[str, Any], place: str) -> bool:
        """Return whether an item lies at a place."""
        return item["carrier"] is None and math.dist(item["at"], self._places[place]) <= 1.0

    def bring(self, item: str, place: str) -> bool:
        """Bring an item from its current place to another; return whether it is there."""
        return self.insist(lambda: self._bring_once(item, place))

    def _bring_once(self, item: str, place: str) -> bool:
        found = item_of(self._client, item)
        if self.near(found, place):
            return True
        x, y = found["at"]
        have = found["carrier"] == self.robot or (self.go((x, y)) and self.pickup(item))
        return have and self.go(place) and self.place(item)


def succeeds(handle: Handle) -> bool:
    """Wait for a goal; return whether it has succeeded."""
    try:
        handle.result()
    except (GoalRejectedError, RequestError):
        return False
    return handle.status is GoalStatus.SUCCEEDED


def asked(client: Client, key: str, payload: bytes | None = None) -> dict[str, Any]:
    """Return an answer of the world; a query whose answer is lost is repeated."""
    for _ in range(ATTEMPTS - 1):
        with suppress(Unreachable):
            found: dict[str, Any] = json.loads(client.get(client.keys.world(key), payload=payload))
            return found
    last: dict[str, Any] = json.loads(client.get(client.keys.world(key), payload=payload))
    return last


def scene(client: Client) -> dict[str, Any]:
    return asked(client, "scene")


def item_of(client: Client, name: str) -> dict[str, Any]:
    found: dict[str, Any] = next(item for item in scene(client)["items"] if item["name"] == name)
    return found


def places(client: Client) -> dict[str, tuple[float, float]]:
    """Return the poses of the world's places."""
    answer = asked(client, "get_named_poses", b"{}")
    points = {pose["name"]: pose["pose"]["position"] for pose in answer["poses"]}
    return {name: (point.get("x", 0.0), point.get("y", 0.0)) for name, point in points.items()}


def listen(client: Client, note: Callable[[dict[str, Any]], None]) -> None:
    """Call back with each event of the world."""
    client.subscribe(client.keys.world("log"), lambda _key, payload: note(json.loads(payload)))
