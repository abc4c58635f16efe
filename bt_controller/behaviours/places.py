"""A behavior that writes the poses of the world's places to the blackboard."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from py_trees.behaviour import Behaviour
from py_trees.common import Access, Status

from bt_controller.core.robots import NotServed

if TYPE_CHECKING:
    from hmrsim.interfaces.geometry_msgs import PoseStamped


class ToBlackboard(Behaviour):
    """Writes the poses of places to the blackboard, as PoseStamped.

    Args:
        places: The names of waypoints, places or docks, by blackboard key.
    """

    def __init__(self, name: str, places: Mapping[str, str]) -> None:
        super().__init__(name)
        self._places = dict(places)
        self._poses: dict[str, PoseStamped] = {}
        self.blackboard = self.attach_blackboard_client()
        for key in self._places:
            self.blackboard.register_key(key, Access.WRITE)

    def setup(self, **kwargs: Any) -> None:
        """Look up the poses of the places.

        Raises:
            NotServed: The world has no place of a given name.
            SimulatorNotFound: No simulator answers.
        """
        try:
            self._poses = {key: kwargs["places"].pose(place) for key, place in self._places.items()}
        except ValueError as error:
            raise NotServed(f"{self.name!r}: {error}") from None

    def update(self) -> Status:
        """Write the poses."""
        for key, pose in self._poses.items():
            self.blackboard.set(key, pose)
        self.feedback_message = f"wrote {', '.join(self._poses)}"
        return Status.SUCCESS
