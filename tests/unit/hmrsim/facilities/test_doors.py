"""Doors: which robots have to wait for them, for which they open, and when they close again."""

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
from tests.profiles import examples
from tests.simulation import simulate

EVE, BOB, ANN = "e" * 32, "b" * 32, "a" * 32
IDS = {"eve": EVE, "bob": BOB, "ann": ANN}


def go(x, y=0.0, *, robot="eve", goal_id=None):
    """Return the command to drive somewhere."""
    goal = {"pose": {"pose": {"position": {"x": x, "y": y}}}}
    goal = actions()["navigate_to_pose"].goal.model_validate(goal)
    return SendGoal(robot, "navigate_to_pose", goal, goal_id or IDS[robot])


def follow(*points, robot="eve"):
    """Return the command to drive straight from point to point."""
    poses = [{"pose": {"position": {"x": x, "y": y}}} for x, y in points]
    goal = actions()["follow_path"].goal.model_validate({"path": {"poses": poses}})
    return SendGoal(robot, "follow_path", goal, IDS[robot])


def world(*, robots=("eve",), around=False, **gate):
    """Return a lane of 10 m with a door in its middle, and a way of 20 m around it if asked; all begin in the west."""
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
    """Return what was told of doors, without who did it."""
    kinds = ("door_opening", "door_opened", "door_closed")
    return sorted((time, kind) for kind in kinds for time, _ in log.happened(kind))


def tell(run, state, name="gate"):
    """Tell a door what to be; return what came of it."""
    return run.ask("set_door_state", {"name": name, "state": state}).result


def tags(run, name="gate"):
    """Return the tags of an entity."""
    return run.ask("get_entity_info", {"entity": name}).info.tags


class TestOpening:
    """A door opens for robots that it knows."""

    def test_a_robot_waits_at_the_beginning_of_the_lane_until_the_door_is_open(self):
        """Two seconds, and then 10 m at 1 m/s."""
        log = simulate(world())((0.0, go(10.0)))

        assert [(0.0, "ACCEPTED"), (0.0, "EXECUTING"), (12.0, "SUCCEEDED")] == log.changes(EVE)
        assert [(0.0, {"robot": "eve", "at": [0.0, 0.0], "lane": ["west", "east"], "why": "gate is opening"})] == (
            log.happened("waiting")
        )

    def test_it_closes_behind_the_robot(self):
        """Three seconds after it has driven the lane, if time goes on that far."""
        log = simulate(world())((0.0, go(10.0)), until=20.0)

        assert [(0.0, "door_opening"), (2.0, "door_opened"), (15.0, "door_closed")] == doors_of(log)

    def test_time_does_not_go_on_for_a_door_to_close(self):
        """When all is done the simulation ends, and the door stands open."""
        run = simulate(world())
        run((0.0, go(10.0)))

        assert 12.0 == run.simulator.now
        assert ["door", "open"] == tags(run)

    def test_events_say_for_whom_it_opens(self):
        """By the robot's name."""
        log = simulate(world())((0.0, go(10.0)))

        assert [(2.0, {"door": "gate", "by": "eve"})] == log.happened("door_opened")

    def test_without_an_opening_time_no_robot_waits(self):
        """Ten metres take ten seconds."""
        log = simulate(world(opening_time=0))((0.0, go(10.0)))

        assert (10.0, "SUCCEEDED") == log.changes(EVE)[-1]
        assert [] == log.happened("waiting")

    def test_one_that_is_open_lets_the_next_one_through_at_once(self):
        """A second robot comes when the door is about to close, and has it stay open until 3 s after it."""
        log = simulate(world(robots=["eve", "bob"]))((0.0, go(10.0)), (14.5, go(10.0, robot="bob")), until=40.0)

        assert (24.5, "SUCCEEDED") == log.changes(BOB)[-1]
        assert [(0.0, "door_opening"), (2.0, "door_opened"), (27.5, "door_closed")] == doors_of(log)

    def test_two_doors_on_one_lane_open_together(self):
        """The slower one is what counts, though the other would have closed meanwhile."""
        slow = {"at": [[7, -1], [7, 1]], "opening_time": 4}
        both = world(stays_open=0) | {"doors": {"gate": {"at": [[5, -1], [5, 1]], "stays_open": 0}, "slow": slow}}

        assert (14.0, "SUCCEEDED") == simulate(both)((0.0, go(10.0))).changes(EVE)[-1]

    def test_a_flying_robot_does_not_ask(self):
        """It goes over it in 10 s."""
        flying = world() | {"robots": {"eve": {"at": "west", "base": {"flies": True}}}}
        log = simulate(flying)((0.0, go(10.0)))

        assert (10.0, "SUCCEEDED") == log.changes(EVE)[-1]
        assert [] == doors_of(log)

    def test_a_part_of_the_lane_on_this_side_needs_no_door(self):
        """4 m of the lane are driven at once."""
        log = simulate(world())((0.0, go(4.0)))

        assert (4.0, "SUCCEEDED") == log.changes(EVE)[-1]
        assert [] == doors_of(log)


