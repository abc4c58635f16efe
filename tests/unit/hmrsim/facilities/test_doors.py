"""Doors: which robots wait for them, which may pass, and when they close."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.actions import registry as actions
from hmrsim.geometry import SAME_PLACE, distance, foot
from hmrsim.interfaces.simulation_interfaces import ResetSimulation, Result
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.traffic.policies import registry as policies
from tests import simulation
from tests.profiles import examples
from tests.simulation import at, send, simulate

EVE, BOB, ANN = "e" * 32, "b" * 32, "a" * 32
IDS = {"eve": EVE, "bob": BOB, "ann": ANN}


def go(x, y=0.0, *, robot="eve", goal_id=None):
    return simulation.go(x, y, goal_id or IDS[robot], robot)


def follow(*points, robot="eve"):
    return send("follow_path", IDS[robot], robot, path={"poses": [at(*point) for point in points]})


def world(*, robots=("eve",), around=False, **gate):
    door = {"at": [[5, -1], [5, 1]], **gate}
    waypoints = {"west": [0, 0], "east": [10, 0]} | ({"south": [5, -math.sqrt(75)]} if around else {})
    lanes = [["west", "east"], *([["west", "south"], ["south", "east"]] if around else [])]
    return {
        "waypoints": waypoints,
        "lanes": lanes,
        "doors": {"gate": door},
        "robots": {name: {"at": "west"} for name in robots},
    }


def doors_of(log):
    kinds = ("door_opening", "door_opened", "door_closed")
    return sorted((time, kind) for kind in kinds for time, _ in log.happened(kind))


def tell(run, state, name="gate"):
    """Send a request to a door; return the result."""
    return run.ask("set_door_state", {"name": name, "state": state}).result


def tags(run, name="gate"):
    return run.ask("get_entity_info", {"entity": name}).info.tags


class TestOpening:
    def test_a_robot_waits_until_the_door_is_open(self):
        """The door takes 2 s to open, and the lane of 10 m takes 10 s."""
        log = simulate(world())((0.0, go(10.0)))

        assert [(0.0, "ACCEPTED"), (0.0, "EXECUTING"), (12.0, "SUCCEEDED")] == log.changes(EVE)
        waiting = {"robot": "eve", "at": [0.0, 0.0], "lane": ["west", "east"], "why": "gate is opening"}
        assert [(0.0, waiting)] == log.happened("waiting")
        assert [(2.0, {"door": "gate", "by": "eve"})] == log.happened("door_opened")

    def test_it_closes_behind_the_robot(self):
        log = simulate(world())((0.0, go(10.0)), until=20.0)

        assert [(0.0, "door_opening"), (2.0, "door_opened"), (15.0, "door_closed")] == doors_of(log)

    def test_a_simulation_does_not_wait_for_a_door_to_close(self):
        run = simulate(world())
        run((0.0, go(10.0)))

        assert 12.0 == run.simulator.now
        assert ["door", "open"] == tags(run)

    def test_without_an_opening_time_no_robot_waits(self):
        log = simulate(world(opening_time=0))((0.0, go(10.0)))

        assert (10.0, "SUCCEEDED") == log.changes(EVE)[-1]
        assert [] == log.happened("waiting")

    def test_an_open_door_lets_the_next_robot_through(self):
        """The second robot arrives when the door is about to close, and delays that."""
        log = simulate(world(robots=["eve", "bob"]))((0.0, go(10.0)), (14.5, go(10.0, robot="bob")), until=40.0)

        assert (24.5, "SUCCEEDED") == log.changes(BOB)[-1]
        assert [(0.0, "door_opening"), (2.0, "door_opened"), (27.5, "door_closed")] == doors_of(log)

    def test_two_doors_on_one_lane_open_together(self):
        """The slower door determines the wait, and the other must not close in the meantime."""
        slow = {"at": [[7, -1], [7, 1]], "opening_time": 4}
        both = world(stays_open=0) | {"doors": {"gate": {"at": [[5, -1], [5, 1]], "stays_open": 0}, "slow": slow}}

        assert (14.0, "SUCCEEDED") == simulate(both)((0.0, go(10.0))).changes(EVE)[-1]

    @pytest.mark.parametrize(("base", "x"), [({"flies": True}, 10.0), ({}, 4.0)], ids=["flying", "before the door"])
    def test_a_robot_that_does_not_pass_the_door_does_not_open_it(self, base, x):
        log = simulate(world() | {"robots": {"eve": {"at": "west", "base": base}}})((0.0, go(x)))

        assert (x, "SUCCEEDED") == log.changes(EVE)[-1]
        assert [] == doors_of(log)


class TestAccess:
    @pytest.mark.parametrize("opens_for", [["eve"], ["carrier"]])
    def test_a_door_opens_for_a_name_or_a_type(self, opens_for):
        log = simulate(world(opens_for=opens_for))((0.0, go(10.0)))

        assert (12.0, "SUCCEEDED") == log.changes(EVE)[-1]

    @pytest.mark.parametrize("opens_for", [["bob"], []])
    def test_an_excluded_robot_takes_another_route(self, opens_for):
        log = simulate(world(around=True, robots=["eve", "bob"], opens_for=opens_for))((0.0, go(10.0)))

        assert (20.0, "SUCCEEDED") == (round(log.changes(EVE)[-1][0], 6), log.changes(EVE)[-1][1])
        assert [] == log.happened("waiting")

    def test_without_another_route_the_error_names_the_door(self):
        log = simulate(world(opens_for=["bob"], robots=["eve", "bob"]))((0.0, go(10.0)))

        result = log.result(EVE)
        assert 208 == result.error_code
        why = "east-west may not be driven by eve, west-east may not be driven by eve"
        assert f"no route from west to east; {why}" == result.error_msg

    def test_an_excluded_robot_may_pass_an_open_door(self):
        run = simulate(world(around=True, opens_for=[]))
        tell(run, "open")
        log = run((2.0, go(10.0)))

        assert (12.0, "SUCCEEDED") == log.changes(EVE)[-1]

    def test_a_closing_door_sends_an_excluded_robot_around(self):
        plan = world(around=True, opens_for=[], open=True)
        plan["waypoints"]["start"] = [-5, 0]
        plan["lanes"].append(["start", "west"])
        plan["robots"] = {"eve": {"at": "start"}}
        run = simulate(plan)
        run((0.0, go(10.0)), until=3.0)
        tell(run, "closed")
        run.simulator.run()

        assert (25.0, "SUCCEEDED") == (round(run.log.changes(EVE)[-1][0], 6), run.log.changes(EVE)[-1][1])


class TestOrders:
    def test_a_door_that_a_client_opened_stays_open(self):
        run = simulate(world())
        tell(run, "open")
        run.simulator.advance(100.0)

        assert [(0.0, "door_opening"), (2.0, "door_opened")] == doors_of(run.log)
        assert [(2.0, {"door": "gate"})] == run.log.happened("door_opened")

    @pytest.mark.parametrize(("begins_open", "states"), [(True, ["closed"]), (False, ["locked", "closed"])])
    def test_a_closed_door_opens_for_robots(self, begins_open, states):
        run = simulate(world(open=begins_open))
        for state in states:
            tell(run, state)

        assert (12.0, "SUCCEEDED") == run((0.0, go(10.0))).changes(EVE)[-1]

    def test_a_locked_door_opens_for_no_robot(self):
        run = simulate(world(around=True))
        tell(run, "locked")
        log = run((0.0, go(10.0)))

        assert 20.0 == round(log.changes(EVE)[-1][0], 6)
        assert [
            (0.0, {"lane": ["east", "west"], "why": "gate is locked"}),
            (0.0, {"lane": ["west", "east"], "why": "gate is locked"}),
        ] == log.happened("lane_closed")
        assert ["door", "closed", "locked"] == tags(run)

    @pytest.mark.parametrize(("state", "tag"), [("locked", "locked"), (None, "jammed")])
    def test_a_door_that_stays_closed_sends_a_waiting_robot_around(self, state, tag):
        run = simulate(world(around=True))
        run((0.0, go(10.0)), until=1.0)
        tell(run, state) if state else run.simulator.roster.fixtures["gate"].jam()
        run.simulator.run()

        assert 21.0 == round(run.log.changes(EVE)[-1][0], 6)
        assert [(0.0, "door_opening")] == doors_of(run.log)
        assert ["door", "closed", tag] == tags(run)

    def test_a_door_can_not_be_closed_on_a_robot(self):
        run = simulate(world(open=True))
        run((0.0, go(10.0)), until=3.0)

        answer = tell(run, "closed")
        assert (Result.RESULT_INCORRECT_STATE, "gate can't close: eve is in it") == (
            answer.result,
            answer.error_message,
        )

    def test_a_door_can_be_closed_behind_a_robot(self):
        run = simulate(world(open=True))
        run((0.0, go(10.0)), until=6.0)

        assert Result.RESULT_OK == tell(run, "locked").result
        assert [(6.0, "door_closed")] == doors_of(run.log)

    @pytest.mark.parametrize(
        ("name", "state", "code", "text"),
        [
            ("gaet", "open", Result.RESULT_NOT_FOUND, "no door 'gaet'; did you mean 'gate'?"),
            ("eve", "open", Result.RESULT_NOT_FOUND, "no door 'eve'; there are gate"),
            ("gate", "opn", Result.RESULT_OPERATION_FAILED, "no door state 'opn'; did you mean 'open'?"),
        ],
    )
    def test_invalid_requests_are_rejected(self, name, state, code, text):
        answer = tell(simulate(world()), state, name)

        assert (code, text) == (answer.result, answer.error_message)


class TestJams:
    def test_without_another_route_a_robot_waits_for_the_jam_to_end(self):
        run = simulate(world())
        run((0.0, go(10.0)), until=1.0)
        gate = run.simulator.roster.fixtures["gate"]
        gate.jam()
        run.simulator.advance(30.0)
        gate.free()
        run.simulator.run()

        assert (42.0, "SUCCEEDED") == run.log.changes(EVE)[-1]

    def test_a_robot_gives_up_after_its_patience(self):
        run = simulate(world())
        run((0.0, go(10.0)), until=1.0)
        run.simulator.roster.fixtures["gate"].jam()
        run.simulator.run()

        assert (60.0, "ABORTED") == run.log.changes(EVE)[-1]
        text = "blocked for 60 s: eve has waited at west since 0 s: west-east is closed: gate is jammed"
        assert run.log.result(EVE).error_msg.startswith(
            f"{text}; what would help: end the fault: `hmrsim fault clear door_jammed`"
        )

    def test_a_door_that_jams_open_stays_open(self):
        run = simulate(world())
        gate = run.simulator.roster.fixtures["gate"]
        run((0.0, go(10.0)), until=13.0)
        gate.jam()
        gate.jam()
        run.simulator.advance(50.0)
        gate.free()
        run.simulator.advance(60.0)
        gate.free()
        run.simulator.advance(70.0)

        assert (63.0, "door_closed") == doors_of(run.log)[-1]

    def test_a_jammed_door_rejects_requests(self):
        run = simulate(world())
        run.simulator.roster.fixtures["gate"].jam()

        assert "gate is jammed, and stays closed" == tell(run, "open").error_message

    def test_an_earlier_request_is_executed_after_the_jam(self):
        run = simulate(world())
        gate = run.simulator.roster.fixtures["gate"]
        tell(run, "open")
        run.simulator.advance(1.0)
        gate.jam()
        run.simulator.advance(10.0)
        gate.free()
        run.simulator.advance(20.0)

        assert (12.0, "door_opened") == doors_of(run.log)[-1]


class TestStanding:
    def test_a_door_does_not_close_on_a_standing_robot(self):
        wide = world() | {"robots": {"eve": {"at": "west", "base": {"radius": 0.3}}}}
        run = simulate(wide)
        run((0.0, go(10.0)), (7.2, CancelGoal("eve", "navigate_to_pose")), until=50.0)
        before = doors_of(run.log)
        run((50.0, go(10.0, goal_id=BOB)), until=80.0)

        assert [(0.0, "door_opening"), (2.0, "door_opened")] == before
        assert (54.8, "SUCCEEDED") == run.log.changes(BOB)[-1]
        assert "door_closed" == doors_of(run.log)[-1][1]

    def test_a_robot_that_stopped_before_a_door_waits_again(self):
        run = simulate(world())
        run((0.0, go(10.0)), (6.0, CancelGoal("eve", "navigate_to_pose")), until=20.0)
        log = run((20.0, go(10.0, goal_id=BOB)))

        assert (9.0, "door_closed") == doors_of(log)[2]
        assert (28.0, "SUCCEEDED") == log.changes(BOB)[-1]

    def test_a_robot_before_a_locked_door_in_the_middle_of_its_lane_waits(self):
        """On its lane there is no other route, even if it may leave the lane."""
        run = simulate(world(around=True))
        run((0.0, go(4.0)))
        tell(run, "locked")
        log = run((4.0, go(10.0, goal_id=BOB)))

        assert [] == log.happened("rerouted")
        assert (64.0, "ABORTED") == log.changes(BOB)[-1]


class TestOffTheLanes:
    @pytest.mark.parametrize("is_open", [True, False])
    def test_off_the_lanes_a_closed_door_is_a_wall(self, is_open):
        run = simulate(world(open=is_open))
        log = run((0.0, follow((0, 0.5), (10, 0.5))))

        error = "" if is_open else "blocked: an obstacle stands between (0, 0.5) and (10, 0.5)"
        assert error == log.result(EVE).error_msg
        assert is_open is run.simulator.graph.clear_now((0.0, 0.5), (10.0, 0.5))

    def test_a_door_that_has_closed_opens_for_a_robot_off_the_lanes(self):
        run = simulate(world(open=True))
        run((0.0, follow((0, 0.5), (10, 0.5))), until=0.2)
        tell(run, "closed")
        run.simulator.run()

        assert (12.5, "SUCCEEDED") == run.log.changes(EVE)[-1]

    def test_planned_routes_pass_doors_on_lanes_only(self):
        """An open door may be closed before the robot arrives."""
        plan = world(open=True)
        plan["robots"] = {"eve": {"at": [4, 0.5]}}
        route = simulate(plan).simulator.robots["eve"].plan_to((6.0, 0.5))

        assert [(4.0, 0.5), (4.0, 0.0), (6.0, 0.0)] == [leg.start for leg in route.legs]

    def test_no_robot_can_be_moved_into_a_closed_door(self):
        run = simulate(world())
        answer = run.ask("set_entity_state", {"entity": "eve", "state": {"pose": {"position": {"x": 5.0}}}})

        assert "(5, 0) is in a closed door" == answer.result.error_message

    @pytest.mark.parametrize(("state", "end"), [("open", 8.0), ("closed", 5.0)])
    def test_driving_on_heading_stops_before_a_closed_door(self, state, end):
        """This also holds on a lane, where walls don't count."""
        goal = actions()["drive_on_heading"].goal.model_validate({"target": {"x": 8.0}, "speed": 1.0})
        run = simulate(world(open=state == "open"))
        run((0.0, SendGoal("eve", "drive_on_heading", goal, EVE)))

        assert end == round(run.simulator.robots["eve"].pose().x, 3)


