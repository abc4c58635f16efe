"""A dispatcher of orders, of which each planted bug changes a little."""

from __future__ import annotations

import json
import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from driving import ATTEMPTS, PAUSE, Driver, Handle, places, scene

from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    from hmrsim_zenoh import Client

SHIFT = 200.0
"""Simulated seconds for which orders may come."""
LIMIT = 900.0
"""Simulated seconds after which the dispatcher gives up."""
STEP = 2.0
NEEDED = frozenset({"navigate_to_pose", "pickup", "place"})

Job = Generator["Handle | Pause", bool, bool]


@dataclass(frozen=True)
class Pause:
    """A pause in simulated seconds, which can be awaited like a goal."""

    until: float


@dataclass
class Work:
    """A robot's order, and the steps of its errand."""

    order: dict[str, Any]
    job: Job
    waits_for: Handle | Pause


class Dispatcher:
    """Gives each order to the nearest robot that is free, until the shift is over and all is done.

    A robot tries its errand again if that fails, with pauses; then the order is anybody's again.
    """

    def __init__(self, client: Client) -> None:
        self.client = client
        robots = client.info()["robots"]
        self.drivers = {robot["name"]: Driver(client, robot["name"]) for robot in robots}
        self.able = [robot["name"] for robot in robots if NEEDED.issubset(robot["actions"])]
        self.work: dict[str, Work] = {}
        self.taken: list[str] = []
        self.places = places(client)

    def serve(self) -> bool:
        """Serve until the shift is over; return whether nothing is left."""
        while self.client.now < LIMIT:
            for order in self.orders():
                if order["name"] not in self.taken:
                    self.give(order)
            self.proceed()
            if self.is_over():
                return True
            self.client.sleep(STEP)
        return False

    def is_over(self) -> bool:
        """Return whether there is nothing left to do."""
        return self.client.now >= SHIFT and not self.work and not self.open_orders()

    def open_orders(self) -> list[dict[str, Any]]:
        """Return the open orders as the world has them."""
        found: list[dict[str, Any]] = json.loads(self.client.get(self.client.keys.world("demand")))["orders"]
        return found

    def orders(self) -> Sequence[dict[str, Any]]:
        return self.open_orders()

    def give(self, order: dict[str, Any]) -> None:
        """Give an order to a robot, if one is free for it."""
        robot = order.get("robot") if order["state"] == "carried" else self.choose(order)
        if robot and robot not in self.work:
            self.begin(robot, order)

    def begin(self, robot: str, order: dict[str, Any]) -> None:
        self.taken.append(order["name"])
        job = self.errand(robot, order)
        self.work[robot] = Work(order, job, next(job))

    def free(self) -> list[str]:
        return [robot for robot in self.able if robot not in self.work]

    def choose(self, order: dict[str, Any]) -> str | None:
        """Return the robot for an order, or None."""
        return self.nearest(self.free(), order["at"])

    def nearest(self, robots: Sequence[str], place: str) -> str | None:
        """Return the robot nearest to a place, or None if there is none."""
        at = {robot["name"]: robot["pose"][:2] for robot in scene(self.client)["robots"]}
        return min(robots, key=lambda robot: (math.dist(at[robot], self.places[place]), robot), default=None)

    def proceed(self) -> None:
        """Continue with each robot whose step has ended."""
        for robot, work in [*self.work.items()]:
            waits_for = work.waits_for
            if isinstance(waits_for, Pause):
                if waits_for.until > self.client.now:
                    continue
                succeeded = True
            else:
                if not self.has_ended(waits_for):
                    continue
                succeeded = waits_for.status is GoalStatus.SUCCEEDED
            try:
                work.waits_for = work.job.send(succeeded)
            except StopIteration as end:
                del self.work[robot]
                self.ended(robot, work.order, succeeded=end.value)

    def has_ended(self, handle: Handle) -> bool:
        """Return whether a goal has ended; rejected is an end, too."""
        return handle.done

    def ended(self, robot: str, order: dict[str, Any], *, succeeded: bool) -> None:  # noqa: ARG002 - for bugs
        if not succeeded:
            self.taken.remove(order["name"])

    def errand(self, robot: str, order: dict[str, Any]) -> Job:
        """Yield the steps to wait for; return whether the order is finished."""
        for attempt in range(ATTEMPTS):
            if attempt:
                yield Pause(self.client.now + PAUSE)
            if (yield from self.attempt(robot, order)):
                return True
        return False

    def attempt(self, robot: str, order: dict[str, Any]) -> Job:
        """Try the errand once, from the item's current place."""
        driver = self.drivers[robot]
        found = next((item for item in scene(self.client)["items"] if item["name"] == order["item"]), None)
        if found is None or found["carrier"] not in (None, robot):
            return True
        if found["carrier"] is None:
            x, y = found["at"]
            if not (yield driver.start_to((x, y))) or not (yield driver.start_pickup(order["item"])):
                return False
        return (yield driver.start_to(order["to"])) and (yield driver.start_place(order["item"]))