class TestKeys:
    """Doors that open for some."""

    @pytest.mark.parametrize("opens_for", [["eve"], ["carrier"]])
    def test_it_opens_for_a_name_or_a_type(self, opens_for):
        """As if it opened for all."""
        log = simulate(world(opens_for=opens_for))((0.0, go(10.0)))

        assert (12.0, "SUCCEEDED") == log.changes(EVE)[-1]

    @pytest.mark.parametrize("opens_for", [["bob"], []])
    def test_a_robot_that_it_does_not_open_for_goes_around(self, opens_for):
        """Twenty metres, and no wait."""
        log = simulate(world(around=True, robots=["eve", "bob"], opens_for=opens_for))((0.0, go(10.0)))

        assert (20.0, "SUCCEEDED") == (round(log.changes(EVE)[-1][0], 6), log.changes(EVE)[-1][1])
        assert [] == log.happened("waiting")

    def test_without_another_way_the_goal_is_aborted_and_says_why(self):
        """The code is NO_VALID_PATH."""
        log = simulate(world(opens_for=["bob"], robots=["eve", "bob"]))((0.0, go(10.0)))

        result = log.result(EVE)
        assert 208 == result.error_code
        why = "east-west may not be driven by eve, west-east may not be driven by eve"
        assert f"no route from (0, 0) to (10, 0); {why}" == result.error_msg

    def test_it_may_pass_while_the_door_is_open(self):
        """A client has opened it."""
        run = simulate(world(around=True, opens_for=[]))
        tell(run, "open")
        log = run((2.0, go(10.0)))

        assert (12.0, "SUCCEEDED") == log.changes(EVE)[-1]

    def test_a_door_that_closes_in_front_of_it_sends_it_around(self):
        """Planned while it was open, closed when it came to the lane: 5 m to the west end, and then around."""
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
    """What doors are told through the service."""

    def test_one_that_was_opened_stays_open(self):
        """It takes its time to open, and never closes by itself."""
        run = simulate(world())
        tell(run, "open")
        run.simulator.advance(100.0)

        assert [(0.0, "door_opening"), (2.0, "door_opened")] == doors_of(run.log)
        assert [(2.0, {"door": "gate"})] == run.log.happened("door_opened")

    def test_one_that_was_closed_opens_for_robots(self):
        """It was open in the beginning."""
        run = simulate(world(open=True))
        tell(run, "closed")
        log = run((0.0, go(10.0)))

        assert (12.0, "SUCCEEDED") == log.changes(EVE)[-1]

    def test_a_locked_door_opens_for_no_robot(self):
        """Robots plan around it; the lane is closed both ways, and says why."""
        run = simulate(world(around=True))
        tell(run, "locked")
        log = run((0.0, go(10.0)))

        assert 20.0 == round(log.changes(EVE)[-1][0], 6)
        assert [
            (0.0, {"lane": ["east", "west"], "why": "gate is locked"}),
            (0.0, {"lane": ["west", "east"], "why": "gate is locked"}),
        ] == log.happened("lane_closed")
        assert ["door", "closed", "locked"] == tags(run)

    def test_one_that_is_locked_while_a_robot_waits_sends_it_around(self):
        """After one second of waiting."""
        run = simulate(world(around=True))
        run((0.0, go(10.0)), until=1.0)
        tell(run, "locked")
        run.simulator.run()

        assert 21.0 == round(run.log.changes(EVE)[-1][0], 6)
        assert [(0.0, "door_opening")] == doors_of(run.log)

    def test_it_can_be_unlocked(self):
        """Then it opens for robots again."""
        run = simulate(world())
        tell(run, "locked")
        tell(run, "closed")
        log = run((0.0, go(10.0)))

        assert (12.0, "SUCCEEDED") == log.changes(EVE)[-1]

    def test_it_can_not_be_closed_on_a_robot(self):
        """The robot on its way through is named."""
        run = simulate(world(open=True))
        run((0.0, go(10.0)), until=3.0)

        assert (Result.RESULT_INCORRECT_STATE, "gate can't close: eve is in it") == (
            (answer := tell(run, "closed")).result,
            answer.error_message,
        )

    def test_it_can_be_closed_behind_a_robot_that_is_past_it(self):
        """At 6 m, on the same lane."""
        run = simulate(world(open=True))
        run((0.0, go(10.0)), until=6.0)

        assert Result.RESULT_OK == tell(run, "locked").result
        assert [(6.0, "door_closed")] == doors_of(run.log)

    @pytest.mark.parametrize(
        ("name", "state", "code", "text"),
        [
            ("gaet", "open", Result.RESULT_NOT_FOUND, "no door 'gaet'; did you mean 'gate'?"),
            ("eve", "open", Result.RESULT_NOT_FOUND, "no door 'eve'; there are gate"),
            ("gate", "opn", Result.RESULT_OPERATION_FAILED, "no state 'opn' of a door; did you mean 'open'?"),
        ],
    )
    def test_what_makes_no_sense_is_answered(self, name, state, code, text):
        """With the value, and what would do."""
        answer = tell(simulate(world()), state, name)

        assert (code, text) == (answer.result, answer.error_message)


