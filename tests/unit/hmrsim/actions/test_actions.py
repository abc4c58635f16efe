"""The results of each action, with the codes of Nav2 and MoveIt."""

from __future__ import annotations

import math

import pytest

from hmrsim.goals.script_orders import read_order
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped, Quaternion
from hmrsim.interfaces.moveit_msgs import Grasp, PlaceLocation
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.protocol.topics import Topic
from hmrsim.world.model import World
from tests.simulation import SMALL_WORLD, A, B, C, at, send


def go(x, y, yaw=0.0, *, goal_id=A, robot="wall_e"):
    return send("navigate_to_pose", goal_id, robot, pose=at(x, y, yaw))


def pickup(item, *, goal_id=A, robot="wall_e", **fields):
    return send("pickup", goal_id, robot, target_name=item, **fields)


def place(item, *, goal_id=A, robot="wall_e", **fields):
    return send("place", goal_id, robot, attached_object_name=item, **fields)


class TestNavigateToPose:
    def test_it_arrives_exactly_and_faces_the_goal_s_yaw(self, run):
        run((0.0, go(9.0, 2.4, 1.0)))

        assert (9.0, 2.4) == run.simulator.robots["wall_e"].pose().point
        assert math.isclose(1.0, run.simulator.robots["wall_e"].pose().yaw)

    def test_already_there_succeeds_at_once(self, run):
        assert (0.0, "SUCCEEDED") == run((0.0, go(1.0, 2.0))).changes(A)[-1]

    def test_feedback_has_pose_times_and_distance(self, run):
        log = run((0.0, go(9.0, 2.0)))
        _, feedback = next((t, f) for t, f in log.feedback(A) if math.isclose(t, 2.0))

        pose, elapsed, remaining = feedback.current_pose, feedback.navigation_time, feedback.estimated_time_remaining
        assert (3.0, 2.0) == pytest.approx((pose.pose.position.x, pose.pose.position.y))
        assert ("map", 0) == (pose.header.frame_id, feedback.number_of_recoveries)
        assert (2.0, 6.0) == pytest.approx((elapsed.to_seconds(), remaining.to_seconds()))
        assert 6.0 == pytest.approx(feedback.distance_remaining)

    @pytest.mark.parametrize(
        ("x", "y", "code", "text"),
        [
            (21.0, 2.0, 204, "target (21, 2) is outside the map, which spans (0, 0) to (20, 10)"),
            (7.0, 5.0, 206, "target (7, 5) is inside an obstacle"),
            (12.0, 5.0, 206, "target (12, 5) is inside an obstacle"),
            (15.0, 2.0, 208, "no route from home to island"),
        ],
    )
    def test_an_unreachable_target_is_aborted_with_the_planner_s_code(self, run, x, y, code, text):
        log = run((1.0, go(x, y)))

        assert [(1.0, "ACCEPTED"), (1.0, "EXECUTING"), (1.0, "ABORTED")] == log.changes(A)
        assert (code, text) == (log.result(A).error_code, log.result(A).error_msg)
        assert (1.0, 2.0) == run.simulator.robots["wall_e"].pose().point

    @pytest.mark.parametrize("x", [2e7, 1e10, 1e300])
    def test_a_target_beyond_all_maps_is_outside_the_map(self, make_run, x):
        log = make_run({"robots": {"wall_e": {"at": [0, 0]}}})((0.0, go(x, 0.0)))

        assert (204, "ABORTED") == (log.result(A).error_code, log.changes(A)[-1][1])

    def test_a_drive_of_centuries_reports_the_longest_duration_of_ros(self, make_run):
        """Durations and stamps end at 68 years, but the simulation continues."""
        world = {"robots": {"wall_e": {"at": [0, 0], "base": {"speed": 1e-8}}}}
        log = make_run(world, topics=frozenset({Topic.FEEDBACK}), feedback_rate=1e-10)((0.0, go(1000.0, 0.0)))

        assert "SUCCEEDED" == log.changes(A)[-1][1]
        assert 2**31 - 1 == log.feedback(A)[-1][1].navigation_time.sec

    def test_a_zero_quaternion_faces_zero(self, run):
        goal = NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=Point(x=5, y=2), orientation=Quaternion(w=0.0))))
        run((0.0, SendGoal("wall_e", "navigate_to_pose", goal, A)))

        assert 0.0 == run.simulator.robots["wall_e"].pose().yaw

    def test_default_speed_is_1_m_per_second_or_300_px(self, make_run):
        """The original drives 5 px per frame at 60 frames per second."""
        world = {"waypoints": {"a": [0, 0], "b": [600, 0]}, "lanes": [["a", "b"]], "robots": {"wall_e": {"at": "a"}}}

        assert (600.0, "SUCCEEDED") == make_run(world)((0.0, go(600.0, 0.0))).changes(A)[-1]
        assert (2.0, "SUCCEEDED") == make_run(world | {"units": "px"})((0.0, go(600.0, 0.0))).changes(A)[-1]


