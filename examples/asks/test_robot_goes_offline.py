"""A robot goes offline, and another robot takes over its task.

Asked in https://github.com/open-rmf/rmf_ros2/issues/105, where tasks of a robot that disappears wait forever.
"""

import asyncio

from hmrsim.testing import simulation
from hmrsim_zenoh import AsyncClient, AsyncRobot, GoalFailed, GoalRejectedError

OFFLINE = {"type": "messages_lost", "robot": "mocha", "at": 6, "duration": 300}


async def serve(robot: AsyncRobot) -> None:
    """Bring the cake to table 1."""
    await robot.navigate_to("counter")
    await robot.pickup("cake")
    await robot.navigate_to("table_1")
    await robot.place("cake")


async def reassign(client: AsyncClient, names: list[str]) -> str:
    """Give the task to one robot after the other, and move on if it is not done after 40 s."""
    for name in names:
        work = asyncio.create_task(serve(client.robot(name)))
        late = asyncio.create_task(client.sleep(40))
        await asyncio.wait({work, late}, return_when=asyncio.FIRST_COMPLETED)
        late.cancel()
        try:
            if work.done():
                await work
                return name
        except (GoalFailed, GoalRejectedError):
            continue
        work.cancel()
    return ""


def test_another_robot_takes_over() -> None:
    """Mocha disappears on its way to the counter; latte serves."""
    with simulation("cafe", changes={"faults.+": OFFLINE}) as run:

        async def main() -> str:
            async with AsyncClient(run.client) as client:
                return await reassign(client, ["mocha", "latte"])

        assert asyncio.run(main()) == "latte"
        assert run.where("cake") == "table_1"
