"""Robots under each of the traffic policies."""

from __future__ import annotations

import math
from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hmrsim.geometry import SAME_PLACE, distance, foot
from hmrsim.interfaces.geometry_msgs import Point
from hmrsim.interfaces.nav2_msgs import BackUp, FollowPath
from hmrsim.interfaces.simulation_interfaces import SpawnEntity
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.protocol.topics import Topic
from hmrsim.world_checks import load_world
from tests.profiles import examples
from tests.simulation import simulate
from tests.torture.missions import within
from tests.unit.hmrsim.traffic.runs import end, go, under

A, B, C = (letter * 32 for letter in "abc")
EVENTS = frozenset({Topic.EVENTS})
CROSS = {
    "waypoints": {"west": [0, 0], "centre": [10, 0], "east": [20, 0], "north": [10, 10], "south": [10, -10]},
    "lanes": [["west", "centre"], ["centre", "east"], ["north", "centre"], ["centre", "south"]],
    "robots": {"ann": {"at": "west"}, "bob": {"at": "north"}},
}
TRACK = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0], "bay": [10, 5]},
    "lanes": [["a", "b"], ["b", "c"], ["b", "bay"]],
    "robots": {"ann": {"at": "a"}, "bob": {"at": "c"}},
}
BYPASS = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0], "d": [30, 0], "up": [10, 5], "over": [20, 5]},
    "lanes": [["a", "b"], ["b", "c"], ["c", "d"], ["b", "up"], ["up", "over"], ["over", "c"]],
    "robots": {"ann": {"at": "a"}, "bob": {"at": "b"}},
}


class TestFree:
    def test_no_robot_waits(self):
        log = under("free", CROSS)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 10, -10, B)))

        assert [(20.0, "SUCCEEDED", "")] * 2 == [end(log, A), end(log, B)]
        assert [] == log.happened("waiting")