class TestWait:
    @pytest.mark.parametrize(("seconds", "taken"), [(2.5, 2.5), (-5, 0)])
    def test_it_takes_the_requested_time_if_that_is_positive(self, run, seconds, taken):
        log = run((1.0, SendGoal("wall_e", "wait", Wait.Goal(time=Duration.from_seconds(seconds)), A)))

        assert (1.0 + taken, "SUCCEEDED") == log.changes(A)[-1]
        assert taken == log.result(A).total_elapsed_time.to_seconds()

    def test_feedback_has_the_remaining_time(self, run):
        log = run((0.0, SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=1)), A)))

        assert [0.9, 0.0] == pytest.approx([log.feedback(A)[i][1].time_left.to_seconds() for i in (0, -1)])


class TestPickup:
    def test_an_item_carried_moves_with_its_robot(self, run):
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
    def test_impossible_pickups_are_aborted_with_moveit_s_code(self, run, item, robot, code, text):
        log = run((0.0, pickup(item, robot=robot)))

        assert "ABORTED" == log.changes(A)[-1][1]
        assert (code, text) == (log.result(A).error_code.val, log.result(A).error_code.message)
        assert run.simulator.items.get(item) is None or run.simulator.items[item].carrier is None

    @pytest.mark.parametrize(("away", "weight", "code"), [(0.5, 1.0, 1), (0.5001, 1.0, -1), (0.5, 1.0001, -4)])
    def test_the_limits_of_a_claw_are_inclusive(self, make_run, away, weight, code):
        kind = {"components": {"claw": {"reach": 0.5, "max_weight": 1.0}}}
        world = {
            "items": {"parcel": {"at": [away, 0], "weight": weight}},
            "robot_types": {"nurse": kind},
            "robots": {"wall_e": {"at": [0, 0], "type": "nurse"}},
        }
        log = make_run(world)((0.0, pickup("parcel")))

        assert code == log.result(A).error_code.val

    def test_a_claw_holds_one_item(self, run):
        log = run((0.0, pickup("letter")), (0.1, pickup("parcel", goal_id=B)))

        assert -17 == log.result(B).error_code.val
        assert "the claw holds 'letter' already" == log.result(B).error_code.message

    def test_an_item_that_another_robot_carries_is_rejected(self, make_run):
        log = make_run(_pair(0))((0.0, pickup("letter", robot="eve")), (1.0, pickup("letter", goal_id=B)))

        assert -3 == log.result(B).error_code.val
        assert "'letter' is carried by eve already" == log.result(B).error_code.message

    def test_the_faster_of_two_robots_gets_the_item(self, make_run):
        run = make_run(_pair(2))
        log = run((0.0, pickup("letter", robot="eve")), (0.5, pickup("letter", goal_id=B)))

        assert [(2.0, "SUCCEEDED"), (2.5, "ABORTED")] == [log.changes(i)[-1] for i in (A, B)]
        assert -3 == log.result(B).error_code.val
        assert "eve" == run.simulator.items["letter"].carrier.name

    def test_the_first_offered_grasp_is_performed(self, run):
        log = run((0.0, pickup("letter", possible_grasps=[Grasp(id="top"), Grasp(id="side")])))

        assert "top" == log.result(A).grasp.id

    def test_feedback_names_each_stage_once(self, run):
        log = run((0.0, pickup("letter")))

        assert ["PLANNING", "MONITOR", "IDLE"] == [feedback.state for _, feedback in log.feedback(A)]

    def test_canceling_leaves_the_item(self, make_run):
        run = make_run(_pair(2))
        log = run((0.0, pickup("letter")), (1.0, CancelGoal("wall_e", "pickup", A)))

        assert (1.0, "CANCELED") == log.changes(A)[-1]
        assert (-7, "canceled") == (log.result(A).error_code.val, log.result(A).error_code.message)
        assert run.simulator.items["letter"].carrier is None


def _pair(handling_time):
    robot = {"type": "fetcher", "at": [0, 0], "components": {"claw": {"handling_time": handling_time}}}
    return {
        "items": {"letter": {"at": [0, 0.5]}, "parcel": {"at": [0, 0.2]}},
        "robots": {"wall_e": robot, "eve": robot},
    }


