"""A client that derives from events whether the robot carries the parcel, and forgets one kind of event."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from driving import Driver, item_of, listen

if TYPE_CHECKING:
    from hmrsim_zenoh import Client

CHANGES = {"picked": 1, "placed": -1}
"""By how much an event changes the number of carried items; the bug: an item can be dropped."""


def errand(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")
    if not bug:
        return wall_e.bring("parcel", "ward")
    carried = [int(item_of(client, "parcel")["carrier"] == wall_e.robot)]

    def note(event: dict[str, Any]) -> None:
        carried[0] += CHANGES.get(event["kind"], 0)

    listen(client, note)

    def bring() -> bool:
        x, y = item_of(client, "parcel")["at"]
        have = carried[0] > 0 or (wall_e.go((x, y)) and wall_e.pickup("parcel"))
        return have and wall_e.go("ward") and wall_e.place("parcel")

    return wall_e.insist(bring)
