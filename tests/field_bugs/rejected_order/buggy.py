"""Hand orders out to two robots; an order that a robot rejects is lost."""

import asyncio
import json

from hmrsim_zenoh import GoalFailed, GoalRejectedError

SHIFT = 150.0
PAUSE = 25.0


class Dispatcher:
    """Hands each new order to a robot that has none."""

    def __init__(self, client):
        """Serve the orders of a simulator."""
        self._client = client
        self._known = set()
        self._waiting = []

    async def serve(self):
        """Serve what comes during the shift."""
        async with asyncio.TaskGroup() as tasks:
            for name in ("eve", "wall_e"):
                tasks.create_task(self._work(name))

    def _update(self):
        """Take new orders over, in the order in which they came."""
        for order in self._demand():
            if order["name"] not in self._known:
                self._known.add(order["name"])
                self._waiting.append(order)

    def _demand(self):
        """Return the open orders."""
        return json.loads(self._client.client.get("hmrsim/_world/demand"))["orders"]

    def _take(self, name):
        """Return the next order for a robot, rather one whose item it holds already."""
        self._update()
        mine = [order for order in self._waiting if order["robot"] == name]
        free = [order for order in self._waiting if not order["robot"]]
        if order := next(iter(mine + free), None):
            self._waiting.remove(order)
        return order

    async def _work(self, name):
        """Serve one order after the other until the shift is over."""
        robot = self._client.robot(name)
        while True:
            order = self._take(name)
            if order:
                await self._serve(robot, order)
            elif await self._client.now() > SHIFT:
                return
            else:
                await self._client.sleep(5)

    async def _serve(self, robot, order):
        """Bring the item of an order to its destination."""
        while state := self._state(order):
            try:
                if state["state"] == "waiting":
                    await robot.navigate_to(self._pose(order["item"]))
                    await robot.pickup(order["item"])
                await robot.navigate_to(order["to"])
                await robot.place(order["item"])
            except GoalRejectedError:
                return
            except GoalFailed:
                await self._client.sleep(PAUSE)

    def _state(self, order):
        """Return an order as it is now; None if it is served."""
        return next((one for one in self._demand() if one["name"] == order["name"]), None)

    def _pose(self, item):
        """Return where an item lies."""
        scene = json.loads(self._client.client.get("hmrsim/_world/scene"))
        return tuple(next(one for one in scene["items"] if one["name"] == item)["at"])


async def dispatch(client):
    """Serve the canteen for one shift."""
    await Dispatcher(client).serve()