class TestPlace:
    def test_it_lies_at_the_robot_s_center(self, run):
        run(
            (0.0, pickup("letter")),
            (0.0, go(5.0, 2.0, goal_id=B)),
            (9.0, place("letter", goal_id=C)),
            (9.0, go(1.0, 2.0)),
        )

        assert (5.0, 2.0) == run.simulator.items["letter"].position

    def test_it_lies_at_the_first_location_within_reach(self, run):
        locations = [{"id": name, "place_pose": at(x, 2.0)} for name, x in (("far", 9.0), ("near", 1.5))]
        log = run((0.0, pickup("letter")), (1.0, place("letter", goal_id=B, place_locations=locations)))

        assert (1.5, 2.0) == run.simulator.items["letter"].position
        assert "near" == log.result(B).place_location.id

    def test_no_location_within_reach_is_aborted(self, run):
        log = run(
            (0.0, pickup("letter")),
            (1.0, place("letter", goal_id=B, place_locations=[{"place_pose": at(9.0, 2.0)}])),
        )

        assert -1 == log.result(B).error_code.val
        assert "none of 1 place locations is within reach, which is 0.9 m" == log.result(B).error_code.message
        assert "wall_e" == run.simulator.items["letter"].carrier.name

    def test_a_location_in_an_unknown_frame_is_rejected(self, run):
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
    def test_placing_another_item_is_aborted(self, run, held, name, text):
        first = [(0.0, pickup(held, goal_id=B))] if held else []
        log = run(*first, (1.0, place(name)))

        assert (-19, text) == (log.result(A).error_code.val, log.result(A).error_code.message)

    def test_without_a_name_the_held_item_is_placed(self, run):
        log = run((0.0, pickup("letter")), (1.0, place("", goal_id=B)))

        assert 1 == log.result(B).error_code.val


@pytest.mark.parametrize("end", [CancelGoal("wall_e", "wait"), SendGoal("wall_e", "wait", Wait.Goal(), "b" * 32)])
def test_an_interrupted_wait_reports_its_duration(run, end):
    log = run((1.0, SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=4)), "c" * 32)), (2.5, end))

    assert 1.5 == log.result("c" * 32).total_elapsed_time.to_seconds()


WORLD = World.model_validate(SMALL_WORLD)


def points(poses):
    return [(at.pose.position.x, at.pose.position.y) for at in poses]


def test_through_takes_places_or_points_between_semicolons():
    order = read_order("Through door; 3 4; shelf", WORLD)

    assert "navigate_through_poses" == order.action.name
    assert [(5.0, 2.0), (3.0, 4.0), (9.0, 2.0)] == points(order.goal.poses.goals)


def test_visit_takes_places_between_semicolons():
    order = read_order("Visit door;home", WORLD)

    assert "follow_waypoints" == order.action.name
    assert [(5.0, 2.0), (1.0, 2.0)] == points(order.goal.poses)


def test_spin_takes_radians():
    order = read_order("Spin -1.5", WORLD)

    assert ("spin", -1.5) == (order.action.name, order.goal.target_yaw)


@pytest.mark.parametrize(("word", "action"), [("Back", "back_up"), ("Drive", "drive_on_heading")])
@pytest.mark.parametrize(("rest", "distance", "speed"), [("2", 2.0, 1.0), ("2 0.5", 2.0, 0.5)])
def test_back_and_drive_take_a_distance_and_a_speed(word, action, rest, distance, speed):
    order = read_order(f"{word} {rest}", WORLD)

    assert (action, distance, speed) == (order.action.name, order.goal.target.x, order.goal.speed)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Through door; shelv", "no waypoint, place or dock 'shelv'; did you mean 'shelf'"),
        ("Visit door;", "no waypoint, place or dock ''"),
        ("Spin", "'Spin' says too little; expected Spin RADIANS"),
        ("Spin 1 2", "expected one number of radians, got '1 2'"),
        ("Back -1", "expected a distance, and perhaps a speed, both positive, got '-1'"),
        ("Drive 1 0", "expected a distance, and perhaps a speed, both positive, got '1 0'"),
        ("Drive 1 2 3", "expected a distance, and perhaps a speed, both positive, got '1 2 3'"),
        ("Drive far", "'far' is not a number"),
    ],
)
def test_invalid_orders_are_rejected(text, message):
    with pytest.raises(ValueError, match=message):
        read_order(text, WORLD)
