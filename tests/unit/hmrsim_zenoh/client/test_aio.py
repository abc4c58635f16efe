"""Robots for asyncio, in lockstep: time goes on when all tasks wait."""

from __future__ import annotations

import asyncio
import threading
from contextlib import suppress
from functools import partial

import pytest

from hmrsim.actions import registry
from hmrsim.settings.run import RunSettings
from hmrsim.testing import simulation
from hmrsim_zenoh import AsyncClient, Commander, GoalFailed, Idle, NotCharging, SimulationEnded, SimulatorGone
from hmrsim_zenoh.client import aio_time
from hmrsim_zenoh.client.aio_time import AsyncTime
from tests.cases import case
from tests.patience import PATIENCE


def played(play, changes=None):
    """Run a coroutine function with a client of the café; return the run, which has ended."""
    with simulation("cafe", changes=changes or {}) as run:

        async def main():
            async with AsyncClient(run.client) as client:
                return await play(client)

        run.answer = asyncio.run(main())
        run.said = run.trace
    return run


async def serve(robot, item, table):
    """Bring an item to a table with a robot."""
    await robot.navigate_to("counter")
    await robot.pickup(item)
    await robot.navigate_to(table)
    await robot.place(item)


async def serve_two(client):
    """Run two robots at once, while a third task watches the clock."""
    async with asyncio.TaskGroup() as tasks:
        tasks.create_task(serve(client.robot("mocha"), "coffee", "table_1"))
        tasks.create_task(serve(client.robot("latte"), "cake", "table_3"))
        tasks.create_task(client.sleep(7))
    return await client.now()


def test_robots_drive_at_once_and_a_run_is_the_same_each_time():
    """The order of threads makes no difference."""
    first, second = played(serve_two), played(serve_two)

    assert first.said == second.said
    assert 30 < first.answer < 60
    assert [8] == [len(first.goals(status="SUCCEEDED"))]


def test_what_tasks_do_at_an_instant_is_done_before_time_goes_on():
    """The number of steps of the event loop makes no difference."""

    async def play(client):
        async def later():
            await client.sleep(1)
            for _ in range(50):
                await asyncio.sleep(0)
            at = await client.now()
            await client.robot("mocha").wait(1)
            return at

        at, _ = await asyncio.gather(later(), client.sleep(10))
        return at

    assert played(play).answer == 1.0


def test_all_who_wait_are_told_that_the_run_is_over():
    """Another task that was woken before has sent a request since."""

    async def play(client):
        async def work():
            while True:
                try:
                    await client.robot("mocha").wait(1)
                except SimulationEnded:
                    with suppress(SimulationEnded):
                        await client.robot("mocha").wait(1)
                    return "told"

        async def until_late():
            with pytest.raises(SimulationEnded, match="the run is over"):
                await client.sleep(100)
            with pytest.raises(SimulationEnded, match="the run is over"):
                await client.sleep(1)
            with pytest.raises(SimulationEnded, match="the run is over"):
                await anext(client.events("order_placed"))
            return "told"

        return await asyncio.gather(work(), until_late(), until_late())

    with simulation("cafe", settings=RunSettings(duration=10)) as run:

        async def main():
            async with AsyncClient(run.client) as client:
                return await play(client)

        assert ["told"] * 3 == asyncio.run(main())


class Killed(BaseException):
    """Ends a controller, as a fault search does."""


def test_any_error_of_a_request_reaches_the_task_that_made_it(monkeypatch):
    async def play(client, error):
        monkeypatch.setattr(client.client, "info", lambda: _raise(error))
        with pytest.raises(type(error)) as raised:
            await client.info()
        return raised.value

    for error in (ValueError(), Killed(), SystemExit(), KeyboardInterrupt(), asyncio.CancelledError()):
        with case(error):
            assert error is played(partial(play, error=error)).answer


def test_any_error_of_an_advance_reaches_the_task_that_waits(monkeypatch):
    async def play(client):
        error = Killed()
        monkeypatch.setattr(client.client.lockstep, "drive_within", lambda *_: _raise(error))
        with pytest.raises(Killed):
            await client.sleep(1.0)

    played(play)


