"""A robot stays where a goal has ended until its client can have sent the next one."""

from __future__ import annotations

import pytest

from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup, Place, PlaceLocation
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, DockRobot
from hmrsim.protocol.commands import SendGoal
from tests.unit.hmrsim.traffic.runs import end, go, under

A, B, C, D = (letter * 32 for letter in "abcd")
FORK = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0], "bay": [10, 5]},
    "lanes": [["a", "b"], ["b", "c"], ["b", "bay"]],
    "walls": [[[8, -0.5], [8, -2]]],
    "docks": {"dock": {"at": [10, -1], "staging": [10, 0]}},
    "items": {"parcel": {"at": [10, 0.5]}},
    "robots": {"ann": {"at": "a", "components": {"claw": {}}}, "bob": {"at": "c"}},
}
MEET = (0.0, go("ann", 10, 0, A)), (1.0, go("bob", 0, 0, B))
"""Ann arrives at b at 10 s, where bob has to pass."""
GRAB = SendGoal("ann", "pickup", Pickup.Goal(target_name="parcel"), C)
SINCE = "ann was at b until traffic moved it aside for bob at 15 s, and is at bay now: drive there again"


def end_of(log, goal_id):
    """Return the last status of a goal."""
    return log.changes(goal_id)[-1][1]


every_policy = pytest.mark.parametrize("policy", ["priority", "planned"])


def moved(log):
    """Return when robots made room, and which."""
    return [(at, told["robot"]) for at, told in log.happened("made_room")]


@every_policy
def test_a_robot_that_has_arrived_waits_for_its_next_goal(policy):
    log = under(policy, FORK)(*MEET, (14.9, GRAB))

    assert (14.9, "SUCCEEDED") == log.changes(C)[-1]


@every_policy
def test_it_makes_room_once_its_next_goal_is_overdue(policy):
    log = under(policy, FORK)(*MEET)

    assert [(15.0, "ann")] == moved(log)
    assert "SUCCEEDED" == end(log, B)[1]


@every_policy
def test_it_makes_room_at_once_if_its_controller_decides_at_the_same_instant(policy):
    run = under(policy, FORK)
    run.simulator.submit(go("ann", 10, 0, A), "a participant in lockstep")
    log = run(MEET[1])

    assert [(10.0, "ann")] == moved(log)


@every_policy
def test_it_makes_room_at_once_if_a_script_drives_it(policy):
    robots = {**FORK["robots"], "ann": {"at": "a", "script": ["Go b"]}}
    log = under(policy, {**FORK, "robots": robots})(MEET[1])

    assert [(10.0, "ann")] == moved(log)


def test_a_goal_that_ends_where_the_robot_is_renews_the_grace():
    log = under("planned", FORK)(*MEET, (12.0, go("ann", 10, 0, C)))

    assert [(17.0, "ann")] == moved(log)


def test_further_goals_to_where_the_robot_is_do_not_renew_the_grace():
    """Otherwise, a client that repeats one would keep the robot there forever."""
    run = under("planned", FORK)
    repeated = [(12.0 + number, go("ann", 10, 0, letter * 32)) for number, letter in enumerate("1234")]
    run(*MEET, *repeated, until=16.0)
    chain = run.simulator.roster.admission.causes.chain(run.simulator.robots["ann"])
    log = run(until=30.0)

    why = "it was sent to where it already stands 4 times in a row, and navigate_to_pose SUCCEEDED at 15 s"
    assert f"ann is idle at b: {why}" == chain.links[0].text
    assert chain.help.startswith("send ann elsewhere")
    assert [(17.0, "ann")] == moved(log)


def test_a_robot_whose_last_goal_failed_was_not_sent_to_where_it_is():
    run = under("planned", FORK)
    failing = (15.0, SendGoal("ann", "pickup", Pickup.Goal(target_name="nothing"), "4" * 32))
    run(*MEET, *((12.0 + number, go("ann", 10, 0, str(number) * 32)) for number in (1, 2)), failing, until=16.0)
    chain = run.simulator.roster.admission.causes.chain(run.simulator.robots["ann"])

    assert "ann is idle at b: it has had no goal since pickup ABORTED at 15 s" == chain.links[0].text


def test_work_renews_the_grace():
    log = under("planned", FORK)(*MEET, (12.0, GRAB))

    assert [(17.0, "ann")] == moved(log)


def test_a_plan_does_not_renew_the_grace():
    plan = ComputePathToPose.Goal(goal=PoseStamped(pose=Pose(position=Point(x=20.0))))
    log = under("planned", FORK)(*MEET, (12.0, SendGoal("ann", "compute_path_to_pose", plan, C)))

    assert [(15.0, "ann")] == moved(log)