class TestReset:
    def test_a_reset_restores_a_door(self):
        run = simulate(world())
        tell(run, "locked")
        run.simulator.roster.fixtures["gate"].jam()
        run.ask("reset_simulation")

        assert ["door", "closed"] == tags(run)
        assert (12.0, "SUCCEEDED") == run((0.0, go(10.0))).changes(EVE)[-1]

    def test_a_reset_of_time_completes_the_opening(self):
        run = simulate(world())
        run((0.0, go(10.0)), until=1.0)
        run.ask("reset_simulation", {"scope": ResetSimulation.Request.SCOPE_TIME})

        assert ["door", "open"] == tags(run)
        run.simulator.advance(10.0)
        assert (3.0, "door_closed") in doors_of(run.log)

    def test_a_door_that_is_closed_at_the_start_publishes_no_event(self):
        run = simulate(world(opens_for=[]))

        assert frozenset({("west", "east"), ("east", "west")}) == run.simulator.graph.closed
        assert [] == run.log.events


STARTS = {"eve": [0, 0.5], "bob": [10, -0.5], "ann": [2, 0]}
TO_THE_OTHER_SIDE = [(0, "go", "eve", (10.0, 0.0)), (0, "go", "bob", (0.0, 0.0)), (3, "go", "ann", (7.0, -0.5))]
ANYTHING = st.tuples(
    st.integers(0, 8),
    st.sampled_from(["go", "cancel", "follow", "open", "closed", "locked", "jam", "free"]),
    st.sampled_from([*STARTS]),
    st.sampled_from([(0.0, 0.0), (10.0, 0.0), (5.0, 0.0), (4.5, 0.5), (7.0, -0.5)]),
)