def _raise(error):
    raise error


class Gone:
    """A client whose simulator has gone, which its calls report once it was looked for.

    Attributes:
        looks: How often it was looked for.
    """

    def __init__(self):
        self.looks = 0
        self._looked = threading.Event()

    @property
    def absence(self):
        self.looks += 1
        self._looked.set()
        return SimulatorGone("it is gone")

    @property
    def now(self):
        self._looked.wait(PATIENCE)
        raise SimulatorGone("it is gone")


@pytest.mark.parametrize("ask", [AsyncTime.now, lambda time: time.ask(lambda: time._client.now)], ids=["now", "ask"])
def test_a_call_that_reports_that_the_simulator_is_gone_cancels_no_task(monkeypatch, ask):
    """Neither while it waits nor later: the program may wait for the simulator to come back."""
    monkeypatch.setattr(aio_time, "_LOOK_AROUND", 0.0)

    async def main():
        client = Gone()
        time = AsyncTime(client, None)
        with pytest.raises(SimulatorGone):
            await ask(time)
        before = client.looks
        for _ in range(10):
            await asyncio.sleep(0)
        time.close()
        return client.looks - before

    assert asyncio.run(main()) > 1


def test_an_event_that_does_not_exist():
    async def play(client):
        with pytest.raises(ValueError, match=r"no event 'order_placd'; did you mean 'order_placed'\?"):
            await anext(client.events("order_placd"))

    played(play)


LOW = {"robots.mocha.components.battery.initial_charge": 1000}


async def charge(client):
    """Charge a robot; return when it has 80 %, and the states of its battery before and after."""
    mocha = client.robot("mocha")
    before = await mocha.battery()
    await mocha.dock("charger_1")
    after = await mocha.wait_until_charged(0.8)
    return round(before.percentage, 3), round(after.percentage, 3), await client.now()


def test_a_robot_tells_its_pose_type_and_components():
    async def told(cafe):
        mocha = cafe.robot("mocha")
        await mocha.navigate_to("table_1")
        return mocha.type, [*mocha.components], await mocha.pose()

    kind, components, pose = played(told).answer

    assert ("waiter", ["battery", "claw"], (6.0, 6.0)) == (kind, components, pose.point)


def test_the_type_of_a_robot_that_is_not_there():
    async def told(cafe):
        with pytest.raises(ValueError, match=r"no robot 'moccha'; did you mean 'mocha'\?"):
            _ = cafe.robot("moccha").type

    played(told)


def test_the_description_of_a_simulator_takes_no_time():
    async def described(cafe):
        robots = (await cafe.info())["robots"]
        return {robot["name"]: robot["type"] for robot in robots}, await cafe.now()

    robots, now = played(described).answer

    assert ("waiter", 0.0) == (robots["mocha"], now)


def test_time_goes_on_until_a_battery_is_charged():
    """Time stops at that charge, and each run is the same."""
    first, second = played(charge, LOW), played(charge, LOW)

    assert first.said == second.said
    assert (0.333, 0.8) == first.answer[:2]
    assert 20 < first.answer[2] < 30


def test_a_program_that_fails_tells_its_own_error():
    """A goal that still runs makes no difference."""

    async def play(client):
        async def fail():
            await client.sleep(1)
            raise KeyError("mine")

        await asyncio.gather(client.robot("mocha").wait(10), fail())

    with pytest.raises(KeyError, match="mine"):
        played(play)


def test_a_battery_that_is_not_charged_is_not_waited_for():
    """The robot does not charge from the beginning, or stops when it leaves the dock."""

    async def play(client):
        mocha, chai = client.robot("mocha"), client.robot("chai")
        await chai.wait(6)
        with pytest.raises(NotCharging, match="'chai' does not charge: its battery is at 99"):
            await chai.wait_until_charged(1.0)

        async def leave():
            await client.sleep(5)
            await mocha.undock()

        with pytest.raises(NotCharging, match=r"'mocha' does not charge: its battery is at 5\d\.\d%"):
            await asyncio.gather(mocha.wait_until_charged(), leave())
        with pytest.raises(ValueError, match="2 is not a share of a capacity"):
            await mocha.wait_until_charged(2)

    played(play, LOW)