class TestReserve:
    """A robot holds the places that it occupies and those that come next."""

    def test_the_later_robot_waits_and_names_its_blocker(self):
        log = under("reserve", CROSS)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 10, -10, B)))

        waiting = {"robot": "bob", "at": [10.0, 10.0], "lane": ["north", "centre"], "for": ["ann"]}
        assert [(0.0, waiting)] == log.happened("waiting")
        assert [(10.0, {"robot": "bob", "waited": 10.0})] == log.happened("went_on")
        assert [(20.0, "SUCCEEDED", ""), (30.0, "SUCCEEDED", "")] == [end(log, A), end(log, B)]

    def test_a_wait_is_a_recovery_in_feedback(self):
        run = under("reserve", CROSS)
        log = run((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 10, -10, B)), until=5.0)
        _, feedback = log.feedback(B)[-1]

        assert (1, 20.0) == (feedback.number_of_recoveries, feedback.distance_remaining)

    def test_a_waypoint_can_hold_several_robots(self):
        centre = {"at": [10, 0], "capacity": 2}
        world = {**CROSS, "waypoints": {**CROSS["waypoints"], "centre": centre}}
        log = under("reserve", world)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 10, -10, B)))

        assert [(20.0, "SUCCEEDED", "")] * 2 == [end(log, A), end(log, B)]

    @pytest.mark.parametrize(("capacity", "ends"), [(1, 30.0), (2, 20.0)])
    def test_a_lane_can_hold_several_robots_in_both_directions(self, capacity, ends):
        lanes = [{"from": "west", "to": "east", "capacity": capacity}]
        waypoints = {"west": [0, 0], "east": [10, 0]}
        waypoints = {name: {"at": at, "capacity": 2} for name, at in waypoints.items()}
        robots = {"ann": {"at": "west"}, "bob": {"at": "east"}}
        run = under("reserve", {"waypoints": waypoints, "lanes": lanes, "robots": robots})
        log = run((10.0, go("ann", 10, 0, A)), (10.0, go("bob", 0, 0, B)))

        assert ends == end(log, B)[0]

    def test_patience_ends_a_goal_that_is_blocked(self):
        run = under("reserve", TRACK, patience=5.0)
        log = run((0.0, go("ann", 20, 0, A)))

        text = (
            "blocked for 5 s: ann has waited at b since 10 s for bob, which makes no room under the policy 'reserve';"
            " bob is idle at c: it has had no goal yet; what would help: send ann to a, then bob to bay, then ann to"
            " its goal again: bob can't leave before ann; or use the traffic policy `planned`, under which idle robots"
            " make room"
        )
        assert (15.0, "ABORTED", text) == end(log, A)
        assert FollowPath.Result.PATIENCE_EXCEEDED == log.result(A).error_code

    def test_a_robot_takes_a_detour_around_one_that_stays(self):
        world = {**BYPASS, "robots": {"ann": {"at": "b"}, "bob": {"at": "c"}}}
        waypoints = {**world["waypoints"], "end": [30, 5]}
        lanes = [*world["lanes"], ["over", "end"]]
        log = under("reserve", {**world, "waypoints": waypoints, "lanes": lanes})((0.0, go("ann", 30, 5, A)))

        assert (25.0, "SUCCEEDED", "") == end(log, A)

    def test_a_deadlock_is_reported_with_robots_and_lanes(self):
        log = under("reserve", TRACK)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

        told = {"robots": ["ann", "bob"], "lanes": [["b", "c"], ["c", "b"]]}
        assert [(10.0, told)] == log.happened("deadlock")

    def test_in_a_deadlock_the_last_robot_takes_a_detour(self):
        world = {**BYPASS, "robots": {"ann": {"at": "a"}, "bob": {"at": "d"}}}
        log = under("reserve", world)((0.0, go("ann", 30, 0, A)), (0.0, go("bob", 0, 0, B)))

        assert ["bob"] == [fields["robot"] for _, fields in log.happened("rerouted")]
        assert ["SUCCEEDED"] * 2 == [end(log, A)[1], end(log, B)[1]]

    def test_in_a_deadlock_a_robot_backs_off_where_there_is_room(self):
        log = under("reserve", TRACK)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

        made_room = {"robot": "ann", "by": "bob", "from": [10.0, 0.0], "to": [10.0, 5.0]}
        assert [(10.0, made_room)] == log.happened("made_room")
        assert [(35.0, "SUCCEEDED", ""), (30.0, "SUCCEEDED", "")] == [end(log, A), end(log, B)]

    def test_in_a_deadlock_without_a_way_out_one_robot_gives_up(self):
        world = {**TRACK, "lanes": TRACK["lanes"][:2]}
        log = under("reserve", world)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

        text = (
            "deadlock: ann waits for bob waits for ann; there is no other way;"
            " what would help: send one of them elsewhere, or add room where two can pass;"
            " or use the traffic policy `planned`, which resolves most circles"
        )
        assert (10.0, "ABORTED", text) == end(log, B)

    def test_a_goal_that_is_canceled_leaves_the_queue(self):
        run = under("reserve", CROSS)
        log = run(
            (0.0, go("ann", 20, 0, A)),
            (0.0, go("bob", 10, -10, B)),
            (5.0, CancelGoal("bob", "navigate_to_pose", B)),
            (30.0, go("ann", 0, 0, C)),
        )

        assert (50.0, "SUCCEEDED", "") == end(log, C)
        assert (10.0, 10.0) == run.simulator.robots["bob"].pose().point

    def test_two_robots_do_not_share_a_spot_off_the_lanes(self):
        """The second waits at the last waypoint, not in the middle of the lane."""
        world = {**CROSS, "robots": {"ann": {"at": "west"}, "bob": {"at": "east"}}}
        run = under("reserve", world)
        log = run((0.0, go("ann", 14, 4, A)), (0.0, go("bob", 14, 4, B)), until=30.0)

        assert "SUCCEEDED" == end(log, B)[1]
        assert (10.0, {"robot": "ann", "at": [10.0, 0.0], "lane": ["centre", "east"], "for": ["bob"]}) == log.happened(
            "waiting"
        )[-1]

    def test_a_flying_robot_blocks_no_robot_and_is_not_blocked(self):
        world = {**CROSS, "robots": {**CROSS["robots"], "fly": {"at": "centre", "base": {"flies": True}}}}
        log = under("reserve", world)((0.0, go("ann", 20, 0, A)), (0.0, go("fly", 0, 0, B)))

        assert [(20.0, "SUCCEEDED", ""), (10.0, "SUCCEEDED", "")] == [end(log, A), end(log, B)]


