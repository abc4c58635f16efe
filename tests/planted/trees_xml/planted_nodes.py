"""Nodes of the planted missions: conditions on items, and an item's position."""

from __future__ import annotations

import json
import math
from typing import Any, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Leaf
from bt_controller.core.ports import POSE, STRING, Kind, input_port, output_port
from hmrsim_zenoh.client.places import pose_at

_ITEM = input_port(STRING, "The item")
_PARTS: Kind[Any] = Kind("any", object, lambda text, _places: text.split(";"))


class _Look(Leaf):
    """A node that reads the scene of the world."""

    def setup(self, **kwargs: Any) -> None:
        super().setup(**kwargs)
        self._client, self._robots_name = kwargs["client"], kwargs["robot"]

    def item(self) -> dict[str, Any]:
        scene = json.loads(self._client.get(self._client.keys.world("scene")))
        return next(item for item in scene["items"] if item["name"] == self.read("item"))


class IsHeld(_Look):
    """Succeeds if the robot carries the item."""

    INPUTS: ClassVar = {"item": _ITEM}

    def update(self) -> Status:
        return Status.SUCCESS if self.item()["carrier"] == self._robots_name else Status.FAILURE


class LiesAt(_Look):
    """Succeeds if the item lies at a pose."""

    INPUTS: ClassVar = {"item": _ITEM, "pose": input_port(POSE, "Where it should be")}

    def update(self) -> Status:
        item, point = self.item(), self.read("pose").pose.position
        near = math.dist(item["at"], (point.x, point.y)) <= 1.0
        return Status.SUCCESS if near and item["carrier"] is None else Status.FAILURE


class FindItem(_Look):
    """Writes the position of an item."""

    INPUTS: ClassVar = {"item": _ITEM}
    OUTPUTS: ClassVar = {"pose": output_port(POSE, "Where it is")}

    def update(self) -> Status:
        self.write("pose", pose_at(*self.item()["at"]))
        return Status.SUCCESS


class Split(Leaf):
    """Writes the parts of a text separated by semicolons as a list."""

    INPUTS: ClassVar = {"text": input_port(STRING, "The text")}
    OUTPUTS: ClassVar = {"parts": output_port(_PARTS, "Its parts")}

    def update(self) -> Status:
        self.write("parts", self.read("text").split(";"))
        return Status.SUCCESS
