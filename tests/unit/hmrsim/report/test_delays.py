"""The lead times of orders, attributed to what robots did meanwhile."""

from __future__ import annotations

import asyncio
from functools import partial
from itertools import accumulate, pairwise

from hypothesis import given
from hypothesis import strategies as st

from hmrsim.events.robots import ItemDropped, ItemPicked, ItemPlaced
from hmrsim.history.items import Order
from hmrsim.history.occurrence import Occurrence
from hmrsim.history.robots import STATES
from hmrsim.history.timeline import Timeline
from hmrsim.report import of_trace, report_of
from hmrsim.report.delays import PARTS, Delays
from hmrsim.report.goals import WaitRecord
from hmrsim.report.page import page_of
from hmrsim.report.robots import RobotLog
from hmrsim.testing.run import simulation
from hmrsim_zenoh import GoalFailed
from tests.profiles import examples

WORLD = {
    "waypoints": {"home": [0, 0], "gate": [4, 0], "shelf": [8, 0], "ward": [8, 4], "bay": [12, 0]},
    "lanes": [["home", "gate"], ["gate", "shelf"], ["shelf", "ward"], ["shelf", "bay"]],
    "traffic": {"policy": "reserve"},
    "docks": {"charger": {"at": [4, 4], "staging": [4, 0], "type": "charger", "power": 10}},
    "robot_types": {
        "cart": {
            "base": {"speed": 1, "radius": 0.3},
            "components": {
                "claw": {"reach": 1, "handling_time": 2},
                "battery": {"capacity": 100, "taper_from": 1, "drain": {"still": 0, "moving": 1}},
            },
        }
    },
    "robots": {"ann": {"type": "cart", "at": "home"}},
    "demand": [{"name": "meal", "at": "shelf", "to": "ward", "arrives": 1000, "first": 1, "count": 1}],
}
TWO = {"ann": {"type": "cart", "at": "home"}, "bob": {"type": "cart", "at": "gate"}}


def delay_of(controller, **changes):
    """Return the lead time of the order of a run, and the parts of it that are not zero, in seconds."""
    with simulation({**WORLD, **changes}) as run:
        run.play(controller, duration=600)
        lines = run.trace.splitlines(keepends=True)
    (order,) = report_of(of_trace(lambda: lines)[0]).orders
    return order.lead_time, {part: round(seconds, 6) for part, seconds in order.delay if seconds}


async def serve(client, *, pause=0.0, charge=False):
    """Bring the meal with ann, which sets out 3 s after the order."""
    async for order in client.events("order_placed"):
        ann = client.robot("ann")
        await asyncio.sleep(3.0)
        if charge:
            await ann.dock("charger")
            await ann.wait_until_charged(1.0)
        await ann.navigate_to("shelf")
        await asyncio.sleep(pause)
        await ann.pickup(order["item"])
        await ann.navigate_to("ward")
        await ann.place(order["item"])
        return


def test_a_robot_sets_out_late_drives_and_works():
    """It drives 8 m and 4 m, and handles the item for 2 s twice."""
    assert (19.0, {"assignment": 3.0, "travel": 12.0, "handling": 4.0}) == delay_of(serve)


def test_a_controller_that_pauses_delays_the_order():
    """Also while the robot stands at the item."""
    lead, parts = delay_of(partial(serve, pause=5.0))

    assert (24.0, 8.0) == (lead, parts["assignment"])


def test_another_robot_in_the_way_is_traffic():
    """Bob stands at the gate until 20 s, and leaves by the shelf for the bay."""

    async def meet(client):
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(serve(client))
            await asyncio.sleep(20.0)
            await client.robot("bob").navigate_to("bay")

    assert (35.0, {"assignment": 3.0, "travel": 12.0, "handling": 4.0, "traffic": 16.0}) == delay_of(meet, robots=TWO)


def test_a_closed_lane_is_a_fault():
    """Ann comes to the gate at 8 s."""
    closed = [{"type": "lane_closed", "lane": ["gate", "shelf"], "at": 5, "until": 28}]
    lead, parts = delay_of(serve, faults=closed)

    assert (39.0, 20.0) == (lead, parts["faults"])


