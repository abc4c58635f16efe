"""A failed goal is sent again when a lane opens, even if no lane was closed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from driving import ATTEMPTS, PAUSE, Driver, listen

if TYPE_CHECKING:
    from hmrsim_zenoh import Client


def rounds(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")
    opened: list[dict[str, Any]] = []
    listen(client, lambda event: opened.append(event) if event["kind"] == "lane_opened" else None)

    def visit(place: str) -> bool:
        for _ in range(ATTEMPTS):
            opened.clear()
            if wall_e.go(place):
                return True
            end = client.now + PAUSE
            while not opened and (bug or client.now < end):  # the bug: no other reason, and no limit
                client.sleep(5.0)
        return False

    return all(visit(place) for place in ("ward_a", "ward_b"))