class TestPriority:
    """The robot that set out first makes the others make room."""

    def test_a_robot_that_makes_room_drives_from_where_it_stands(self):
        """After backing up it is beside the waypoint, and must not jump onto its lane."""
        world = {**TRACK, "robots": {"ann": {"at": "b"}, "bob": {"at": "a"}}}
        back = SendGoal("ann", "back_up", BackUp.Goal(target=Point(x=0.5), speed=0.5), A)
        log = under("priority", world)((0.0, back), (2.0, go("bob", 20, 0, B)))

        (_, backed), (_, aside) = ((at, told) for at, told in log.happened("motion") if told["robot"] == "ann")
        assert ([9.5, 0.0], [9.5, 0.0], [10.0, 5.0]) == (backed["to"][:2], aside["from"][:2], aside["to"][:2])

    def test_an_idle_robot_makes_room_and_stays_there(self):
        run = under("priority", TRACK)
        log = run((0.0, go("ann", 10, 0, A)), (20.0, go("bob", 0, 0, B)))

        assert (40.0, "SUCCEEDED", "") == end(log, B)
        assert (10.0, 5.0) == run.simulator.robots["ann"].pose().point

    def test_a_full_ring_moves_on_all_at_once(self):
        corners = {"a": [0, 0], "b": [10, 0], "c": [10, 10], "d": [0, 10]}
        ring = ["a", "b", "c", "d", "a"]
        world = {
            "waypoints": corners,
            "lanes": [list(pair) for pair in pairwise(ring)],
            "robots": {f"r_{name}": {"at": name} for name in corners},
        }
        goals = [go(f"r_{a}", *corners[b], a * 32) for a, b in pairwise(ring)]
        log = under("priority", world)(*[(0.0, goal) for goal in goals])

        assert [(10.0, "SUCCEEDED", "")] * 4 == [end(log, name * 32) for name in corners]

    def test_a_robot_at_work_does_not_make_room(self):
        run = under("priority", CROSS, patience=None, grace=0.0)
        run((0.0, go("ann", 10, 0, A)))
        wait = {"time": {"sec": 7}}
        run.simulator.submit(SendGoal("ann", "wait", _message("wait", wait), B))
        log = run((10.0, go("bob", 10, -10, C)))

        assert (37.0, "SUCCEEDED", "") == end(log, C)

    @pytest.mark.parametrize("policy", ["reserve", "priority"])
    def test_a_robot_on_its_way_out_of_a_dock_makes_room(self, policy):
        """One that stays in the dock makes none."""
        world = {**TRACK, "docks": {"dock": {"at": "c"}}, "robots": {"ann": {"at": "b"}, "bob": {"at": "c"}}}
        log = under(policy, world, patience=None)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

        assert ["SUCCEEDED"] * 2 == [end(log, A)[1], end(log, B)[1]]

    def test_a_goal_starts_after_making_room(self):
        run = under("priority", TRACK)
        log = run((0.0, go("ann", 10, 0, A)), (20.0, go("bob", 0, 0, B)), (22.0, go("ann", 20, 0, C)))

        assert (45.0, "SUCCEEDED", "") == end(log, C)

    def test_a_robot_in_the_middle_of_a_lane_makes_room_by_driving_to_its_end(self):
        run = under("priority", TRACK)
        run((0.0, go("bob", 15, 0, A)))
        log = run((10.0, go("ann", 20, 0, B)))

        assert ("SUCCEEDED", (20.0, 0.0)) == (end(log, B)[1], run.simulator.robots["ann"].pose().point)

    def test_in_a_deadlock_without_a_way_out_one_robot_gives_up(self):
        """Its patience does not matter."""
        world = {**TRACK, "lanes": TRACK["lanes"][:2]}
        log = under("priority", world, patience=None)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

        text = (
            "deadlock: ann waits for bob waits for ann; there is no other way;"
            " what would help: send one of them elsewhere, or add room where two can pass"
        )
        assert (10.0, "ABORTED", text) == end(log, B)


def _message(action, plain):
    from hmrsim.actions import registry  # noqa: PLC0415 - for one test

    return registry()[action].goal.model_validate(plain)


