"""The observed state of the world: the start and the end of each condition."""

from __future__ import annotations

from itertools import pairwise

import pytest

from hmrsim.navigation.motion import Trapezoid
from tests.watching import Feed, ward

GO = "navigate_to_pose"
A = "a" * 32
POWER = {"charge": 100.0, "percentage": 0.5}
PLACED = {"order": "pills_1", "item": "pills_1", "from": "lab", "to": "ward_a", "within": 60.0}


def spans(condition, tell, until=100.0, **world):
    """Return the times at which a condition started and ceased to hold in a run of some events."""
    feed = Feed({"holds": {"never": condition}, "fails": {"always": condition}}, world=ward(**world))
    feed.monitor.begin(0)
    tell(feed)
    feed.end(until)
    changes = sorted((at, name == "holds") for at, name, _, _ in feed.violations)
    return [(round(at, 3), holds) for at, holds in changes]


def drive(feed, at, start, *ends, seconds=10.0, robot="eve", **fields):
    """Feed a motion from point to point, with the seconds that each takes."""
    points = [start, *ends]
    pieces = [
        {"from": [*a, 0.0], "to": [*b, 0.0], "duration": seconds, "lane": None, **fields} for a, b in pairwise(points)
    ]
    feed.event(at, "motion", robot=robot, **pieces[0], then=pieces[1:])


def test_passing_a_place_is_being_there():
    """A robot that passes at 1 m/s is within a metre for two seconds."""
    found = spans({"robot": "eve", "at": "hall"}, lambda feed: drive(feed, 5.0, [0.0, 0.0], [10.0, 0.0], [20.0, 0.0]))

    assert [(0.0, False), (14.0, True), (16.0, False)] == found


def test_a_stop_withdraws_the_rest_of_a_motion():

    def tell(feed):
        drive(feed, 5.0, [0.0, 0.0], [10.0, 0.0], [20.0, 0.0])
        feed.event(12.0, "stopped", robot="eve", at=[7.0, 0.0])

    assert [(0.0, False)] == spans({"robot": "eve", "at": "hall"}, tell)


def test_a_new_motion_replaces_all_earlier_ones():

    def tell(feed):
        drive(feed, 5.0, [0.0, 0.0], [10.0, 0.0], [20.0, 0.0])
        drive(feed, 12.0, [7.0, 0.0], [0.0, 0.0])

    assert [(0.0, False)] == spans({"robot": "eve", "at": "hall"}, tell)


def test_a_robot_that_arrives_stays():
    """A route that ends near a place has no end of being there."""
    found = spans({"robot": "eve", "at": "hall"}, lambda feed: drive(feed, 0.0, [0.0, 0.0], [10.0, 0.0]))

    assert [(0.0, False), (9.0, True)] == found


def test_a_route_beside_a_place_is_not_near_it():
    found = spans({"robot": "eve", "at": "hall"}, lambda feed: drive(feed, 0.0, [0.0, 1.5], [20.0, 1.5]))

    assert [(0.0, False)] == found


def test_the_robustness_of_staying_away_grows_with_the_distance():
    """It is a tenth at 1.9 m."""
    feed = Feed({"out": {"never": {"robot": "*", "at": "hall"}}}, world=ward(robots={"eve": {"at": [0, 9]}}))
    feed.monitor.begin(0)
    drive(feed, 0.0, [0.0, 1.9], [20.0, 1.9], seconds=20.0)
    feed.event(5.5, "stopped", robot="eve", at=[5.5, 1.9])
    stopped = feed.monitor.verdicts()[0].robustness
    drive(feed, 6.0, [5.5, 1.9], [20.0, 1.9], seconds=14.5)

    assert (round((4.8847 - 1) / 9, 4), 0.1) == (round(stopped, 4), round(feed.end(30).verdict("out").robustness, 6))


