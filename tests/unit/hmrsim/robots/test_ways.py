"""One event for a whole route has the same effects as one event per lane, and looking changes nothing."""

from __future__ import annotations

import json

from hypothesis import given
from hypothesis import strategies as st

from hmrsim.events.robots import MotionBegan
from hmrsim.geometry import distance
from hmrsim.navigation.motion import Trapezoid
from hmrsim.protocol.outputs import EventStamped
from hmrsim.protocol.topics import Topic
from tests.profiles import examples
from tests.simulation import go, simulate

SIDE = 4
LANES = [
    *([f"w{x}{y}", f"w{x + 1}{y}"] for x in range(SIDE - 1) for y in range(SIDE)),
    *([f"w{x}{y}", f"w{x}{y + 1}"] for x in range(SIDE) for y in range(SIDE - 1)),
]
FREE = {"policy": "free"}
DECIDED = {"policy": "reserve", "waypoint_capacity": None, "lane_capacity": None}
"""Under this policy nothing is ever in the way of a robot, but it asks before each lane."""

places = st.tuples(st.integers(0, SIDE - 1), st.integers(0, SIDE - 1))
times = st.floats(0.01, 60.0).map(lambda at: round(at, 7))
goals = st.tuples(times, st.just("go"), st.sampled_from(("ann", "bob")), places)
closures = st.tuples(times, st.just("lane_closed"), st.sampled_from(LANES), st.floats(1.0, 20.0))
breakdowns = st.tuples(times, st.just("breakdown"), st.sampled_from(("ann", "bob")), st.floats(1.0, 20.0))
slips = st.tuples(times, st.just("slip"), st.sampled_from(("ann", "bob")), st.floats(0.2, 0.9))
orders = st.lists(st.one_of(goals, goals, closures, breakdowns, slips), max_size=12).map(sorted)
bases = st.sampled_from(({}, {"turning_rate": 1.0}, {"acceleration": 0.4, "turning_rate": 0.7}))


def world(traffic, base):
    return {
        "waypoints": {f"w{x}{y}": [3.0 * x + 0.1 * y, 4.0 * y] for x in range(SIDE) for y in range(SIDE)},
        "lanes": LANES,
        "robot_types": {"cart": {"base": {"speed": 1.3, **base}}},
        "robots": {"ann": {"type": "cart", "at": "w00"}, "bob": {"type": "cart", "at": "w33"}},
        "traffic": traffic,
    }


def run_of(traffic, base, orders, *, looks=(), topics=frozenset({Topic.EVENTS})):
    """Return a run of a world with these orders, in which robots are looked at at some times."""
    run = simulate(world(traffic, base), topics=topics, traced=True)
    todo = sorted([*((at, order) for at, *order in orders), *((at, None) for at in looks)], key=lambda one: one[0])
    for at, order in todo:
        run.simulator.advance(at)
        if order is None:
            for robot in run.simulator.robots.values():
                _ = robot.motion.progress(), robot.velocity(), robot.legs_ahead, robot.sets_out, robot.motion.to_json()
        else:
            give(run, order)
    run.simulator.advance(100.0)
    run.simulator.stop()
    return run


def give(run, order):
    """Send a goal or inject a fault."""
    what, whom, more = order
    if what == "go":
        run.simulator.submit(go(3.0 * more[0] + 0.1 * more[1], 4.0 * more[1], None, whom))
        return
    fields = {"lane": whom, "duration": more} if what == "lane_closed" else {"robot": whom}
    if what == "breakdown":
        fields["duration"] = more
    if what == "slip":
        fields |= {"factor": more, "duration": 5.0}
    run.ask("inject_fault", {"type": what, "settings": json.dumps(fields)})


@examples(60)
@given(bases, orders)
def test_whole_routes_equal_lane_by_lane_runs(base, orders):
    """There are closures, breakdowns, slips and new goals, and only the header differs."""
    assert run_of(FREE, base, orders).lines()[1:] == run_of(DECIDED, base, orders).lines()[1:]


@examples(40)
@given(bases, orders, st.lists(times, max_size=20))
def test_looking_and_listening_to_motions_changes_nothing(base, orders, looks):
    quiet = run_of(FREE, base, orders, topics=frozenset()).lines()

    assert quiet == run_of(FREE, base, orders, looks=looks, topics=frozenset(Topic)).lines()


@examples(40)
@given(bases, orders, st.lists(times, min_size=1, max_size=10))
def test_a_watcher_can_compute_where_a_robot_is(base, orders, looks):
    run = simulate(world(FREE, base), topics=frozenset(Topic), traced=True)
    todo = sorted([*((at, order) for at, *order in orders), *((at, None) for at in looks)], key=lambda one: one[0])
    for at, order in todo:
        run.simulator.advance(at)
        if order is not None:
            give(run, order)
            continue
        for name, robot in run.simulator.robots.items():
            assert distance(robot.pose().point, told(run, name, run.simulator.now)) < 1e-6, (name, at)


def told(run, name, now):
    """Return a robot's position by its last events."""
    told = [
        (at, output.event)
        for at, output in run.log.events
        if isinstance(output, EventStamped) and getattr(output.event, "robot", "") == name
    ]
    placed = [(at, event) for at, event in told if event.kind in ("motion", "stopped", "waiting")]
    if not placed:
        return world(FREE, {})["waypoints"]["w00" if name == "ann" else "w33"]
    at, event = placed[-1]
    if not isinstance(event, MotionBegan):
        return event.at
    fields = event.to_json()
    for each in (fields, *fields.get("then", ())):
        if now < at + each["duration"]:
            return between(each, now - at)
        at += each["duration"]
    return each["to"][:2]


def between(motion, elapsed):
    """Return the position a number of seconds after the start of a motion."""
    (ax, ay, _), (bx, by, _) = motion["from"], motion["to"]
    share = elapsed / motion["duration"]
    if "profile" in motion:
        length, speed, acceleration, before = motion["profile"]
        profile = Trapezoid(length, speed, acceleration)
        driven = profile.driven(profile.time(before) + elapsed) - before
        share = driven / max(1e-12, ((bx - ax) ** 2 + (by - ay) ** 2) ** 0.5)
    return ax + (bx - ax) * share, ay + (by - ay) * share
