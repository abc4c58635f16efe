"""Seven tasks arrive in quick succession, and each is done once.

Asked in https://github.com/open-rmf/rmf_demos/issues/302, where tasks that arrive quickly get no bids.
"""

import asyncio
from collections import Counter

from hmrsim.testing import simulation
from hmrsim_zenoh import AsyncClient, AsyncRobot

TASKS = ["table_1", "table_2", "hall", "entrance", "table_1", "counter", "table_2"]


async def work(robot: AsyncRobot, tasks: list[str], done: list[tuple[str, str]]) -> None:
    """Execute tasks while there are any."""
    while tasks:
        place = tasks.pop(0)
        await robot.navigate_to(place)
        done.append((robot.name, place))


def test_each_task_is_done_once() -> None:
    """The robots share the tasks."""
    with simulation("cafe") as run:
        done: list[tuple[str, str]] = []

        async def main() -> None:
            async with AsyncClient(run.client) as client:
                tasks = [*TASKS]
                await asyncio.gather(*(work(client.robot(name), tasks, done) for name in ("mocha", "latte", "chai")))

        asyncio.run(main())

        assert Counter(place for _, place in done) == Counter(TASKS)
        assert len({robot for robot, _ in done}) > 1
        assert len(run.goals(status="SUCCEEDED")) == len(TASKS)