def test_accelerations_determine_the_times_at_a_place():
    profile = Trapezoid(20.0, 2.0, 0.5)

    found = spans(
        {"robot": "eve", "at": "hall"},
        lambda feed: drive(feed, 0.0, [0.0, 0.0], [20.0, 0.0], seconds=profile.duration, profile=[20.0, 2.0, 0.5, 0.0]),
    )

    assert [(0.0, False), (round(profile.time(9.0), 3), True), (round(profile.time(11.0), 3), False)] == found


def test_a_robot_in_a_lift_stays_at_its_start_until_it_arrives():
    found = spans(
        {"robot": "eve", "at": "ward_b"},
        lambda feed: drive(feed, 2.0, [20.0, 0.0], [20.0, 10.0], seconds=8.0, ride=True),
    )

    assert [(0.0, False), (10.0, True)] == found


@pytest.mark.parametrize(
    ("kind", "fields", "there"),
    [
        ("teleported", {"entity": "eve", "at": [10.0, 0.0], "yaw": 0.0}, True),
        ("waiting", {"robot": "eve", "at": [10.5, 0.0]}, True),
        ("deleted", {"entity": "eve"}, False),
    ],
)
def test_teleporting_waiting_and_deleting_set_the_place_of_a_robot(kind, fields, there):
    begins = [10.0, 0.0] if kind == "deleted" else [0.0, 0.0]

    found = spans(
        {"robot": "eve", "at": "hall"}, lambda feed: feed.event(5.0, kind, **fields), robots={"eve": {"at": begins}}
    )

    assert [(0.0, not there), (5.0, there)] == found


def test_the_states_of_a_robot_are_those_of_reports():
    def tell(feed):
        feed.goal(1, "eve", GO, A, 1, 2)
        drive(feed, 2.0, [0.0, 0.0], [10.0, 0.0], seconds=30.0)
        feed.event(5, "waiting", robot="eve", at=[1.0, 0.0])
        feed.event(9, "went_on", robot="eve", waited=4.0)
        drive(feed, 9.0, [1.0, 0.0], [10.0, 0.0], seconds=3.0)
        feed.event(20, "fault_began", fault="breakdown", name="b", robot="eve")
        feed.event(30, "fault_began", fault="messages_lost", name="m", robot="eve")
        feed.event(40, "fault_ended", fault="messages_lost", name="m", robot="eve")
        feed.event(50, "fault_ended", fault="breakdown", name="b", robot="eve")
        feed.goal(60, "eve", GO, A, 4)
        feed.event(70, "charging_began", robot="eve", **POWER)

    found = {
        state: [at for at, holds in spans({"robot": "eve", "is": state}, tell) if holds]
        for state in ("idle", "busy", "driving", "waiting", "stopped", "offline", "charging")
    }

    assert {
        "idle": [0.0, 60.0],
        "busy": [1.0, 12.0, 50.0],
        "driving": [2.0, 9.0],
        "waiting": [5.0],
        "stopped": [20.0, 40.0],
        "offline": [30.0],
        "charging": [70.0],
    } == found


def test_an_item_is_where_its_carrier_is():

    def tell(feed):
        feed.event(1, "picked", robot="eve", item="medicine")
        drive(feed, 2.0, [0.0, 0.0], [20.0, 0.0], seconds=20.0)
        feed.event(30, "placed", robot="eve", item="medicine", at=[20.0, 0.3])
        feed.event(40, "deleted", entity="medicine")

    found = [
        spans({"item": "medicine", **said}, tell)
        for said in (
            {"at": "ward_a"},
            {"at": "ward_a", "carried": False},
            {"at": "hall"},
            {"carried": True},
            {"carried_by": "wall_e"},
        )
    ]

    assert [
        [(0.0, False), (21.0, True), (40.0, False)],
        [(0.0, False), (30.0, True), (40.0, False)],
        [(0.0, False), (11.0, True), (13.0, False)],
        [(0.0, False), (1.0, True), (30.0, False)],
        [(0.0, False)],
    ] == found