ORDERS = {"name": "order", "item": "cup", "at": "counter", "to": ["table_1", "table_2"], "arrives": 30, "count": 4}


async def serve_orders(client):
    """Serve orders as they come, while a second robot waits; return when each was served."""
    served = []
    async for event in client.events("order_placed"):
        robot = client.robot("mocha")
        await serve(robot, event["item"], event["to"])
        served.append((event["item"], await client.now()))
        if len(served) == ORDERS["count"]:
            break
    return served


def test_time_goes_on_until_an_event_comes():
    """No other task waits for anything, and each run is the same."""
    first, second = (played(serve_orders, {"demand.+": ORDERS}) for _ in range(2))

    assert first.said == second.said
    assert ["cup_1", "cup_2", "cup_3", "cup_4"] == [item for item, _ in first.answer]
    assert 100 < first.answer[-1][1] < 200


def test_all_events_of_an_instant_come():
    """Events come in order, at the time at which they happen."""

    async def play(client):
        told = []

        async def listen():
            async for event in client.events():
                at = await client.now()
                told.append((event["kind"], event.get("robot"), at))

        listener = asyncio.create_task(listen())
        await asyncio.gather(client.robot("mocha").undock(), client.robot("latte").undock())
        await client.sleep(1)
        listener.cancel()
        return told

    told = played(play).answer

    undocked = [(robot, at) for kind, robot, at in told if kind == "dock_undocked"]
    assert [("mocha", 0.0), ("latte", 0.0)] == undocked


async def first_orders(orders, number):
    """Return the names of the next orders, and their other fields by name."""
    placed = []
    async for order in orders:
        placed.append(order)
        if len(placed) == number:
            return placed
    return placed


def test_orders_that_were_placed_before_come_first():
    async def play(client):
        await client.sleep(70)
        told = await first_orders(client.orders(), 4)
        return [(order["order"], order["stamp"]["sec"]) for order in told], await client.now()

    numbered = [(f"order_{number}", 30 * number) for number in (1, 2, 3, 4)]
    assert (numbered, 120.0) == played(play, {"demand.+": ORDERS}).answer


def test_an_open_order_has_the_fields_of_its_event():
    async def play(client):
        (event,) = await first_orders(client.events("order_placed"), 1)
        (order,) = await first_orders(client.orders(), 1)
        return event, order

    demand = {**ORDERS, "priority": 2, "weight": 1.5, "within": 60.5}
    event, order = played(play, {"demand.+": demand}).answer
    assert event == order


def test_an_order_that_a_robot_already_carries_names_the_robot():
    async def play(client):
        (order,) = await first_orders(client.orders(), 1)
        mocha = client.robot("mocha")
        await mocha.navigate_to(order["from"])
        await mocha.pickup(order["item"])
        (again,) = await first_orders(client.orders(), 1)
        return again.get("robot")

    assert "mocha" == played(play, {"demand.+": ORDERS}).answer


def test_an_order_comes_once_if_its_event_is_on_its_way():
    """Two orders of an instant: the first wakes the task that asks for open orders, while the second's event waits."""

    async def play(client):
        async def listen():
            return [order["order"] for order in await first_orders(client.orders(), 4)]

        async def late():
            await anext(client.events("order_placed"))
            return await listen()

        return await asyncio.gather(listen(), late())

    twice = [{**ORDERS, "count": 2}, {**ORDERS, "name": "other", "count": 2}]
    there = played(play, {"demand": twice}).answer
    assert [["order_1", "other_1", "order_2", "other_2"]] * 2 == there


def test_orders_of_a_reset_world_come_again():
    async def play(client):
        await client.sleep(40)
        orders = client.orders()
        before = await anext(orders)
        await asyncio.to_thread(client.client.get, client.client.keys.world("reset_simulation"), payload=b"{}")
        after = await anext(orders)
        return before["order"], after["order"], await client.now()

    assert ("order_1", "order_1", 30.0) == played(play, {"demand.+": ORDERS}).answer


