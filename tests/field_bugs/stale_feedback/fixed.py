"""Bring a sample to the lab; a drive that ends within half a meter of its goal counts as arrived."""

import math

from hmrsim_zenoh import GoalFailed, GoalRejectedError

POSES = {"ward": (0, 0), "lab": (12, 0)}
TOLERANCE = 0.5
TRIES = 12
PAUSE = 25.0


class Courier:
    """A robot, and where it was last."""

    def __init__(self, client, name):
        """Drive the robot of this name."""
        self._client = client
        self._robot = client.robot(name)
        self._position = None

    async def drive(self, place):
        """Drive to a place; return whether the robot has arrived, or is near enough."""
        goal = POSES[place]
        for _ in range(TRIES):
            self._position = None
            try:
                await self._robot.navigate_to(place, on_feedback=self._take_feedback)
            except GoalRejectedError:
                await self._client.sleep(PAUSE)
            except GoalFailed:
                if self._position and math.dist(self._position, goal) < TOLERANCE:
                    return True
                await self._client.sleep(PAUSE)
            else:
                return True
        return False

    async def pickup(self, item):
        """Pick an item up; return whether the robot holds it."""
        return await self._attempt(self._robot.pickup, item)

    async def place(self, item):
        """Put an item down; return whether it lies."""
        return await self._attempt(self._robot.place, item)

    async def _attempt(self, action, item):
        for _ in range(3):
            try:
                await action(item)
            except (GoalFailed, GoalRejectedError):
                await self._client.sleep(PAUSE)
            else:
                return True
        return False

    def _take_feedback(self, feedback):
        position = feedback.current_pose.pose.position
        self._position = (position.x, position.y)


async def deliver(client):
    """Bring the sample to the lab; return whether it lies there."""
    eve = Courier(client, "eve")
    return (
        await eve.drive("ward") and await eve.pickup("sample") and await eve.drive("lab") and await eve.place("sample")
    )
