"""Lifts: the queue for the cabin, the duration of a ride, and calls."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.actions import registry as actions
from hmrsim.interfaces.simulation_interfaces import ResetSimulation, Result
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.protocol.topics import Topic
from hmrsim.traffic.policies import registry as policies
from hmrsim.world.model import World
from tests import simulation
from tests.profiles import examples
from tests.simulation import simulate

EVE, BOB, ANN = "e" * 32, "b" * 32, "a" * 32
IDS = {"eve": EVE, "bob": BOB, "ann": ANN}
SPOTS = {"ground": (0.0, 0.0), "first": (100.0, 0.0), "second": (200.0, 0.0), "yard": (-4.0, 0.0), "ward": (104.0, 0.0)}


def go(spot, *, robot="eve", goal_id=None):
    return simulation.go(*SPOTS[spot], goal_id or IDS[robot], robot)


def world(robots=None, *, base=None, **lift):
    """Return three levels side by side with a stop each: 5 s per level, and 2 s for the doors each time."""
    robots = robots or {"eve": "yard"}
    return {
        "waypoints": {name: [*point] for name, point in SPOTS.items()},
        "lanes": [["yard", "ground"], ["first", "ward"]],
        "lifts": {"lift": {"stops": ["ground", "first", "second"], **lift}},
        "robots": {name: {"at": at, "base": base or {}} for name, at in robots.items()},
        "traffic": {"policy": "reserve"},
    }


def tags(run, name="lift"):
    return run.ask("get_entity_info", {"entity": name}).info.tags


def place(run, robot="eve"):
    return run.simulator.robots[robot].pose().point


def call(run, stop, name="lift"):
    return run.ask("call_lift", {"name": name, "stop": stop}).result


class TestRides:
    def test_a_ride_takes_the_time_of_its_levels(self):
        """The distance in the drawing makes no difference."""
        log = simulate(world())((0.0, go("second")))

        assert (18.0, "SUCCEEDED") == log.changes(EVE)[-1]
        assert [] == log.happened("waiting")

    def test_a_ride_takes_every_robot_the_same_time(self):
        log = simulate(world(base={"speed": 2.0, "acceleration": 1.0, "turning_rate": 1.0}))((0.0, go("first")))

        assert (13.0, "SUCCEEDED") == log.changes(EVE)[-1]

    def test_a_robot_stays_at_its_stop_until_it_gets_out(self):
        run = simulate(world())
        run((0.0, go("first")), until=8.0)

        assert (0.0, 0.0) == place(run)
        assert (0.0, 0.0) == run.simulator.robots["eve"].velocity()
        run.simulator.run()
        assert (100.0, 0.0) == place(run)

    def test_a_ride_has_no_remaining_distance(self):
        run = simulate(world())
        run((0.0, go("ward")), until=1.0)
        progress = run.simulator.robots["eve"].motion.progress()

        assert (7.0, 16.0) == (progress.length, progress.seconds)

    def test_events_report_departure_and_arrival(self):
        log = simulate(world())((0.0, go("first")))

        departed = {"lift": "lift", "from": "ground", "to": "first", "robots": ["eve"]}
        assert [(4.0, departed)] == log.happened("lift_departed")
        assert [(13.0, {"lift": "lift", "stop": "first", "robots": ["eve"]})] == log.happened("lift_arrived")

    def test_a_lift_is_an_entity(self):
        run = simulate(world())
        before = tags(run)
        run((0.0, go("first")), until=5.0)

        assert ["lift", "at:ground"] == before
        assert ["lift", "at:ground", "moving", "to:first", "carries:eve"] == tags(run)
        run.simulator.run()
        state = run.ask("get_entity_state", {"entity": "lift"}).state
        assert 100.0 == state.pose.position.x

    def test_a_path_from_stop_to_stop_is_a_ride(self):
        """An external planner can therefore make robots take lifts."""
        poses = [{"pose": {"position": {"x": x}}} for x in (0.0, 100.0, 104.0)]
        goal = actions()["follow_path"].goal.model_validate({"path": {"poses": poses}})
        log = simulate(world())((0.0, SendGoal("eve", "follow_path", goal, EVE)))

        assert (17.0, "SUCCEEDED") == log.changes(EVE)[-1]

    def test_a_slower_robot_takes_the_lift_where_a_faster_one_drives(self):
        """The way around is 120 m, and the ride takes 69 s."""
        plan = world(travel_time=65.0) | {"traffic": {"policy": "free"}}
        plan["waypoints"] = {**plan["waypoints"], "ramp": [50, 33.166247903554]}
        plan["lanes"] = [*plan["lanes"], ["ground", "ramp"], ["ramp", "first"]]
        graph = WaypointGraph(World.model_validate(plan))

        slow, fast = (graph.plan(SPOTS["ground"], SPOTS["first"], speed) for speed in (1.0, 2.0))

        assert [("ground", "first")] == [leg.lane for leg in slow.legs]
        assert [("ground", "ramp"), ("ramp", "first")] == [leg.lane for leg in fast.legs]


class TestCalls:
    def test_a_robot_waits_for_the_cabin(self):
        log = simulate(world(at="first"))((0.0, go("first")))

        waiting = {"robot": "eve", "at": [0.0, 0.0], "lane": ["ground", "first"], "why": "lift is at first"}
        assert [(4.0, waiting), (4.0, waiting | {"why": "lift is on its way"})] == log.happened("waiting")
        assert [(4.0, {"lift": "lift", "stop": "ground", "by": "eve"})] == log.happened("lift_called")
        assert (22.0, "SUCCEEDED") == log.changes(EVE)[-1]

    def test_the_robot_that_calls_first_rides_first(self):
        robots = {"eve": "ground", "bob": "ward", "ann": "second"}
        log = simulate(world(robots))(
            (0.0, go("first")), (0.0, go("ground", robot="ann")), (0.0, go("yard", robot="bob"))
        )

        # Eve: up at 9. The cabin at ann's at 18, down at 32. At bob's at 41, down at 50, and 4 m more.
        assert [9.0, 32.0, 54.0] == [log.changes(IDS[name])[-1][0] for name in ("eve", "ann", "bob")]

    def test_simultaneous_calls_are_served_in_order_of_names(self):
        robots = ("ann", "eve")
        run = simulate(world({"eve": "ground", "ann": "second"}, at="first"))
        for robot in robots:
            run.simulator.submit(go("first", robot=robot))
        log = run()

        # The cabin at ann's at 9, back with her at 18; at eve's at 27, and up with her at 36.
        assert [18.0, 36.0] == [log.changes(IDS[name])[-1][0] for name in robots]

    @pytest.mark.parametrize("policy", policies())
    def test_a_robot_that_gets_out_passes_one_that_gets_in(self, policy):
        """Waypoints take one robot, but stops any number."""
        plan = world({"eve": "ground", "bob": "first"}) | {"traffic": {"policy": policy}}
        log = simulate(plan)((0.0, go("first")), (0.0, go("ground", robot="bob")))

        assert [(9.0, "SUCCEEDED"), (18.0, "SUCCEEDED")] == [log.changes(goal)[-1] for goal in (EVE, BOB)]

    @pytest.mark.parametrize(("capacity", "ends"), [(1, [9.0, 27.0]), (2, [9.0, 9.0])])
    def test_a_cabin_takes_robots_up_to_its_capacity(self, capacity, ends):
        run = simulate(world({"eve": "ground", "bob": "ground"}, capacity=capacity))
        log = run((0.0, go("first")), (0.0, go("first", robot="bob")))

        assert ends == [log.changes(goal)[-1][0] for goal in (EVE, BOB)]

    def test_a_robot_that_gave_up_is_not_fetched(self):
        run = simulate(world({"eve": "ground", "bob": "second"}))
        run((0.0, go("second")), (1.0, go("first", robot="bob")), (2.0, CancelGoal("bob", "navigate_to_pose")))

        assert [14.0] == [time for time, _ in run.log.happened("lift_arrived")]

    def test_the_service_calls_the_cabin(self):
        run = simulate(world())
        answer = call(run, "second")
        run.simulator.run()

        assert Result.RESULT_OK == answer.result
        assert [(14.0, {"lift": "lift", "stop": "second", "robots": []})] == run.log.happened("lift_arrived")

    def test_a_call_of_the_service_queues_with_robots(self):
        run = simulate(world({"eve": "ground", "bob": "first"}))
        run((0.0, go("first")), until=1.0)
        call(run, "second")
        log = run((2.0, go("ground", robot="bob")))

        assert [(9.0, "first"), (18.0, "second"), (27.0, "first"), (36.0, "ground")] == [
            (time, fields["stop"]) for time, fields in log.happened("lift_arrived")
        ]

    @pytest.mark.parametrize(
        ("name", "stop", "text"),
        [
            ("lfit", "ground", "no lift 'lfit'; did you mean 'lift'?"),
            ("lift", "yard", "'lift' has no stop 'yard'; there are ground, first, second"),
        ],
    )
    def test_unknown_lifts_and_stops_are_rejected(self, name, stop, text):
        answer = call(simulate(world()), stop, name)

        assert (Result.RESULT_NOT_FOUND, text) == (answer.result, answer.error_message)


class TestInterruptedRides:
    def test_a_canceled_robot_gets_out_where_it_got_in(self):
        run = simulate(world({"eve": "ground"}))
        run((0.0, go("first")), (3.0, CancelGoal("eve", "navigate_to_pose")))
        here = place(run)
        log = run((3.0, go("first", goal_id=BOB)))

        assert (0.0, 0.0) == here
        assert (15.0, "SUCCEEDED") == log.changes(BOB)[-1]
        assert [6.0, 15.0] == [time for time, _ in log.happened("lift_arrived")]

    def test_a_robot_that_is_slowed_down_rides_as_fast(self):
        run = simulate(world({"eve": "ground"}))
        run((0.0, go("ward")), until=3.0)
        robot = run.simulator.robots["eve"]
        robot.scale_speed(0.5)
        run.simulator.run()

        assert (17.0, "SUCCEEDED") == run.log.changes(EVE)[-1]
        assert [9.0] == [time for time, _ in run.log.happened("lift_arrived")]

    def test_a_deleted_robot_leaves_the_cabin(self):
        run = simulate(world({"eve": "ground", "bob": "ground"}))
        run((0.0, go("first")), (1.0, go("first", robot="bob")), until=3.0)
        run.ask("delete_entity", {"entity": "eve"})
        run.simulator.run()

        assert (15.0, "SUCCEEDED") == run.log.changes(BOB)[-1]


class TestReset:
    def test_a_reset_restores_the_cabin(self):
        run = simulate(world(at="first"))
        run((0.0, go("second")), until=6.0)
        run.ask("reset_simulation")

        assert ["lift", "at:first"] == tags(run)
        assert (22.0, "SUCCEEDED") == run((0.0, go("first", goal_id=BOB))).changes(BOB)[-1]

    def test_a_reset_of_time_completes_the_ride(self):
        run = simulate(world())
        call(run, "first")
        run.simulator.advance(2.0)
        run.ask("reset_simulation", {"scope": ResetSimulation.Request.SCOPE_TIME})

        assert ["lift", "at:first"] == tags(run)
        assert Result.RESULT_OK == call(run, "second").result
        run.simulator.run()
        assert ["lift", "at:second"] == tags(run)


@examples(60)
@given(
    goals=st.lists(
        st.tuples(st.sampled_from([*IDS]), st.sampled_from([*SPOTS]), st.integers(0, 6), st.booleans()), max_size=8
    ),
    policy=st.sampled_from([*policies()]),
    capacity=st.sampled_from([1, 2]),
)
def test_the_cabin_is_never_overfull_and_every_goal_ends(goals, policy, capacity):
    plan = world({"eve": "yard", "bob": "ward", "ann": "second"}, capacity=capacity) | {"traffic": {"policy": policy}}
    run = simulate(plan, topics=frozenset({Topic.EVENTS}))
    for number, (robot, spot, seconds, gives_up) in enumerate(goals):
        run.simulator.submit(go(spot, robot=robot, goal_id=f"{number + 1:032x}"))
        run.simulator.advance(run.simulator.now + seconds)
        assert capacity >= sum(tag.startswith("carries:") for tag in tags(run))
        if gives_up:
            run.simulator.submit(CancelGoal(robot, "navigate_to_pose"))
    run.simulator.run()

    ends = [run.log.changes(f"{number + 1:032x}")[-1][1] for number in range(len(goals))]
    assert {"SUCCEEDED", "CANCELED", "ABORTED"} >= {*ends}
    assert all(len(fields["robots"]) <= capacity for _, fields in run.log.happened("lift_arrived"))
    assert "moving" not in tags(run)