class TestPlacing:
    def test_a_lane_accepts_no_more_robots_than_its_capacity(self):
        run = under("reserve", CROSS)
        run.ask("set_entity_state", {"entity": "ann", "state": {"pose": {"position": {"x": 2.0}}}})
        answer = run.ask("set_entity_state", {"entity": "bob", "state": {"pose": {"position": {"x": 8.0}}}})

        text = "(8, 0) is on lane centre-west, which ann has, where there is no room for one more robot"
        assert text == answer.result.error_message

    def test_a_robot_spawned_onto_another_is_refused(self):
        world = {**CROSS, "robot_types": {"cart": {"base": {"radius": 0.5}}}}
        run = simulate({**world, "robots": {"ann": {"type": "cart", "at": "west"}}})
        pose = {"pose": {"position": {"x": 0.8, "y": 0.0}}}
        answer = run.ask("spawn_entity", {"name": "bob", "uri": "robot_type:cart", "initial_pose": pose})

        assert SpawnEntity.Response.INVALID_POSE == answer.result.result
        assert "(0.8, 0) is 0.8 from ann; keep 1 away" == answer.result.error_message


def grid(columns, rows, **robots):
    """Return a world in which every lane is part of a circle, and robots with starts and speeds."""
    at = {f"n{x}{y}": [x * 10.0, y * 10.0] for x in range(columns) for y in range(rows)}
    lanes = [[f"n{x}{y}", f"n{x + 1}{y}"] for x in range(columns - 1) for y in range(rows)]
    lanes += [[f"n{x}{y}", f"n{x}{y + 1}"] for x in range(columns) for y in range(rows - 1)]
    there = {name: {"at": start, "base": {"speed": speed}} for name, (start, speed) in robots.items()}
    return {"waypoints": at, "lanes": lanes, "robots": there}


