"""An emergency is switched on and off repeatedly, and all robots stop and resume.

Asked in https://github.com/open-rmf/rmf_ros2/issues/462, where a few toggles crash the adapter.
"""

import asyncio

from hmrsim.testing import simulation
from hmrsim_zenoh import AsyncClient, AsyncRobot

ROUTES = {"mocha": "table_1", "latte": "table_3", "chai": "table_2"}
TOGGLES = 50


async def emergency(client: AsyncClient, drives: list[asyncio.Task[object]]) -> None:
    """Stop all robots; a canceled task ends when its robot has stopped."""
    for drive in drives:
        drive.cancel()
    await asyncio.wait(drives)
    await client.sleep(0.1)


async def patrol(robots: dict[str, AsyncRobot], client: AsyncClient) -> None:
    """Interrupt the drives by one emergency after another, then let the robots arrive."""
    for _ in range(TOGGLES):
        drives = [asyncio.ensure_future(robot.navigate_to(ROUTES[name])) for name, robot in robots.items()]
        await client.sleep(0.3)
        await emergency(client, drives)
    await asyncio.gather(*(robot.navigate_to(ROUTES[name]) for name, robot in robots.items()))


def test_robots_arrive_after_fifty_emergencies() -> None:
    """Each goal gets one terminal status, and all robots arrive in the end."""
    with simulation("cafe") as run:

        async def main() -> None:
            async with AsyncClient(run.client) as client:
                await patrol({name: client.robot(name) for name in ROUTES}, client)

        asyncio.run(main())

        assert all(goal.status.terminal for goal in run.goals())
        assert {name: run.where(name) for name in ROUTES} == ROUTES
