"""Leaves that open a door or wait for it."""

from __future__ import annotations

import json
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_controller.behaviours.service_clients import FromConstant
from hmrsim.interfaces.hmrsim_msgs import SetDoorState


def ask_to_open(door: str) -> Behaviour:
    """Return the leaf that opens a door and fails if the door does not obey."""
    request = SetDoorState.Request(name=door, state="open")
    return FromConstant(f"Ask {door} to open", SetDoorState, "set_door_state", request)


class WaitUntilOpen(Behaviour):
    """Waits until a door is open, however long that takes."""

    def __init__(self, door: str) -> None:
        super().__init__(f"Wait until {door} is open")
        self._door = door

    def setup(self, **kwargs: Any) -> None:
        self._client = kwargs["client"]

    def update(self) -> Status:
        scene = json.loads(self._client.get(self._client.keys.world("scene")))
        tags = next(each["tags"] for each in scene["fixtures"] if each["name"] == self._door)
        return Status.SUCCESS if "open" in tags else Status.RUNNING


class WaitForOpening(Behaviour):
    """Waits for the event that a door has opened, from its first tick on."""

    def __init__(self, door: str) -> None:
        super().__init__(f"Wait for the opening of {door}")
        self._door = door
        self._opened = 0

    def setup(self, **kwargs: Any) -> None:
        client = kwargs["client"]
        client.subscribe(client.keys.world("log"), self._note)

    def initialise(self) -> None:
        self._before = self._opened

    def update(self) -> Status:
        return Status.SUCCESS if self._opened > self._before else Status.RUNNING

    def _note(self, _key: str, payload: bytes) -> None:
        event = json.loads(payload)
        self._opened += event["kind"] == "door_opened" and event["door"] == self._door
