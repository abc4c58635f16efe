"""Robots for asyncio, over Zenoh, in real time."""

from __future__ import annotations

import asyncio
import logging
from contextlib import ExitStack

import pytest

from hmrsim.settings.run import RunSettings
from hmrsim.world.overlays.overlay import setting
from hmrsim.world_checks import load_world
from hmrsim_zenoh import AsyncClient, RequestError, SessionOptions, SimulatorGone, SimulatorNotFound, Unreachable
from hmrsim_zenoh.hosting.host import Host
from tests.patience import PATIENCE


@pytest.fixture
def options():
    """Return the options that connect to a café at a hundred times real time."""
    listen = SessionOptions(listen=("tcp/127.0.0.1:0",))
    with Host(load_world("cafe"), listen, RunSettings(real_time_factor=100.0)) as host:
        host.start()
        yield SessionOptions(connect=(host.endpoints[0],))


def test_robots_drive_in_concurrent_tasks_and_events_are_iterated(options):

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


def test_a_charge_is_awaited_in_real_time(options):

    async def main():
        async with AsyncClient(options=options) as client:
            latte = client.robot("latte")
            await latte.navigate_to("hall")
            low = await latte.battery()
            await latte.dock("charger_2")
            full = await asyncio.wait_for(latte.wait_until_charged(1.0), 20)
            return low.percentage, full.percentage

    low, full = asyncio.run(main())
    assert low < full
    assert 1.0 == full


def test_a_canceled_task_stops_its_robot(options):
    """The goal has ended when the task has."""

    async def main():
        async with AsyncClient(options=options) as client:
            with pytest.raises(TimeoutError):
                await asyncio.wait_for(client.robot("mocha").wait(10000), 0.2)
            return await client.robot("mocha").wait(1)

    asyncio.run(main())


def test_lockstep_advances_while_tasks_wait_only_for_events():

    async def main(endpoint):
        async with AsyncClient(options=SessionOptions(connect=(endpoint,))) as client:
            times = []
            async for event in client.events("order_placed"):
                times.append((event["order"], await client.now()))
                if len(times) == 3:
                    break
            return times

    order = "{name: order, at: counter, to: table_1, arrives: 30}"
    world = load_world("cafe", overlays=[setting(f"demand.+={order}")])
    listen = SessionOptions(listen=("tcp/127.0.0.1:0",))
    with Host(world, listen, RunSettings(clock="lockstep")) as host:
        host.start()
        times = asyncio.run(main(host.endpoints[0]))

    assert [("order_1", 30.0), ("order_2", 60.0), ("order_3", 90.0)] == times


def test_waiting_for_orders_in_a_world_without_demand_is_warned_of(options, caplog):
    """The wait goes on, as clients can place orders in any world."""

    class Placing(logging.Handler):
        """Places an order when the warning comes."""

        def emit(self, _record):
            client.client.get(client.client.keys.world("place_order"), payload=b'{"at": "counter", "to": "table_1"}')

    async def main():
        async with client:
            return await asyncio.wait_for(anext(client.orders()), PATIENCE)

    client, placing = AsyncClient(options), Placing(logging.WARNING)
    log = logging.getLogger("hmrsim_zenoh.client.aio")
    log.addHandler(placing)
    try:
        order = asyncio.run(main())
    finally:
        log.removeHandler(placing)

    assert ("counter", "table_1") == (order["from"], order["to"])
    assert ["world 'cafe' has no demand: orders() waits for clients that call place_order, or for load_world"] == [
        record.getMessage() for record in caplog.records if record.name == log.name
    ]


def test_waiting_for_the_first_order_of_a_demand_is_not_warned_of(caplog):
    world = load_world("cafe", overlays=[setting("demand.+={name: order, at: counter, to: table_1, arrives: 30}")])
    listen = SessionOptions(listen=("tcp/127.0.0.1:0",))

    async def main(endpoint):
        async with AsyncClient(SessionOptions(connect=(endpoint,))) as client:
            return await asyncio.wait_for(anext(client.orders()), PATIENCE)

    with Host(world, listen, RunSettings(real_time_factor=100.0)) as host:
        host.start()
        assert "order_1" == asyncio.run(main(host.endpoints[0]))["order"]
    assert "demand" not in caplog.text


def test_waiting_for_an_event_ends_when_the_simulator_goes():
    listen = SessionOptions(listen=("tcp/127.0.0.1:0",))
    stack = ExitStack()
    host = stack.enter_context(Host(load_world("cafe"), listen, RunSettings()))
    host.start()

    async def main():
        async with AsyncClient(options=SessionOptions(connect=(host.endpoints[0],))) as client:
            sleep = asyncio.create_task(client.sleep(1000))
            await client.sleep(0.1)
            await asyncio.to_thread(stack.close)
            await sleep

    with stack, pytest.raises((SimulatorGone, SimulatorNotFound)):
        asyncio.run(main())


def test_reading_a_missing_battery_is_an_error(options):

    async def main():
        async with AsyncClient(options=options) as client:
            await client.robot("wally").battery()

    with pytest.raises((RequestError, Unreachable), match="wally"):
        asyncio.run(main())


def test_session_options_can_be_passed_first(options):
    """The order is that of `Client`."""

    async def main():
        async with AsyncClient(options) as client:
            return client.client.alive

    assert asyncio.run(main())


def test_tasks_that_wait_for_each_other_end_when_the_simulator_goes():
    listen = SessionOptions(listen=("tcp/127.0.0.1:0",))
    stack = ExitStack()
    host = stack.enter_context(Host(load_world("cafe"), listen, RunSettings()))
    host.start()

    async def main():
        async with AsyncClient(options=SessionOptions(connect=(host.endpoints[0],))):
            await asyncio.to_thread(stack.close)
            await asyncio.Event().wait()

    with stack, pytest.raises(SimulatorGone, match=r"simulator 'hmrsim' is gone: .*; start it again"):
        asyncio.run(main())
