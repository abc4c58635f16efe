"""Topics, places and a robot for leaves that are tested without a simulator."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from bt_controller.core.robots import Directory
from hmrsim_zenoh.client.places import pose_at
from tests.unit.bt_controller.conftest import FakeTopics

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.interfaces.geometry_msgs import PoseStamped


class FakePlaces:
    """A world with one place."""

    def pose(self, name: str) -> PoseStamped:
        if name != "kitchen":
            raise ValueError(f"no place {name!r}; there are kitchen")
        return pose_at(3.0, 4.0)


@pytest.fixture
def topics() -> FakeTopics:
    """Return topics without a message."""
    return FakeTopics()


@pytest.fixture
def equip(client: Any, topics: FakeTopics) -> Callable[[Any], Any]:
    """Return the function that sets a tree up for wall_e."""
    actions = ["navigate_to_pose", "pickup", "place", "wait", "dock_robot", "undock_robot"]
    directory = Directory.from_info({"robots": [{"name": "wall_e", "actions": actions}]})

    def run(root: Any) -> Any:
        for node in root.iterate():
            node.setup(client=client, robot="wall_e", topics=topics, places=FakePlaces(), directory=directory)
        return root

    return run
