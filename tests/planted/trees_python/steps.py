"""Leaves that look at the world, and repetitions that leave time for a repair, shared by the trees."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Failure
from py_trees.common import Status
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Retry
from py_trees.timers import Timer

from bt_controller.behaviours.robot_actions import GoTo, NavToPoseActionClient, Pickup, Place, pose_goal

if TYPE_CHECKING:
    from hmrsim.interfaces.nav2_msgs import NavigateToPose

ATTEMPTS = 10
PAUSE = 20.0
"""Simulated seconds between two attempts; a repair takes half a minute."""


def patient(step: Behaviour, attempts: int = ATTEMPTS, pause: float = PAUSE) -> Behaviour:
    """Return a step that is tried up to some times, with pauses."""
    name = step.name
    rest = Sequence(f"{name}: rest", memory=True, children=[Timer(f"{name}: pause", pause), Failure(f"{name}: again")])
    return Retry(f"{name}: patiently", Selector(f"{name}: once", memory=True, children=[step, rest]), attempts)


class Look(Behaviour):
    """A leaf that reads the scene of the world."""

    def __init__(self, name: str, robot: str | None) -> None:
        super().__init__(name)
        self._robot = robot

    def setup(self, **kwargs: Any) -> None:
        self._client = kwargs["client"]
        self._robot = self._robot or kwargs["robot"]
        self._places = kwargs["places"]

    def item(self, name: str) -> dict[str, Any]:
        return item_of(self._client, name)


def item_of(client: Any, name: str) -> dict[str, Any]:
    scene = json.loads(client.get(client.keys.world("scene")))
    return next(item for item in scene["items"] if item["name"] == name)


class Holds(Look):
    """Succeeds if the robot carries an item."""

    def __init__(self, item: str, robot: str | None = None) -> None:
        super().__init__(f"Holds {item}", robot)
        self._item = item

    def update(self) -> Status:
        return Status.SUCCESS if self.item(self._item)["carrier"] == self._robot else Status.FAILURE


class LiesAt(Look):
    """Succeeds if an item lies at a place."""

    def __init__(self, item: str, place: str, robot: str | None = None) -> None:
        super().__init__(f"{item} lies at {place}", robot)
        self._item, self._place = item, place

    def update(self) -> Status:
        item, point = self.item(self._item), self._places.pose(self._place).pose.position
        near = math.dist(item["at"], (point.x, point.y)) <= 1.0
        return Status.SUCCESS if near and item["carrier"] is None else Status.FAILURE


class GoToItem(NavToPoseActionClient):
    """Drives to where an item is."""

    def __init__(self, item: str, robot: str | None = None) -> None:
        self._item = item
        super().__init__(f"Go to {item}", self._goal_now, robot=robot)

    def setup(self, **kwargs: Any) -> None:
        super().setup(**kwargs)
        self._asks = kwargs["client"]

    def _goal_now(self) -> NavigateToPose.Goal:
        return pose_goal(*item_of(self._asks, self._item)["at"])


def bring(item: str, place: str, robot: str | None = None) -> Behaviour:
    """Return the errand that brings an item from its current place to another."""
    fetch = Sequence(f"Fetch {item}", memory=True, children=[GoToItem(item, robot), Pickup(item, robot=robot)])
    have = Selector(f"Have {item}", memory=True, children=[Holds(item, robot), fetch])
    steps = [have, GoTo(place, robot=robot), Place(item, robot=robot)]
    return Selector(
        f"Deliver {item}",
        memory=True,
        children=[LiesAt(item, place, robot), Sequence(f"Bring {item}", memory=True, children=steps)],
    )