def test_an_item_is_where_it_is_put():

    def tell(feed):
        feed.event(5, "teleported", entity="eve", at=[10.0, 0.0], yaw=0.0)
        feed.event(10, "teleported", entity="medicine", at=[10.0, 0.0], yaw=0.0)
        feed.event(20, "deleted", entity="medicine")
        feed.event(30, "teleported", entity="eve", at=[0.0, 0.0], yaw=0.0)

    assert [(0.0, False), (10.0, True), (20.0, False)] == spans({"item": "medicine", "at": "hall"}, tell)


def test_an_item_is_where_its_carrier_had_driven_before():
    """A robot that was elsewhere at the start picks up the item."""

    def tell(feed):
        drive(feed, 2.0, [0.0, 0.0], [10.0, 0.0])
        feed.event(15, "picked", robot="eve", item="medicine")
        feed.event(20, "placed", robot="eve", item="medicine", at=[0.0, 0.0])

    found = spans({"item": "medicine", "at": "hall"}, tell)

    assert [(0.0, False), (15.0, True), (20.0, False)] == found


def test_a_battery_at_a_bound_is_neither_above_nor_below_it():

    def tell(feed):
        for at, share in ((5, 0.3), (6, 0.25), (7, 0.2)):
            feed.event(at, "battery_low", robot="eve", charge=1.0, percentage=share)

    found = [spans({"battery": "eve", side: 0.25}, tell) for side in ("above", "below")]

    assert [[(0.0, True), (6.0, False)], [(0.0, False), (7.0, True)]] == found


def test_a_door_is_closed_opening_open_and_jammed():

    def tell(feed):
        feed.event(1, "door_opening", door="gate")
        feed.event(3, "door_opened", door="gate")
        feed.event(4, "fault_began", fault="door_jammed", name="j", door="gate")
        feed.event(6, "fault_ended", fault="door_jammed", name="j", door="gate")
        feed.event(9, "door_closed", door="gate")

    found = [spans({"door": "gate", "is": state}, tell) for state in ("closed", "opening", "open", "jammed")]

    assert [
        [(1.0, False), (9.0, True)],
        [(0.0, False), (1.0, True), (3.0, False)],
        [(0.0, False), (3.0, True), (9.0, False)],
        [(0.0, False), (4.0, True), (6.0, False)],
    ] == [[change for change in each if change != (0.0, True)] for each in found]


def test_an_order_is_late_beside_its_state():
    def tell(feed):
        feed.event(5, "order_placed", **PLACED)
        feed.event(10, "order_picked_up", order="pills_1", item="pills_1", robot="eve")
        feed.event(20, "dropped", robot="eve", item="pills_1", at=[1.0, 0.0])
        feed.event(65, "order_late", order="pills_1", item="pills_1", to="ward_a")
        feed.event(70, "order_delivered", order="pills_1", item="pills_1", lead_time=65.0, late=5.0)

    found = [
        spans({"order": "pills_1", "is": state}, tell) for state in ("waiting", "carried", "late", "delivered", "lost")
    ]

    assert [
        [(0.0, False), (5.0, True), (10.0, False), (20.0, True), (70.0, False)],
        [(0.0, False), (10.0, True), (20.0, False)],
        [(0.0, False), (65.0, True)],
        [(0.0, False), (70.0, True)],
        [(0.0, False)],
    ] == found


def test_a_fault_is_active_for_its_robot_and_for_any():

    def tell(feed):
        feed.event(3, "fault_began", fault="slip", name="s", robot="eve")
        feed.event(8, "fault_ended", fault="slip", name="s", robot="eve")

    found = [spans({"fault": "slip", **said}, tell) for said in ({}, {"robot": "eve"}, {"robot": "wall_e"})]

    active = [(0.0, False), (3.0, True), (8.0, False)]
    assert [active, active, [(0.0, False)]] == found


