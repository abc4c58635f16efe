"""The pause between two attempts is in wall time, during which no simulated time passes."""

import time

from driving import ATTEMPTS, PAUSE, Driver

from hmrsim_zenoh import Client


def rounds(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")

    def visit(place: str) -> bool:
        for _ in range(ATTEMPTS):
            if wall_e.go(place):
                return True
            if bug:
                time.sleep(0.001)  # the bug: on a real robot this would be 45 s
            else:
                client.sleep(PAUSE)
        return False

    return all(visit(place) for place in ("ward_a", "ward_b"))
