"""What each action does, with Nav2's and MoveIt's codes."""

from __future__ import annotations

import math

import pytest

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped, Quaternion
from hmrsim.interfaces.moveit_msgs import Grasp, Pickup, Place, PlaceLocation
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.protocol.commands import CancelGoal, GetResult, SendGoal
from hmrsim.protocol.topics import Topic

A, B, C = (letter * 32 for letter in "abc")


def stamped(x, y, yaw=0.0):
    """Return a pose message."""
    turned = Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    return PoseStamped(pose=Pose(position=Point(x=x, y=y), orientation=turned))


def go(x, y, yaw=0.0, *, goal_id=A, robot="wall_e"):
    """Return the command to drive to a pose."""
    return SendGoal(robot, "navigate_to_pose", NavigateToPose.Goal(pose=stamped(x, y, yaw)), goal_id, goal_id)


def pickup(item, *, goal_id=A, robot="wall_e", **fields):
    """Return the command to pick up an item."""
    return SendGoal(robot, "pickup", Pickup.Goal(target_name=item, **fields), goal_id, goal_id)


def place(item, *, goal_id=A, robot="wall_e", **fields):
    """Return the command to place an item."""
    return SendGoal(robot, "place", Place.Goal(attached_object_name=item, **fields), goal_id, goal_id)


class TestNavigateToPose:
    """Drive to a pose."""

    def test_it_arrives_exactly_and_faces_the_goal_s_yaw(self, run):
        """Position and yaw are the goal's."""
        run((0.0, go(9.0, 2.4, 1.0)))

        assert (9.0, 2.4) == run.simulator.robots["wall_e"].pose().point
        assert math.isclose(1.0, run.simulator.robots["wall_e"].pose().yaw)

    def test_already_there_succeeds_at_once(self, run):
        """No time passes."""
        assert (0.0, "SUCCEEDED") == run((0.0, go(1.0, 2.0))).changes(A)[-1]

    def test_feedback_tells_pose_times_and_distance(self, run):
        """After 2 s of 8 at 1 m/s."""
        log = run((0.0, go(9.0, 2.0)))
        _, feedback = next((t, f) for t, f in log.feedback(A) if math.isclose(t, 2.0))

        assert (3.0, 2.0) == pytest.approx(
            (feedback.current_pose.pose.position.x, feedback.current_pose.pose.position.y)
        )
        assert "map" == feedback.current_pose.header.frame_id
        assert [2.0, 6.0, 6.0] == pytest.approx(
            [
                feedback.navigation_time.to_seconds(),
                feedback.estimated_time_remaining.to_seconds(),
                feedback.distance_remaining,
            ]
        )
        assert 0 == feedback.number_of_recoveries

    @pytest.mark.parametrize(
        ("x", "y", "code", "text"),
        [
            (21.0, 2.0, 204, "target (21, 2) is outside the map, which spans (0, 0) to (20, 10)"),
            (7.0, 5.0, 206, "target (7, 5) is inside an obstacle"),
            (12.0, 5.0, 206, "target (12, 5) is inside an obstacle"),
            (15.0, 2.0, 208, "no route from (1, 2) to (15, 2)"),
        ],
    )
    def test_an_unreachable_target_is_aborted_with_the_planner_s_code(self, run, x, y, code, text):
        """Outside the map, in a solid, on a wall, in another component: accepted, ABORTED, not moved."""
        log = run((1.0, go(x, y)))

        assert [(1.0, "ACCEPTED"), (1.0, "EXECUTING"), (1.0, "ABORTED")] == log.changes(A)
        assert (code, text) == (log.result(A).error_code, log.result(A).error_msg)
        assert (1.0, 2.0) == run.simulator.robots["wall_e"].pose().point

    @pytest.mark.parametrize("x", [2e7, 1e10, 1e300])
    def test_a_target_beyond_all_maps_is_outside_the_map(self, make_run, x):
        """Also in a world without bounds."""
        log = make_run({"robots": {"wall_e": {"at": [0, 0]}}})((0.0, go(x, 0.0)))

        assert (204, "ABORTED") == (log.result(A).error_code, log.changes(A)[-1][1])

    def test_a_drive_of_centuries_is_told_as_the_longest_that_ros_can_state(self, make_run):
        """Durations and stamps end at 68 years; the simulation goes on."""
        world = {"robots": {"wall_e": {"at": [0, 0], "base": {"speed": 1e-8}}}}
        log = make_run(world, topics=frozenset({Topic.FEEDBACK}), feedback_rate=1e-10)((0.0, go(1000.0, 0.0)))

        assert "SUCCEEDED" == log.changes(A)[-1][1]
        assert 2**31 - 1 == log.feedback(A)[-1][1].navigation_time.sec

    def test_a_zero_quaternion_faces_zero(self, run):
        """It is no orientation at all."""
        goal = NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=Point(x=5, y=2), orientation=Quaternion(w=0.0))))
        run((0.0, SendGoal("wall_e", "navigate_to_pose", goal, A)))

        assert 0.0 == run.simulator.robots["wall_e"].pose().yaw

    def test_speed_is_one_metre_a_second_by_default_and_300_in_pixels(self, make_run):
        """The original's 5 px a frame at 60 frames."""
        world = {"waypoints": {"a": [0, 0], "b": [600, 0]}, "lanes": [["a", "b"]], "robots": {"wall_e": {"at": "a"}}}

        assert (600.0, "SUCCEEDED") == make_run(world)((0.0, go(600.0, 0.0))).changes(A)[-1]
        assert (2.0, "SUCCEEDED") == make_run(world | {"units": "px"})((0.0, go(600.0, 0.0))).changes(A)[-1]