@examples(100)
@given(
    orders=st.lists(ANYTHING, max_size=8),
    policy=st.sampled_from([*policies()]),
    opens_for=st.sampled_from([None, None, ["bob"], []]),
    stays_open=st.sampled_from([0, 1, None]),
)
def test_no_robot_is_ever_in_a_closed_door(orders, policy, opens_for, stays_open):
    """Robots and clients of the door do anything at any time."""
    plan = world(opens_for=opens_for, stays_open=stays_open) | {
        "robots": {name: {"at": at, "base": {"radius": 0.2}} for name, at in STARTS.items()},
        "traffic": {"policy": policy, "patience": 10.0},
    }
    run = simulate(plan, topics=frozenset())
    simulator, door = run.simulator, run.simulator.roster.fixtures["gate"]
    sides = {name: robot.pose().x < door.pose.x for name, robot in simulator.robots.items()}
    for number, (halves, what, name, point) in enumerate([*TO_THE_OTHER_SIDE, *orders, (40, "free", "", ())]):
        do_something(run, number, what, name, point)
        for _ in range(halves):
            was_open = door.is_open
            simulator.advance(simulator.now + 0.5)
            for other, robot in simulator.robots.items():
                here = robot.pose().point
                assert door.is_open or distance(here, foot(here, *door.at)) > SAME_PLACE, (other, simulator.now)
                assert was_open or door.is_open or sides[other] is (here[0] < door.pose.x), (other, simulator.now)
                sides[other] = here[0] < door.pose.x


def do_something(run, number, what, name, point):
    door = run.simulator.roster.fixtures["gate"]
    match what:
        case "go":
            run.simulator.submit(go(*point, robot=name, goal_id=f"{number + 1:032x}"))
        case "follow":
            run.simulator.submit(follow(point, robot=name)._replace(goal_id=f"{number + 1:032x}"))
        case "cancel":
            run.simulator.submit(CancelGoal(name, "navigate_to_pose"))
        case "jam":
            door.jam()
        case "free":
            door.free()
        case state:
            tell(run, state)