class TestJams:
    """A door that stays as it is."""

    def test_one_that_jams_while_it_opens_has_a_robot_go_around(self):
        """From one second on it is closed for good."""
        run = simulate(world(around=True))
        run((0.0, go(10.0)), until=1.0)
        run.simulator.roster.fixtures["gate"].jam()
        run.simulator.run()

        assert 21.0 == round(run.log.changes(EVE)[-1][0], 6)
        assert ["door", "closed", "jammed"] == tags(run)

    def test_without_another_way_the_robot_waits_until_it_is_free(self):
        """Or until its patience ends."""
        run = simulate(world())
        run((0.0, go(10.0)), until=1.0)
        gate = run.simulator.roster.fixtures["gate"]
        gate.jam()
        run.simulator.advance(30.0)
        gate.free()
        run.simulator.run()

        assert (42.0, "SUCCEEDED") == run.log.changes(EVE)[-1]

    def test_patience_ends(self):
        """After a minute, with the reason."""
        run = simulate(world())
        run((0.0, go(10.0)), until=1.0)
        run.simulator.roster.fixtures["gate"].jam()
        run.simulator.run()

        assert (60.0, "ABORTED") == run.log.changes(EVE)[-1]
        assert "blocked for 60 s at west: west-east is closed: gate is jammed" == run.log.result(EVE).error_msg

    def test_one_that_jams_open_stays_open_until_it_is_free(self):
        """As often as it was jammed."""
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

    def test_it_can_not_be_told_anything(self):
        """The service says so."""
        run = simulate(world())
        run.simulator.roster.fixtures["gate"].jam()

        assert "gate is jammed, and stays closed" == tell(run, "open").error_message

    def test_what_it_was_told_before_is_done_when_it_is_free(self):
        """It was told to open at 0, jammed at 1, and is free at 10."""
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
    """Robots that stop on their way."""

    def test_it_does_not_close_on_a_robot_that_stands_in_it(self):
        """Canceled 5.2 m from the west, with its footprint in the door, where it stands until it is told to go on."""
        wide = world() | {"robots": {"eve": {"at": "west", "base": {"radius": 0.3}}}}
        run = simulate(wide)
        run((0.0, go(10.0)), (7.2, CancelGoal("eve", "navigate_to_pose")), until=50.0)
        before = doors_of(run.log)
        run((50.0, go(10.0, goal_id=BOB)), until=80.0)

        assert [(0.0, "door_opening"), (2.0, "door_opened")] == before
        assert (54.8, "SUCCEEDED") == run.log.changes(BOB)[-1]
        assert "door_closed" == doors_of(run.log)[-1][1]

    def test_a_robot_that_stopped_before_it_waits_for_it_again(self):
        """At 4 m; the door closes, and takes 2 s to open again for the 6 m that are left."""
        run = simulate(world())
        run((0.0, go(10.0)), (6.0, CancelGoal("eve", "navigate_to_pose")), until=20.0)
        log = run((20.0, go(10.0, goal_id=BOB)))

        assert (9.0, "door_closed") == doors_of(log)[2]
        assert (28.0, "SUCCEEDED") == log.changes(BOB)[-1]

    def test_a_robot_before_a_locked_door_in_the_middle_of_its_lane_waits(self):
        """On its lane there is no other way, also if it may leave the lane: it waits until its patience ends."""
        run = simulate(world(around=True))
        run((0.0, go(4.0)))
        tell(run, "locked")
        log = run((4.0, go(10.0, goal_id=BOB)))

        assert [] == log.happened("rerouted")
        assert (64.0, "ABORTED") == log.changes(BOB)[-1]