def test_no_more_events_can_come():
    """A task that waits for an event gets the error."""

    async def play(client):
        with pytest.raises(Idle):
            async for _ in client.events("order_placed"):
                pass

    played(play)


def test_a_task_that_is_canceled_cancels_its_goal_and_awaits_its_end():
    async def play(client):
        drive = asyncio.create_task(client.robot("mocha").navigate_to("terrace"))
        await client.sleep(3)
        drive.cancel()
        with pytest.raises(asyncio.CancelledError):
            await drive
        return await client.now()

    run = played(play)

    assert run.answer == pytest.approx(3.0, abs=1e-6)
    assert ["CANCELED"] == [goal.status.name for goal in run.goals("mocha")]


def test_a_goal_that_fails_raises_what_the_commander_raises():
    """The error names the robot, the action and the reason."""

    async def play(client):
        with pytest.raises(GoalFailed, match="mocha: pickup ended ABORTED: no item 'moon'"):
            await client.robot("mocha").pickup("moon")

    played(play)


def test_feedback_is_told():
    """The callback runs in the loop's thread."""

    async def play(client):
        told = []
        await client.robot("mocha").navigate_to("table_1", on_feedback=told.append)
        return told

    assert played(play).answer[-1].distance_remaining < 2


@pytest.mark.parametrize("seconds", [-1, float("nan"), float("inf")])
def test_what_is_no_time_is_refused(seconds):
    async def play(client):
        with pytest.raises(ValueError, match="can't sleep for"):
            await client.sleep(seconds)

    played(play)


def test_where_time_cannot_go_on_all_waits_end():
    async def play(client):
        waits = [client.robot("mocha").track_route("hall"), client.robot("latte").track_route("hall")]
        return await asyncio.gather(*waits, return_exceptions=True)

    assert [Idle, Idle] == [type(error) for error in played(play).answer]


CALLS = [
    ("undock",),
    ("navigate_to", "hall"),
    ("navigate_to", (6.0, 6.0)),
    ("navigate_through", ["table_2", "hall"]),
    ("follow_waypoints", ["entrance", (6.0, 6.0, 1.5)]),
    ("compute_path_to", "terrace"),
    ("compute_path_to", "terrace", "counter"),
    ("compute_path_through", ["hall", "terrace"]),
    ("compute_route", "table_2"),
    ("spin", 1.5),
    ("back_up", 0.2, 0.1),
    ("drive_on_heading", 0.2, 0.1),
    ("navigate_to", "counter"),
    ("pickup", "coffee"),
    ("place", "coffee"),
    ("wait", 1.0),
    ("dock", "charger_1"),
]


def test_a_commander_has_a_method_for_every_action():
    """A call of each method succeeds."""
    with simulation("cafe") as run:
        mocha = run.commander("mocha")
        for name, *values in CALLS:
            getattr(mocha, name)(*values)
        path = mocha.compute_path_to("table_1").path
        mocha.follow_path(mocha.smooth_path(path).path)
        offered = {goal.action for goal in run.goals("mocha", status="SUCCEEDED")}

    assert set(registry()) - {"compute_and_track_route", "simulate_steps"} == offered


def test_a_robot_for_asyncio_has_the_same_methods():
    """A call of each method succeeds."""

    async def play(client):
        mocha = client.robot("mocha")
        await asyncio.gather(mocha.track_route("hall"), mocha.navigate_to("hall"))
        for name, *values in CALLS[1:]:
            await getattr(mocha, name)(*values)
        path = (await mocha.compute_path_to("table_1")).path
        await mocha.follow_path((await mocha.smooth_path(path)).path)

    run = played(play)

    assert len(CALLS) + 4 == len(run.goals("mocha", status="SUCCEEDED"))


def test_an_unknown_place_is_named():
    """The error lists the known kinds of events."""
    with simulation("cafe") as run, pytest.raises(ValueError, match="no place 'table_5'; did you mean 'table_"):
        Commander(run.client, "mocha").navigate_to("table_5")
