"""Carry parcels, and send the robot to its charger as soon as the battery is low."""

import asyncio
from contextlib import suppress

from hmrsim_zenoh import GoalFailed, GoalRejectedError, NotCharging, RequestError, Unreachable

PARCELS = ("parcel_1", "parcel_2", "parcel_3")
TRIES = 12
PAUSE = 25.0
LOW = 0.3


class Porter:
    """A robot that is interrupted when it has to charge."""

    def __init__(self, client, name):
        """Drive the robot of this name."""
        self._client = client
        self._robot = client.robot(name)
        self._free = asyncio.Event()
        self._free.set()

    async def carry(self, parcels):
        """Bring all parcels to the desk; return whether they lie there."""
        for parcel in parcels:
            for place, action in (("store", self._robot.pickup), ("desk", self._robot.place)):
                if not await self._attempt(place, action, parcel):
                    return False
        return True

    async def _attempt(self, place, action, parcel):
        """Drive to a place and act there, again from the drive on if need be; return whether it is done."""
        for _ in range(TRIES):
            await self._free.wait()
            try:
                await self._robot.navigate_to(place)
                await action(parcel)
            except GoalRejectedError:
                await self._client.sleep(PAUSE)
            except GoalFailed as failure:
                if failure.cause != "preempted":
                    await self._client.sleep(PAUSE)
            else:
                return True
        return False

    async def charge_if_low(self):
        """Charge, if the battery is low already, as after a restart of this program."""
        while True:
            try:
                battery = await self._robot.battery()
            except (RequestError, Unreachable):
                await self._client.sleep(5)
            else:
                break
        if battery.percentage <= LOW:
            await self._charge()

    async def watch_the_battery(self):
        """Charge whenever the battery is low."""
        async for event in self._client.events("battery_low"):
            if event["robot"] == "eve":
                self._free.clear()
                await self._charge()
                self._free.set()

    async def _charge(self):
        while True:
            try:
                await self._robot.dock("charger")
                await self._robot.wait_until_charged(0.8)
            except (GoalFailed, GoalRejectedError, NotCharging, RequestError, Unreachable):
                await self._client.sleep(PAUSE)
            else:
                return


async def deliver(client):
    """Carry the parcels; return whether all of them lie on the desk."""
    eve = Porter(client, "eve")
    await eve.charge_if_low()
    guard = asyncio.create_task(eve.watch_the_battery())
    try:
        return await eve.carry(PARCELS)
    finally:
        guard.cancel()
        with suppress(asyncio.CancelledError):
            await guard