def test_a_breakdown_is_a_fault():
    """In the middle of a lane; the goal fails, and the controller tries again after 10 s."""

    async def try_again(client):
        try:
            await serve(client)
        except GoalFailed:
            await asyncio.sleep(10.0)
            ann = client.robot("ann")
            for place, act in (("shelf", ann.pickup), ("ward", ann.place)):
                await ann.navigate_to(place)
                await act("meal_1")

    lead, parts = delay_of(try_again, faults=[{"type": "breakdown", "robot": "ann", "at": 6, "until": 13}])

    assert (29.0, {"assignment": 6.0, "travel": 12.0, "handling": 4.0, "faults": 7.0}) == (lead, parts)


def test_a_robot_that_queues_and_charges_delays_its_order():
    """Bob leaves the dock at 20 s; ann has used 8 of 100 J until it is docked, and charges 0.8 s."""
    robots = {"ann": TWO["ann"], "bob": {"type": "cart", "at": "charger"}}

    async def charge(client):
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(serve(client, charge=True))
            await asyncio.sleep(20.0)
            await client.robot("bob").navigate_to("bay")

    lead, parts = delay_of(charge, robots=robots)

    assert 16.0 == parts["queue"]
    assert parts["charging"] > 0
    assert lead == round(sum(parts.values()), 6)


NAMES = st.sampled_from(["ann", "bob"])
MOMENT = st.integers(0, 1_000)


@st.composite
def tracks(draw):
    """Return the spans of a robot's states, with gaps, and its waits, which do not overlap."""
    times = sorted(draw(st.sets(MOMENT, min_size=2, max_size=12)))
    spans = [(*pair, draw(st.sampled_from(STATES))) for pair in pairwise(times) if draw(st.integers(0, 4))]
    waits = []
    for began, ended in pairwise(sorted(draw(st.sets(MOMENT, max_size=8)))):
        kind = draw(st.sampled_from(["way", "dock"]))
        waits.append(WaitRecord("", began, kind, ended=ended, closed=draw(st.booleans())))
    return spans, waits


@examples(300)
@given(data=st.data())
def test_the_parts_add_up_to_the_lead_time(data):
    """Exactly, in nanoseconds, whatever happens to the item, and none is negative."""
    timeline = Timeline()
    log = RobotLog(timeline)
    delays = Delays(timeline, log)
    for name in ("ann", "bob"):
        log.add(name, "cart")
        log.tracks[name].spans, log.tracks[name].stood = data.draw(tracks())
    timeline.begin(0)
    for at in accumulate(data.draw(st.lists(st.integers(0, 200), max_size=10))):
        robot, item = data.draw(NAMES), data.draw(st.sampled_from(["meal", "soup"]))
        event = data.draw(
            st.sampled_from(
                [ItemPicked(robot, item), ItemPlaced(robot, item, (0, 0)), ItemDropped(robot, item, (0, 0))]
            )
        )
        timeline.take(Occurrence(at, event))
    placed, ended = sorted((data.draw(MOMENT), data.draw(MOMENT)))
    order = Order("meal_1", "meal", "shelf", "ward", 0, placed, None, ended=ended, state="delivered")
    parts = delays.of(order)

    assert ended - placed == sum(parts.values())
    assert [*PARTS] == [*parts]
    assert all(time >= 0 for time in parts.values())


def test_an_order_that_is_not_delivered_has_no_parts():
    delays = Delays(Timeline(), RobotLog(Timeline()))

    assert delays.of(Order("meal_1", "meal", "shelf", "ward", 0, 0, None, state="carried")) is None


def test_the_page_shows_the_parts_of_each_order():
    with simulation(WORLD) as run:
        run.play(serve, duration=600)
        lines = run.trace.splitlines(keepends=True)
    story = of_trace(lambda: lines)[0]
    page = page_of(report_of(story), story.definition)

    assert "It consists of travel 63.2 %, handling 21.1 %, assignment 15.8 %." in page
    assert '<i class="driving" style="width:63.16%" title="travel 12.0 s">' in page
