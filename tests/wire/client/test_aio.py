"""Robots for asyncio, over Zenoh, in real time."""

from __future__ import annotations

import asyncio

import pytest

from hmrsim.settings.run import RunSettings
from hmrsim.world_checks import load_world
from hmrsim_zenoh import AsyncClient, SessionOptions
from hmrsim_zenoh.hosting.host import Host


@pytest.fixture
def options():
    """Return how to connect to a café whose time is a hundred times as fast."""
    listen = SessionOptions(listen=("tcp/127.0.0.1:0",))
    with Host(load_world("cafe"), listen, RunSettings(real_time_factor=100.0)) as host:
        host.start()
        yield SessionOptions(connect=(host.endpoints[0],))


def test_robots_drive_at_once_and_events_come(options):
    """Each in a task of its own; events are an iterator."""

    async def until_docked(events):
        async for event in events:
            if event["kind"] == "dock_docked":
                yield event
                return

    async def main():
        async with AsyncClient(options=options) as client:

            async def first_docked():
                return [event["robot"] async for event in until_docked(client.events())]

            watch = asyncio.create_task(first_docked())
            await client.sleep(0.1)
            await asyncio.gather(client.robot("mocha").navigate_to("hall"), client.robot("chai").navigate_to("counter"))
            await client.robot("mocha").dock("charger_1")
            return await asyncio.wait_for(watch, 20)

    assert asyncio.run(main()) == ["mocha"]


def test_a_canceled_task_stops_its_robot(options):
    """When the task has ended, the goal has."""

    async def main():
        async with AsyncClient(options=options) as client:
            with pytest.raises(TimeoutError):
                await asyncio.wait_for(client.robot("mocha").wait(10000), 0.2)
            return await client.robot("mocha").wait(1)

    asyncio.run(main())