def test_the_grace_is_a_setting():
    log = under("planned", FORK, grace=0.0)(*MEET)

    assert [(10.0, "ann")] == moved(log)


def test_the_robot_that_waits_knows_why():
    run = under("planned", FORK)
    run(*MEET, until=12.0)
    chain = run.simulator.roster.admission.causes.chain(run.simulator.robots["bob"])

    why = "which makes no room before 15 s, so that its controller can send the next goal"
    assert f"bob has waited at c since 1 s for ann, {why}" == chain.links[0].text


def test_a_pickup_that_fails_as_traffic_has_moved_the_robot_says_so():
    log = under("planned", FORK)(*MEET, (25.0, GRAB))

    assert f"'parcel' is out of reach: 4.500 m away, reach 1; {SINCE}" == log.result(C).error_code.message


def test_a_place_that_fails_as_traffic_has_moved_the_robot_says_so():
    at_b = PlaceLocation(place_pose=PoseStamped(pose=Pose(position=Point(x=10.0, y=0.0))))
    place = SendGoal("ann", "place", Place.Goal(place_locations=[at_b]), D)
    log = under("planned", FORK)(*MEET, (12.0, GRAB), (27.0, place))

    text = "none of 1 place locations is within reach, which is 1 m; "
    assert text + SINCE.replace("15", "17") == log.result(D).error_code.message


def test_nothing_is_placed_where_traffic_has_moved_the_robot():
    place = SendGoal("ann", "place", Place.Goal(), D)
    log = under("planned", FORK)(*MEET, (12.0, GRAB), (27.0, place))

    assert f"the robot is not where it was sent; {SINCE}".replace("15", "17") == log.result(D).error_code.message
    assert "moved" == log.goal_changes(D)[-1].cause


def test_after_a_goal_that_failed_an_item_is_placed_where_the_robot_is():
    """Nobody counts on where it is, and a dispatcher has to get rid of an item that it can't deliver."""
    failed = SendGoal("ann", "pickup", Pickup.Goal(target_name="nothing"), B)
    log = under("planned", FORK)(*MEET, (12.0, GRAB), (27.0, failed), (28.0, SendGoal("ann", "place", Place.Goal(), D)))

    assert "SUCCEEDED" == end_of(log, D)


def test_a_robot_that_was_to_make_room_at_this_instant_has_not_been_moved():
    run = under("planned", FORK)
    commands = [go("ann", 10, 0, A), MEET[1][1], GRAB, SendGoal("ann", "place", Place.Goal(), D)]
    for at, command in zip((0.0, 1.0, 10.0, 10.0), commands, strict=True):
        run.simulator.advance(at)
        run.simulator.submit(command, "a participant in lockstep")

    assert ["SUCCEEDED"] * 2 == [end_of(run(until=11.0), goal_id) for goal_id in (C, D)]


def test_docking_that_fails_as_traffic_has_moved_the_robot_says_so():
    straight = SendGoal("ann", "dock_robot", DockRobot.Goal(dock_id="dock", navigate_to_staging_pose=False), C)
    walls = [[[9, 2], [11, 2]]]
    log = under("planned", {**FORK, "walls": walls})(*MEET, (25.0, straight))

    assert log.result(C).error_msg.endswith(f"; {SINCE}")


def test_a_drive_ends_what_traffic_has_done():
    log = under("planned", FORK)(*MEET, (25.0, go("ann", 20, 0, C)), (45.0, GRAB._replace(goal_id=D)))

    assert "'parcel' is out of reach: 10.012 m away, reach 1" == log.result(D).error_code.message


@pytest.mark.parametrize("scope", [1, 2, 0])
def test_a_robot_does_not_linger_after_a_reset(scope):
    """The scopes are time, state, and all."""
    run = under("planned", FORK)
    run(*MEET, until=12.0)
    run.ask("reset_simulation", {"scope": scope})

    assert (False, 0.0) == (run.simulator.robots["ann"].busy, run.simulator.robots["ann"].stays_until)


def test_a_robot_that_is_deleted_while_it_lingers_leaves_its_place_for_good():
    run = under("planned", FORK)
    run(*MEET, until=12.0)
    run.ask("delete_entity", {"entity": "ann"})
    log = run((40.0, go("bob", 10, 0, D)), until=60.0)

    assert ["SUCCEEDED"] * 2 == [end_of(log, goal_id) for goal_id in (B, D)]