def test_a_lane_is_closed_in_its_direction():

    def tell(feed):
        feed.event(3, "lane_closed", lane=["lab", "hall"], why="wet")
        feed.event(8, "lane_opened", lane=["lab", "hall"])

    there, back = (spans({"lane": lane, "is": "closed"}, tell) for lane in (["lab", "hall"], ["hall", "lab"]))

    assert ([(0.0, False), (3.0, True), (8.0, False)], [(0.0, False)]) == (there, back)


def test_all_any_and_not_combine_conditions():

    def tell(feed):
        feed.event(3, "lane_closed", lane=["lab", "hall"], why="wet")
        feed.event(5, "fault_began", fault="slip", name="s", robot="eve")
        feed.event(8, "lane_opened", lane=["lab", "hall"])

    wet, slips = {"lane": ["lab", "hall"], "is": "closed"}, {"fault": "slip"}
    found = [spans(each, tell) for each in ({"all": [wet, slips]}, {"any": [wet, slips]}, {"not": wet})]

    assert [
        [(0.0, False), (5.0, True), (8.0, False)],
        [(0.0, False), (3.0, True)],
        [(0.0, True), (3.0, False), (8.0, True)],
    ] == found


def test_an_event_holds_at_its_instant():
    def tell(feed):
        feed.event(2, "door_opened", door="gate")
        feed.event(3, "lane_closed", lane=["lab", "hall"], why="wet")
        feed.event(5, "door_opened", door="gate")

    both = {"all": [{"event": "door_opened"}, {"lane": ["lab", "hall"], "is": "closed"}]}

    assert [(0.0, False), (5.0, True), (5.0, False)] == sorted(
        spans(both, tell), key=lambda each: (each[0], not each[1])
    )


def test_a_late_recording_starts_with_the_state_of_its_scene():
    scene = {
        "robots": [
            {
                "name": "eve",
                "type": "nurse",
                "pose": [10.0, 0.0, 0.0],
                "motion": None,
                "ailments": {"battery_empty": "empty"},
                "battery": {"percentage": 0.0, "charging": False},
                "goals": [],
            }
        ],
        "items": [{"name": "medicine", "at": [20.0, 0.0], "carrier": None}],
        "fixtures": [{"name": "gate", "kind": "door", "tags": ["door", "open"]}],
        "closed_lanes": [{"lane": ["lab", "hall"], "why": "wet"}],
        "faults": [{"fault": "slip", "name": "s", "robot": "eve"}],
    }
    conditions = [
        {"robot": "eve", "at": "hall", "is": "stopped"},
        {"battery": "eve", "below": 0.1},
        {"item": "medicine", "at": "ward_a"},
        {"door": "gate", "is": "open"},
        {"lane": ["lab", "hall"], "is": "closed"},
        {"fault": "slip", "robot": "eve"},
        {"not": {"robot": "wall_e", "is": "idle"}},
    ]

    feed = Feed({"as_said": {"always": {"all": conditions}}}).scene(500.0, **scene).end(600.0)

    assert [] == feed.violations


def test_later_scenes_are_ignored():
    """They may be older than the events."""
    feed = Feed({"away": {"never": {"robot": "eve", "at": "hall"}}}).scene(0.0, robots=[], items=[], fixtures=[])
    there = {"name": "eve", "type": "nurse", "pose": [10.0, 0.0, 0.0], "goals": []}
    feed.scene(5.0, robots=[there], items=[], fixtures=[]).end(9.0)

    assert [] == feed.violations


def test_a_reset_restores_the_initial_state_and_time_continues():
    feed = Feed({"away": {"never": {"robot": "eve", "at": "hall"}}})
    feed.event(1.0, "teleported", entity="eve", at=[10.0, 0.0], yaw=0.0)
    feed.event(90.0, "reset", scope=255).event(0.0, "participant_joined", participant="bt")
    feed.event(3.0, "teleported", entity="eve", at=[10.0, 0.0], yaw=0.0).end(10.0)

    assert [(1.0, "away"), (93.0, "away")] == [each[:2] for each in feed.violations]
