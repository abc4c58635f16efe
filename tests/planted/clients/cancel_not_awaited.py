"""After a time limit a goal is canceled and sent again at once, although it may have succeeded meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from driving import Driver, Handle, item_of, succeeds

from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh import Client, GoalRejectedError, GoalTimeout, RequestError

if TYPE_CHECKING:
    from typing import Any

LIMIT = 20.0
"""Simulated seconds that a goal may take."""


def errand(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")
    canceled: list[Callable[[], Handle]] = []

    def limited(start: Callable[[], Handle]) -> bool:
        handle = start()
        try:
            handle.result(sim_timeout=LIMIT)
        except GoalTimeout:
            handle.cancel()
            if not bug:
                return succeeds(handle)
            canceled.append(start)  # the bug: how it ends is not waited for
            return False
        except (GoalRejectedError, RequestError):
            return False
        return handle.status is GoalStatus.SUCCEEDED

    def fetch(found: dict[str, Any]) -> bool:
        x, y = found["at"]
        return limited(lambda: wall_e.start_to((x, y))) and limited(lambda: wall_e.start_pickup("parcel"))

    def deliver() -> bool:
        if canceled:
            if not limited(canceled[0]):
                return False
            canceled.clear()
        found = item_of(client, "parcel")
        if wall_e.near(found, "ward"):
            return True
        have = found["carrier"] == wall_e.robot or fetch(found)
        return have and limited(lambda: wall_e.start_to("ward")) and limited(lambda: wall_e.start_place("parcel"))

    return wall_e.insist(deliver) and wall_e.insist(lambda: wall_e.go("home"))