class TestWait:
    """Stand still."""

    def test_it_takes_its_time(self, run):
        """And says how long it took."""
        log = run((1.0, SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=2, nanosec=500_000_000)), A)))

        assert (3.5, "SUCCEEDED") == log.changes(A)[-1]
        assert Duration(sec=2, nanosec=500_000_000) == log.result(A).total_elapsed_time

    def test_feedback_tells_what_is_left(self, run):
        """The last is zero."""
        log = run((0.0, SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=1)), A)))

        assert [0.9, 0.0] == pytest.approx([log.feedback(A)[i][1].time_left.to_seconds() for i in (0, -1)])

    def test_a_negative_time_is_over_at_once(self, run):
        """There is nothing to wait for."""
        assert (0.0, "SUCCEEDED") == run(
            (0.0, SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=-5)), A))
        ).changes(A)[-1]


class TestPickup:
    """Pick up an item."""

    def test_an_item_carried_moves_with_its_robot(self, run):
        """After driving off with it, it is where the robot is."""
        log = run((0.0, pickup("letter")), (0.0, go(5.0, 2.0, goal_id=B)), until=2.0)

        assert 1 == log.result(A).error_code.val
        assert (3.0, 2.0) == run.simulator.items["letter"].position

    @pytest.mark.parametrize(
        ("item", "robot", "code", "text"),
        [
            ("ghost", "wall_e", -19, "no item 'ghost'; there are: anvil, letter, parcel"),
            ("parcel", "wall_e", -1, "'parcel' is out of reach: 8.006 m away, reach 0.9"),
            ("anvil", "eve", -4, "'anvil' is too heavy: 80 kg, the claw lifts 1 kg"),
        ],
    )
    def test_what_can_t_be_picked_up_is_aborted_with_moveit_s_code(self, run, item, robot, code, text):
        """Unknown, out of reach, too heavy; the text says how far and how much."""
        log = run((0.0, pickup(item, robot=robot)))

        assert "ABORTED" == log.changes(A)[-1][1]
        assert (code, text) == (log.result(A).error_code.val, log.result(A).error_code.message)
        assert run.simulator.items.get(item) is None or run.simulator.items[item].carrier is None

    @pytest.mark.parametrize(("away", "weight", "code"), [(0.5, 1.0, 1), (0.5001, 1.0, -1), (0.5, 1.0001, -4)])
    def test_the_limits_of_a_claw_are_still_within_them(self, make_run, away, weight, code):
        """At 0.5 m and 1 kg it picks; a little more is out of reach, or too heavy."""
        kind = {"components": {"claw": {"reach": 0.5, "max_weight": 1.0}}}
        world = {
            "items": {"parcel": {"at": [away, 0], "weight": weight}},
            "robot_types": {"nurse": kind},
            "robots": {"wall_e": {"at": [0, 0], "type": "nurse"}},
        }
        log = make_run(world)((0.0, pickup("parcel")))

        assert code == log.result(A).error_code.val

    def test_a_claw_holds_one_item(self, run):
        """A second is INVALID_ROBOT_STATE."""
        log = run((0.0, pickup("letter")), (0.1, pickup("parcel", goal_id=B)))

        assert (-17, "the claw holds 'letter' already") == (
            log.result(B).error_code.val,
            log.result(B).error_code.message,
        )

    def test_an_item_that_is_carried_already_is_refused(self, make_run):
        """MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE, and the text says by whom."""
        log = make_run(_pair(0))((0.0, pickup("letter", robot="eve")), (1.0, pickup("letter", goal_id=B)))

        assert (-3, "'letter' is carried by eve already") == (
            log.result(B).error_code.val,
            log.result(B).error_code.message,
        )

    def test_of_two_that_reach_for_one_item_the_faster_gets_it(self, make_run):
        """The other is told when its claw closes."""
        run = make_run(_pair(2))
        log = run((0.0, pickup("letter", robot="eve")), (0.5, pickup("letter", goal_id=B)))

        assert [(2.0, "SUCCEEDED"), (2.5, "ABORTED")] == [log.changes(i)[-1] for i in (A, B)]
        assert -3 == log.result(B).error_code.val
        assert "eve" == run.simulator.items["letter"].carrier.name

    def test_the_grasp_performed_is_the_first_that_was_offered(self, run):
        """It is in the result."""
        log = run((0.0, pickup("letter", possible_grasps=[Grasp(id="top"), Grasp(id="side")])))

        assert "top" == log.result(A).grasp.id

    def test_feedback_tells_each_stage(self, run):
        """As MoveIt's server did, on change only."""
        log = run((0.0, pickup("letter")))

        assert ["PLANNING", "MONITOR", "IDLE"] == [feedback.state for _, feedback in log.feedback(A)]

    def test_canceling_leaves_the_item(self, make_run):
        """PREEMPTED and 'canceled', as MoveIt says it."""
        run = make_run(_pair(2))
        log = run((0.0, pickup("letter")), (1.0, CancelGoal("wall_e", "pickup", A)))

        assert (1.0, "CANCELED") == log.changes(A)[-1]
        assert (-7, "canceled") == (log.result(A).error_code.val, log.result(A).error_code.message)
        assert run.simulator.items["letter"].carrier is None


