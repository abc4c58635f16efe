"""Drive two robots at once with asyncio, for ``hmrsim run cafe --clock lockstep``.

Time waits for both, so that this prints the same each time. ``python examples/async_robots.py [ENDPOINT]``
"""

import asyncio
import sys

from hmrsim_zenoh import AsyncClient, AsyncRobot, GoalFailed, SessionOptions


async def serve(client: AsyncClient, robot: AsyncRobot, item: str, table: str) -> None:
    """Bring an item from the counter to a table, and tell when it is there."""
    await robot.navigate_to("counter")
    await robot.pickup(item)
    await robot.navigate_to(table)
    await robot.place(item)
    print(f"{await client.now():5.1f} s  {robot.name} has served the {item}")


async def main() -> None:
    """Serve two tables, and give a third errand half a minute."""
    options = SessionOptions(connect=tuple(sys.argv[1:])) if sys.argv[1:] else None
    async with AsyncClient(options=options, name="cafe") as client:
        mocha, latte, chai = (client.robot(name) for name in ("mocha", "latte", "chai"))
        await asyncio.gather(
            serve(client, mocha, "coffee", "table_1"),
            serve(client, latte, "cake", "table_3"),
        )
        dishes = asyncio.create_task(chai.navigate_to("table_3"))
        await client.sleep(10)
        dishes.cancel()  # which cancels its goal
        await asyncio.wait([dishes])
        print(f"{await client.now():5.1f} s  {chai.name} has stopped")
        try:
            await chai.pickup("dishes")
        except GoalFailed as error:
            print(error)


asyncio.run(main())
