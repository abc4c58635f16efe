"""The robot leaves its charger on the event of a full battery, which may have come already."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from driving import Driver, listen, scene

if TYPE_CHECKING:
    from hmrsim_zenoh import Client

LIMIT = 400.0
"""Simulated seconds for which the robot stays at its charger."""


def rounds(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")
    full: list[dict[str, Any]] = []
    listen(client, lambda event: full.append(event) if event["kind"] == "battery_full" else None)

    def charged() -> bool:
        battery = next(robot["battery"] for robot in scene(client)["robots"] if robot["name"] == wall_e.robot)
        return bool(battery["percentage"] >= 0.95)

    def charge() -> bool:
        if not wall_e.dock("charger") or not wall_e.wait(10):  # its sensors are cleaned meanwhile
            return False
        full.clear()
        end = client.now + LIMIT
        while not (full if bug else charged()):  # the bug: it waits for a change, and not for a state
            client.sleep(5.0)
            if not bug and client.now > end:
                return False
        return True

    steps = (lambda: wall_e.go("ward_b"), charge, lambda: wall_e.go("ward_c"))
    return all(wall_e.insist(step) for step in steps)