def _pair(handling_time):
    """Return a world with two robots beside a letter, whose claws take so long."""
    robot = {"type": "fetcher", "at": [0, 0], "components": {"claw": {"handling_time": handling_time}}}
    return {
        "items": {"letter": {"at": [0, 0.5]}, "parcel": {"at": [0, 0.2]}},
        "robots": {"wall_e": robot, "eve": robot},
    }


class TestPlace:
    """Put down what is held."""

    def test_it_lies_at_the_robot_s_centre(self, run):
        """Where the robot has driven to, and it stays there."""
        run(
            (0.0, pickup("letter")),
            (0.0, go(5.0, 2.0, goal_id=B)),
            (9.0, place("letter", goal_id=C)),
            (9.0, go(1.0, 2.0)),
        )

        assert (5.0, 2.0) == run.simulator.items["letter"].position

    def test_it_lies_at_the_first_location_within_reach(self, run):
        """The second of two, here; the result says which."""
        locations = [PlaceLocation(id=n, place_pose=stamped(x, 2.0)) for n, x in (("far", 9.0), ("near", 1.5))]
        log = run((0.0, pickup("letter")), (1.0, place("letter", goal_id=B, place_locations=locations)))

        assert (1.5, 2.0) == run.simulator.items["letter"].position
        assert "near" == log.result(B).place_location.id

    def test_no_location_within_reach_is_aborted(self, run):
        """PLANNING_FAILED; the item stays in the claw."""
        log = run(
            (0.0, pickup("letter")),
            (1.0, place("letter", goal_id=B, place_locations=[PlaceLocation(place_pose=stamped(9.0, 2.0))])),
        )

        assert (-1, "none of 1 place locations is within reach, which is 0.9 m") == (
            log.result(B).error_code.val,
            log.result(B).error_code.message,
        )
        assert "wall_e" == run.simulator.items["letter"].carrier.name

    def test_a_location_in_an_unknown_frame_is_rejected(self, run):
        """There is no other frame than the map."""
        pose = PoseStamped.model_validate({"header": {"frame_id": "gripper"}})
        log = run((0.0, place("letter", place_locations=[PlaceLocation(place_pose=pose)])))

        assert "invalid_goal" == log.answer(A).reason

    @pytest.mark.parametrize(
        ("held", "name", "text"),
        [
            (None, "letter", "the claw holds nothing, so not 'letter' either"),
            ("letter", "parcel", "the claw holds 'letter', not 'parcel'"),
        ],
    )
    def test_placing_what_is_not_held_is_aborted(self, run, held, name, text):
        """INVALID_OBJECT_NAME."""
        first = [(0.0, pickup(held, goal_id=B))] if held else []
        log = run(*first, (1.0, place(name)))

        assert (-19, text) == (log.result(A).error_code.val, log.result(A).error_code.message)

    def test_without_a_name_the_one_thing_that_is_held_is_meant(self, run):
        """As MoveIt has it."""
        log = run((0.0, pickup("letter")), (1.0, place("", goal_id=B)))

        assert 1 == log.result(B).error_code.val

    def test_a_result_can_be_asked_for_later(self, run):
        """It is kept like any other."""
        log = run((0.0, pickup("letter")), (5.0, GetResult("wall_e", "pickup", A, "later")))

        assert 1 == log.answer("later").result.error_code.val


@pytest.mark.parametrize("end", [CancelGoal("wall_e", "wait"), SendGoal("wall_e", "wait", Wait.Goal(), "b" * 32)])
def test_a_wait_that_is_cut_short_tells_how_long_it_was(run, end):
    """Canceled or preempted after 1.5 s of 4."""
    log = run((1.0, SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=4)), "c" * 32)), (2.5, end))

    assert 1.5 == log.result("c" * 32).total_elapsed_time.to_seconds()
