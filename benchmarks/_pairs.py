"""Controllers that only two faults together break: one starts a recovery, the other one comes in the midst of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim_zenoh.client.commander import Commander
from hmrsim_zenoh.errors import GoalFailed, GoalRejectedError

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim_zenoh.client.client import Client

PORTERS = 6
"""One after the other brings a box; in the errand of one of them is the bug."""

_PLACES = {"home": 0, "store": 10, "shelf": 20}

WORLD: dict[str, Any] = {
    "name": "pairs",
    "waypoints": {
        name: [x, 10 * i]
        for i in range(PORTERS)
        for name, x in ((f"home_{i}", 0), (f"store_{i}", 10), (f"shelf_{i}", 20))
    },
    "lanes": [lane for i in range(PORTERS) for lane in ([f"home_{i}", f"store_{i}"], [f"store_{i}", f"shelf_{i}"])],
    "items": {f"box_{i}": {"at": [10, 10 * i + 0.3]} for i in range(PORTERS)},
    "robots": {f"porter_{i}": {"at": f"home_{i}", "components": {"claw": {}}} for i in range(PORTERS)},
}

_REST = 60.0
"""Simulated seconds until a porter recovers: no fault lasts as long, so that one alone can't spoil both."""

PAIRS = (("go", "wait"), ("go", "home"), ("pickup", "wait"), ("pickup", "home"), ("place", "wait"), ("place", "home"))
"""What has to fail first, and which part of the recovery then."""


def mission(client: Client, first: str, second: str, porter: int) -> bool:
    """Deliver each porter's box, with one recovery from a failure.

    The bug: one *porter* is lost if a part of that recovery, the *second*, fails after a step of its errand, the
    *first*.
    """
    return all(_errand(client, i, (first, second) if i == porter else ()) for i in range(PORTERS))


def _errand(client: Client, i: int, bug: tuple[str, ...]) -> bool:
    porter, y = Commander(client, f"porter_{i}"), 10 * i
    steps: dict[str, Callable[[], object]] = {
        "go": lambda: porter.go_to_pose(10, y),
        "pickup": lambda: porter.pickup(f"box_{i}"),
        "bring": lambda: porter.go_to_pose(20, y),
        "place": lambda: porter.place(f"box_{i}"),
    }
    recovery: dict[str, Callable[[], object]] = {
        "wait": lambda: porter.wait(5),
        "home": lambda: porter.go_to_pose(0, y),
    }
    for name, step in steps.items():
        if _done(step):
            continue
        client.sleep(_REST)
        for part, recover in recovery.items():
            if not _done(recover) and (name, part) == bug:
                while True:  # the planted bug
                    client.sleep(60)
        if not _done(step):
            return False
    return True


def _done(step: Callable[[], object]) -> bool:
    try:
        step()
    except (GoalFailed, GoalRejectedError):
        return False
    return True
