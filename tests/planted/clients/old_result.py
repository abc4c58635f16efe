"""A slow goal is sent again, and the end of the preempted one is taken for that of the new one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from driving import ATTEMPTS, PAUSE, Driver, Handle

from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    from hmrsim_zenoh import Client

LIMIT = 25.0
"""Simulated seconds after which a drive is sent again, once."""


def rounds(client: Client, *, bug: bool = False) -> bool:
    wall_e = Driver(client, "wall_e")
    return all(_visit(client, wall_e, place, bug=bug) for place in ("ward_a", "ward_b", "ward_c"))


def _visit(client: Client, wall_e: Driver, place: str, *, bug: bool) -> bool:
    """Drive to a place; a failed goal is sent again after a pause, a preempted one at once."""
    latest: list[Handle] = []
    ended: list[Handle] = []

    def note(handle: Handle) -> None:
        if handle.done and (bug or handle is latest[-1]):  # the bug: whichever goal it is of
            ended.append(handle)

    def send() -> None:
        ended.clear()
        latest.append(wall_e.start_to(place, on_change=note))

    send()
    sent, failures = client.now, 0
    while failures < ATTEMPTS:
        client.sleep(1.0)
        if ended and ended[-1].status is GoalStatus.SUCCEEDED:
            return True
        if ended:
            failures += 1
            if ended[-1].cause != "preempted":
                client.sleep(PAUSE)
            send()
        elif sent + LIMIT <= client.now and len(latest) == 1:
            send()
    return False