@st.composite
def crowds(draw):
    """Return a random grid with robots, and the times of goals and cancels."""
    columns, rows = draw(st.sampled_from([(2, 2), (3, 2), (3, 3), (4, 3)]))
    names = sorted(grid(columns, rows)["waypoints"])
    number = draw(st.integers(2, max(2, len(names) * 2 // 3)))
    starts = draw(st.permutations(names))[:number]
    speeds = st.sampled_from([0.5, 1.0, 2.0])
    robots = {f"r{i}": (start, draw(speeds)) for i, start in enumerate(starts)}
    times = st.sampled_from([0.0, 0.0, 5.0, 7.5, 20.0])
    goals = [(draw(times), name, draw(st.sampled_from(names))) for name in robots]
    cancels = draw(st.lists(st.tuples(times, st.sampled_from(sorted(robots))), max_size=2))
    return grid(columns, rows, **robots), sorted(goals), sorted(cancels)


TWO_KNOTS = (
    grid(
        *(4, 3),
        r0=("n21", 1.0),
        r1=("n10", 1.0),
        r2=("n32", 1.0),
        r3=("n01", 1.0),
        r4=("n12", 0.5),
        r5=("n02", 1.0),
        r6=("n11", 1.0),
    ),
    [(0.0, "r4", "n10"), (0.0, "r5", "n11"), (0.0, "r6", "n30"), (20.0, "r3", "n21")],
    [],
)
"""A robot that is being moved for one other blocks a third one."""

ONE_YET_TO_ASK = (
    grid(3, 2, r0=("n10", 1.0), r1=("n11", 0.5), r2=("n00", 1.0), r3=("n20", 1.0)),
    [(0.0, "r2", "n01"), (7.5, "r0", "n21"), (7.5, "r3", "n21"), (20.0, "r1", "n20")],
    [],
)
"""A circle closes at the instant at which one that set out earlier would have it make room."""

STEPPED_BACK = (
    grid(3, 3, r0=("n12", 1.0), r2=("n00", 1.0), r3=("n01", 1.0), r4=("n11", 0.5), r5=("n22", 0.5)),
    [(0.0, "r3", "n02"), (0.0, "r5", "n02"), (7.5, "r0", "n02"), (20.0, "r2", "n00")],
    [],
)
"""A robot steps back at the instant at which it set out to make room."""

MIDDLE_OF_A_LANE = (
    grid(3, 2, r0=("n01", 1.0), r1=("n21", 0.5), r2=("n20", 2.0), r3=("n00", 0.5)),
    [(0.0, "r0", "n11"), (0.0, "r2", "n01"), (5.0, "r1", "n01")],
    [(0.0, "r0")],
)
"""A robot that was stopped on a lane can leave it by one end only, where another one has to make room, too."""

BESIDE_EACH_OTHER = [(12, 22), (2, 12), (10, 11), (11, 12), (11, 21), (0, 1), (1, 2), (1, 11)]
TWO_RESOLUTIONS = (
    {
        "waypoints": {f"n{i:02}": [i // 10 * 10.0, i % 10 * 10.0] for i in (0, 1, 2, 10, 11, 12, 21, 22)},
        "lanes": [[f"n{a:02}", f"n{b:02}"] for a, b in BESIDE_EACH_OTHER],
        "robots": {f"r{i}": {"at": start} for i, start in enumerate(["n02", "n01", "n12", "n00", "n10"])},
    },
    [(0.0, f"r{i}", goal) for i, goal in enumerate(["n10", "n10", "n02", "n22", "n10"])],
    [],
)
"""Each of two robots had a third one moved to and fro, which was then in the way of the other one."""


def check_places(simulator):
    """Fail if two robots are at one waypoint or on one lane."""
    lanes = simulator.graph.lanes
    there = Counter()
    for robot in simulator.robots.values():
        point = robot.pose().point
        node = next((i for i, other in enumerate(lanes.points) if distance(point, other) <= SAME_PLACE), None)
        if robot.sets_out:
            continue
        tracks = [
            track
            for track in lanes.tracks
            if distance(point, foot(point, *(simulator.world.points[end] for end in track))) <= SAME_PLACE
        ]
        there[lanes.names[node] if node is not None else tracks[0]] += 1
    assert [] == [(place, number) for place, number in there.items() if number > 1], simulator.now


@pytest.mark.parametrize("policy", ["reserve", "priority", "planned"])
@examples(40, share_fixtures=True)
@given(crowd=crowds())
@example(crowd=TWO_KNOTS)
@example(crowd=ONE_YET_TO_ASK)
@example(crowd=STEPPED_BACK)
@example(crowd=MIDDLE_OF_A_LANE)
@example(crowd=TWO_RESOLUTIONS)
def test_never_two_in_one_place_and_every_goal_ends(policy, crowd):
    """Without cancels, priority and planned bring every robot to its goal."""
    world, goals, cancels = crowd
    patience = {} if policy == "reserve" else {"patience": None}
    run = simulate({**world, "traffic": {"policy": policy, **patience}}, topics=EVENTS)
    simulator = run.simulator
    points = world["waypoints"]
    commands = [(at, go(name, *points[goal], f"{i:032x}")) for i, (at, name, goal) in enumerate(goals, 1)]
    commands += [(at + 1.0, CancelGoal(name, "navigate_to_pose")) for at, name in cancels]
    for at, command in sorted(commands, key=lambda timed: timed[0]):
        while simulator.process_events(at, 1):
            check_places(simulator)
        simulator.advance(at)
        simulator.submit(command)
        check_places(simulator)
    while simulator.process_events(math.inf, 1, idle=False):
        check_places(simulator)

    ends = [run.log.changes(command.goal_id)[-1][1] for _, command in commands if isinstance(command, SendGoal)]
    assert {"SUCCEEDED", "ABORTED", "CANCELED"}.issuperset(ends)
    if policy != "reserve" and not cancels:
        assert {"SUCCEEDED"} == set(ends)


class TestAfterwards:
    def test_a_broken_robot_makes_no_room(self):
        run = under("priority", TRACK)
        run((0.0, go("bob", 10, 0, A)))
        run.ask("inject_fault", {"type": "breakdown", "robot": "bob"})
        run((10.0, go("ann", 20, 0, B)))

        assert (10.0, 0.0) == run.simulator.robots["bob"].pose().point

    def test_a_reset_of_time_stops_a_robot_that_makes_room(self):
        run = under("priority", TRACK)
        run((0.0, go("bob", 10, 0, A)))
        run((10.0, go("ann", 20, 0, B)), until=22.0)
        run.ask("reset_simulation", {"scope": 1})
        run.ask("set_entity_state", {"entity": "ann", "state": {"pose": {"position": {"x": 0.0}}}})
        log = run((1.0, go("bob", 20, 0, C)))

        assert "SUCCEEDED" == end(log, C)[1]

    @pytest.mark.parametrize("policy", ["reserve", "priority", "planned"])
    def test_a_run_after_a_reset_is_the_same_run(self, policy):
        run = under(policy, TRACK)
        ends = []
        for number in "12":
            first, second = (f"{number}{letter}" * 16 for letter in "ab")
            log = run((0.0, go("ann", 20, 0, first)), (0.0, go("bob", 0, 0, second)))
            ends.append((end(log, first), end(log, second), len(log.happened("deadlock"))))
            run.ask("reset_simulation")

        assert ends[0][:2] == ends[1][:2]
        assert 2 * ends[0][2] == ends[1][2]

    def test_a_robot_deleted_while_it_makes_room_leaves_nothing_behind(self):
        run = under("priority", TRACK)
        run((0.0, go("bob", 10, 0, A)))
        log = run((10.0, go("ann", 20, 0, B)), until=22.0)
        run.ask("delete_entity", {"entity": "bob"})
        run.simulator.run()
        log = run((40.0, go("ann", 10, 5, C)))

        assert "SUCCEEDED" == end(log, C)[1]

    def test_a_detour_counts_the_rides_of_lifts(self):
        world = {
            "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0], "d": [10, 10], "e": [10, -10]},
            "lanes": [["a", "b"], ["b", "c"], ["a", "d"], ["d", "c"], ["a", "e"]],
            "lifts": {"slow": {"stops": ["e", "c"], "travel_time": 500}},
            "robots": {"ann": {"at": "a"}, "bob": {"at": "b"}},
        }
        log = under("reserve", world)((0.0, go("ann", 20, 0, A)))

        assert (28.28, "SUCCEEDED") == (round(end(log, A)[0], 2), end(log, A)[1])

    def test_a_robot_that_turns_on_its_new_route_no_longer_waits(self):
        world = {
            "waypoints": {"a": [0, 0], "b": [4, 0], "c": [8, 0], "d": [4, 3], "e": [0, 4], "f": [12, 0]},
            "lanes": [["a", "b"], ["b", "c"], ["a", "d"], ["d", "c"], ["e", "a"], ["c", "f"]],
            "robots": {"q": {"at": "a", "base": {"turning_rate": 0.05}}, "r": {"at": "b"}, "s": {"at": "e"}},
        }
        run = under("reserve", world)
        log = run((0.0, go("q", 8, 0, A)), (1.0, go("r", 12, 0, B)), (1.0, go("s", 0, 0, C)))

        assert ["SUCCEEDED"] * 3 == [end(log, goal)[1] for goal in (A, B, C)]
        assert 15.0 < end(log, C)[0]

    def test_a_lane_that_is_left_at_its_end_needs_the_waypoint_there(self):
        """The goal is off the lanes."""
        world = {
            "waypoints": {"a": [0, 0], "b": [4, 0], "x": [8, 1], "y": [12, 1]},
            "lanes": [{"from": "a", "to": "b", "one_way": True}, ["x", "y"]],
            "robots": {"ann": {"at": "a"}, "bob": {"at": "b"}},
        }
        run = under("reserve", world)
        run((0.0, go("ann", 8, 0, A)), until=30.0)

        assert (0.0, 0.0) == run.simulator.robots["ann"].pose().point


WIDE = {"base": {"radius": 0.3}}


def wide(*names):
    """Return the track with robots that have a radius."""
    robots = {name: {**robot, **(WIDE if name in names else {})} for name, robot in TRACK["robots"].items()}
    return {**TRACK, "robots": robots, "robot_types": {"wide": WIDE}}


def test_robots_with_bodies_do_not_drive_through_each_other():
    log = simulate(wide("ann", "bob"))((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

    assert log.happened("made_room")
    assert ["SUCCEEDED", "SUCCEEDED"] == [end(log, goal)[1] for goal in (A, B)]


def test_robots_without_bodies_pass_through_each_other():
    log = simulate(TRACK)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

    assert [(20.0, "SUCCEEDED", "")] * 2 == [end(log, A), end(log, B)]


def test_a_robot_that_is_spawned_does_not_change_the_policy():
    """The spawned robot passes through one with a body."""
    run = simulate(wide("ann"))
    pose = {"pose": {"position": {"x": 10.0, "y": 5.0}}}
    run.ask("spawn_entity", {"name": "new", "uri": "robot_type:wide", "initial_pose": pose})
    log = run((0.0, go("ann", 20, 0, A)), (0.0, go("new", 0, 0, B)))

    assert [(20.0, "SUCCEEDED", ""), (15.0, "SUCCEEDED", "")] == [end(log, A), end(log, B)]


def test_a_robot_in_a_docks_queue_is_not_asked_to_go_first():
    """A random mission found this case."""
    seen = within(load_world("zoo/charger_queue"), 5_000_363)

    assert "deadlock" in seen.trace
    assert "internal_error" not in seen.trace