class TestOffTheLanes:
    """A closed door is a wall."""

    def test_a_path_through_a_closed_door_is_blocked(self):
        """Off the lanes no robot opens it."""
        log = simulate(world())((0.0, follow((0, 0.5), (10, 0.5))))

        assert "blocked: an obstacle stands between (0, 0.5) and (10, 0.5)" == log.result(EVE).error_msg

    def test_a_path_through_an_open_door_is_free(self):
        """Half a metre, and then ten."""
        log = simulate(world(open=True))((0.0, follow((0, 0.5), (10, 0.5))))

        assert (10.5, "SUCCEEDED") == log.changes(EVE)[-1]

    def test_one_that_has_closed_meanwhile_opens_for_the_next_robot(self):
        """Closed while the robot was still on the first half metre."""
        run = simulate(world(open=True))
        run((0.0, follow((0, 0.5), (10, 0.5))), until=0.2)
        tell(run, "closed")
        run.simulator.run()

        assert (12.5, "SUCCEEDED") == run.log.changes(EVE)[-1]

    def test_planned_ways_lead_through_doors_on_lanes_only(self):
        """An open door may be closed before the robot comes: the straight line from side to side is not taken."""
        plan = world(open=True)
        plan["robots"] = {"eve": {"at": [4, 0.5]}}
        route = simulate(plan).simulator.robots["eve"].plan_to((6.0, 0.5))

        assert [(4.0, 0.5), (4.0, 0.0), (6.0, 0.0)] == [leg.start for leg in route.legs]

    @pytest.mark.parametrize(("state", "clear"), [("open", True), ("closed", False)])
    def test_cameras_see_through_open_doors(self, state, clear):
        """The graph tells, of now."""
        run = simulate(world(open=state == "open"))

        assert clear is run.simulator.graph.clear_now((0.0, 0.5), (10.0, 0.5))

    def test_no_robot_is_put_into_a_closed_door(self):
        """The service refuses it."""
        run = simulate(world())
        answer = run.ask("set_entity_state", {"entity": "eve", "state": {"pose": {"position": {"x": 5.0}}}})

        assert "(5, 0) is in a closed door" == answer.result.error_message

    @pytest.mark.parametrize(("state", "end"), [("open", 8.0), ("closed", 5.0)])
    def test_a_robot_that_drives_straight_on_stops_before_a_closed_door(self, state, end):
        """Also on a lane, where walls don't count."""
        goal = actions()["drive_on_heading"].goal.model_validate({"target": {"x": 8.0}, "speed": 1.0})
        run = simulate(world(open=state == "open"))
        run((0.0, SendGoal("eve", "drive_on_heading", goal, EVE)))

        assert end == round(run.simulator.robots["eve"].pose().x, 3)


class TestAnew:
    """Resets."""

    def test_it_is_as_in_the_beginning(self):
        """Unlocked, closed and not jammed."""
        run = simulate(world())
        tell(run, "locked")
        run.simulator.roster.fixtures["gate"].jam()
        run.ask("reset_simulation")

        assert ["door", "closed"] == tags(run)
        assert (12.0, "SUCCEEDED") == run((0.0, go(10.0))).changes(EVE)[-1]

    def test_one_that_opens_when_only_time_begins_anew_is_open(self):
        """What was to come is forgotten, and so has come."""
        run = simulate(world())
        run((0.0, go(10.0)), until=1.0)
        run.ask("reset_simulation", {"scope": ResetSimulation.Request.SCOPE_TIME})

        assert ["door", "open"] == tags(run)
        run.simulator.advance(10.0)
        assert (3.0, "door_closed") in doors_of(run.log)

    def test_that_it_is_closed_in_the_beginning_is_no_news(self):
        """No robot gets through from the start, and no event is sent."""
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
    """Whatever robots want and doors are told, at any time; they never change sides while it is closed."""
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
    """Do what was drawn."""
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
