"""Routes on the graph, and tracking of robots along them."""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.actions import registry as actions
from hmrsim.actions.compute_and_track_route import RouteTracker
from hmrsim.geometry import yaw_of
from hmrsim.interfaces.nav2_msgs import FollowPath
from hmrsim.protocol.commands import CallService, CancelGoal, SendGoal
from hmrsim.services import registry as services
from tests import simulation
from tests.profiles import examples
from tests.simulation import A, B, C, at, simulate

# A square with 10 m sides and a lane to the east; the numbers of waypoints are 0 to 4, lanes begin at 5.
WORLD = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [10, 10], "d": [0, 10], "e": [20, 0]},
    "lanes": [["a", "b"], ["b", "c"], ["c", "d"], ["d", "a"], {"from": "b", "to": "e", "speed_limit": 0.5}],
    "robots": {"r": {"at": "a"}},
}


def route(*to, ident=A, action="compute_route", **fields):
    given = {"use_poses": True, "goal": at(*to), **fields} if to else fields
    return SendGoal("r", action, actions()[action].goal.model_validate(given), ident, ident)


track = partial(route, action="compute_and_track_route")


def go(x, y, goal_id=B):
    return simulation.go(x, y, goal_id, "r")


def ask(service, **request):
    return CallService(service, services()[service].request.model_validate(request))


def nodes_of(found):
    return [node.nodeid for node in found.nodes]


def told(log, goal_id=A):
    """Return feedback as (time, last waypoint, next waypoint, lane, rerouted)."""
    found = {}
    for time, one in log.feedback(goal_id):
        found.setdefault((one.last_node_id, one.next_node_id, one.current_edge_id, one.rerouted), time)
    return [(time, *values) for values, time in found.items()]


def operations(log):
    return [(time, one.operations_triggered) for time, one in log.feedback(A) if one.operations_triggered]


class TestComputeRoute:
    def test_it_has_the_numbers_of_the_route_graph(self, make_run):
        result = make_run(WORLD)((0.0, route(20, 0))).result(A)

        assert [0, 1, 4] == nodes_of(result.route)
        assert [5, 13] == [edge.edgeid for edge in result.route.edges]
        assert 30.0 == result.route.route_cost
        assert "map" == result.route.header.frame_id

    def test_the_path_has_a_pose_at_each_waypoint(self, make_run):
        poses = make_run(WORLD)((0.0, route(start_id=1, goal_id=3))).result(A).path.poses

        assert [(10, 0, 3.1416), (0, 0, 1.5708), (0, 10, 1.5708)] == [
            (at.pose.position.x, at.pose.position.y, round(yaw_of(at.pose.orientation.z, at.pose.orientation.w), 4))
            for at in poses
        ]

    def test_it_spans_only_the_waypoints_between_robot_and_goal(self, make_run):
        run = make_run(WORLD | {"robots": {"r": {"at": [4, 1]}}})

        assert [1] == nodes_of(run((0.0, route(15, 0))).result(A).route)

    def test_within_one_lane_it_is_the_waypoint_nearest_to_the_goal(self, make_run):
        run = make_run(WORLD | {"robots": {"r": {"at": [4, 0]}}})
        result = run((0.0, route(7, 0))).result(A)

        assert ([1], [], 0.0) == (nodes_of(result.route), result.route.edges, result.route.route_cost)
        assert 1 == len(result.path.poses)

    def test_a_given_start_replaces_the_robot_s_pose(self, make_run):
        log = make_run(WORLD)((0.0, route(10, 10, start=at(20, 0), use_start=True)))

        assert [4, 1, 2] == nodes_of(log.result(A).route)

    def test_a_closed_lane_is_avoided_and_the_others_keep_their_ids(self, make_run):
        faults = [{"type": "lane_closed", "lane": ["a", "b"]}]
        result = make_run(WORLD | {"faults": faults})((1.0, route(10, 0))).result(A)

        assert [0, 3, 2, 1] == nodes_of(result.route)
        assert [12, 10, 8] == [edge.edgeid for edge in result.route.edges]
        assert 30.0 == result.route.route_cost

    def test_a_flying_robot_gets_a_route_on_the_graph(self, make_run):
        run = make_run(WORLD | {"robots": {"r": {"at": "a", "base": {"flies": True}}}})

        assert [0, 1, 4] == nodes_of(run((0.0, route(20, 0))).result(A).route)

    @pytest.mark.parametrize(
        ("goal", "code", "text"),
        [
            ({"goal_id": 5}, 400, "no waypoint has the id 5; ids are 0 to 4"),
            ({"use_poses": True, "goal": at(1e9, 0)}, 403, "target (1e+09, 0) is outside any map"),
            ({"start_id": 0, "goal_id": 4}, 405, "no route from a to e"),
        ],
    )
    def test_without_a_route_the_error_has_nav2_s_code(self, make_run, goal, code, text):
        faults = [{"type": "lane_closed", "lane": ["b", "e"]}]
        log = make_run(WORLD | {"faults": faults})((1.0, route(**goal)))

        assert (1.0, "ABORTED") == log.changes(A)[-1]
        assert code == log.result(A).error_code
        assert log.result(A).error_msg.startswith(text)

    @pytest.mark.parametrize(("start", "goal"), [(0, 5), (5, 2)])
    def test_routes_between_waypoint_ids_use_lanes_only(self, make_run, start, goal):
        """As in Nav2's route server, a waypoint without a lane is unreachable by id, but reachable by pose."""
        world = WORLD | {"waypoints": {**WORLD["waypoints"], "alone": [5, 5]}}
        run = make_run(world)
        result = run((0.0, route(start_id=start, goal_id=goal))).result(A)

        assert 405 == result.error_code
        assert result.error_msg.startswith("no lanes lead from ")
        assert [5] == nodes_of(run((0.0, route(start_id=5, goal_id=5, ident=B))).result(B).route)

    def test_a_world_without_waypoints_has_no_graph(self, make_run):
        assert 402 == make_run({"robots": {"r": {"at": [0, 0]}}})((0.0, route(5, 0))).result(A).error_code

    def test_poses_in_an_unknown_frame_matter_only_if_they_are_used(self, make_run):
        odom = {"header": {"frame_id": "odom"}}
        log = make_run(WORLD)((0.0, route(use_poses=True, goal=odom)), (0.0, route(ident=B, goal=odom)))

        assert (False, "invalid_goal") == (log.answer(A).accepted, log.answer(A).reason)
        assert log.answer(B).accepted


class TestComputeAndTrackRoute:
    def test_feedback_reports_each_passed_waypoint(self, make_run):
        log = make_run(WORLD)((0.0, track(0, 10, start_id=0)), (1.0, go(0, 10)))

        assert [(0, 0, 0, 0, True), (0, 0, 3, 12, False), (10.0, 3, 0, 0, False)] == told(log)
        assert (10.0, "SUCCEEDED") == log.changes(A)[-1]
        assert 10.0 == log.result(A).execution_duration.to_seconds()

    def test_a_speed_limit_that_begins_or_ends_is_an_operation(self, make_run):
        log = make_run(WORLD)((0.0, track(start_id=0, goal_id=4)), (0.0, go(20, 0)))

        assert [(10.0, ["AdjustSpeedLimit"])] == operations(log)

    def test_tracking_schedules_nothing_while_the_robot_stands(self, make_run):
        run = make_run(WORLD)
        log = run((0.0, track(20, 0)))

        assert (0, "EXECUTING") == log.changes(A)[-1]
        assert run.simulator.dispatcher.goal_of("r") is None

    def test_a_cancel_ends_tracking_but_not_the_drive(self, make_run):
        log = make_run(WORLD)(
            (0.0, track(20, 0)), (0.0, go(20, 0)), (3.0, CancelGoal("r", "compute_and_track_route", A))
        )

        assert (3.0, "CANCELED") == log.changes(A)[-1]
        assert (30.0, "SUCCEEDED") == log.changes(B)[-1]

    def test_a_canceled_goal_is_freed(self, make_run, collect):
        """No pending event may keep the goal in memory."""
        run = make_run(WORLD, topics=frozenset())
        for _ in range(3):
            run((0.0, track(20, 0, ident=None)), (0.0, CancelGoal("r", "compute_and_track_route")))

        assert [] == collect(RouteTracker)

    def test_another_tracking_goal_preempts_it(self, make_run):
        log = make_run(WORLD)((0.0, track(20, 0)), (0.0, go(20, 0)), (3.0, track(20, 0, ident=C)))

        assert (3.0, "ABORTED") == log.changes(A)[-1]
        assert f"preempted by goal {C}" == log.result(A).error_msg
        assert (28.0, "SUCCEEDED") == log.changes(C)[-1]
        assert (30.0, "SUCCEEDED") == log.changes(B)[-1]

    def test_it_reroutes_around_a_lane_that_closes_ahead(self, make_run):
        faults = [{"type": "lane_closed", "lane": ["b", "c"], "at": 4}]
        log = make_run(WORLD | {"faults": faults})((0.0, track(start_id=0, goal_id=2)), (5.0, go(10, 10)))
        routes = {time: nodes_of(one.route) for time, one in log.feedback(A)}

        assert [(4.0, ["CollisionMonitor"])] == operations(log)
        assert ([0, 1, 2], [0, 3, 2]) == (routes[0], routes[4.0])
        assert "SUCCEEDED" == log.changes(A)[-1][1]

    def test_a_new_route_begins_at_the_end_of_the_current_lane(self, make_run):
        world = WORLD | {"faults": [{"type": "lane_closed", "lane": ["b", "c"], "at": 6}]}
        world["waypoints"] = WORLD["waypoints"] | {"f": [15, 5]}
        world["lanes"] = [*WORLD["lanes"], ["b", "f"], ["f", "c"]]
        log = make_run(world)((0.0, track(start_id=0, goal_id=2)), (0.0, go(10, 10)))

        assert (6.0, 0, 1, 6, True) in told(log)
        assert [1, 5, 2] == nodes_of([one for _, one in log.feedback(A) if one.rerouted][-1].route)

    def test_without_another_route_it_fails(self, make_run):
        faults = [{"type": "lane_closed", "lane": ["b", "e"], "at": 4}]
        log = make_run(WORLD | {"faults": faults})((0.0, track(20, 0)), until=5.0)

        assert (4.0, "ABORTED") == log.changes(A)[-1]
        assert 405 == log.result(A).error_code

    def test_a_moved_robot_is_tracked_from_its_new_pose(self, make_run):
        """The robot is moved onto the last waypoint, but still has to achieve the first one."""
        run = make_run(WORLD)
        there = {"entity": "r", "state": {"pose": {"position": {"x": 10.0, "y": 0.0}}}}
        log = run((0.0, track(10, 0)), (2.0, ask("set_entity_state", **there)))

        assert (2.0, "SUCCEEDED") == log.changes(A)[-1]

    def test_a_robot_with_acceleration_is_tracked(self, make_run):
        world = WORLD | {"robots": {"r": {"at": "a", "base": {"acceleration": 0.5, "turning_rate": 1.0}}}}
        log = make_run(world)((0.0, track(start_id=0, goal_id=2)), (0.0, go(10, 10)))

        assert [0, 1, 2] == [last for _, last, _, _, new in told(log) if not new]
        assert "SUCCEEDED" == log.changes(A)[-1][1]

    def test_a_robot_near_a_waypoint_passes_it(self, make_run):
        """The robot passes 1.5 m beside a waypoint when abreast of it."""
        path = {"path": {"poses": [at(0, 0.5), at(20, 0.5)]}}
        follow = SendGoal("r", "follow_path", FollowPath.Goal.model_validate(path), B)
        log = make_run(WORLD)((0.0, track(20, 0)), (0.0, follow))

        assert [0, 1, 4] == [last for _, last, _, _, new in told(log) if not new]
        assert (10.5, 1) == told(log)[2][:2]


cells = st.tuples(st.integers(-4, 4), st.integers(-4, 4))
speeds = st.floats(0.2, 5.0)


@given(st.lists(cells, min_size=2, max_size=6, unique=True), speeds, st.none() | speeds, st.none() | speeds)
@examples(20)
def test_every_waypoint_is_passed_in_order(points, speed, acceleration, turning_rate):
    """The chain of lanes may lead back over itself."""
    names = "abcdef"[: len(points)]
    base = {"speed": speed, "acceleration": acceleration, "turning_rate": turning_rate}
    world = {
        "waypoints": dict(zip(names, ([2.0 * x, 2.0 * y] for x, y in points), strict=True)),
        "lanes": [[*pair] for pair in pairwise(names)],
        "robots": {"r": {"at": names[0], "base": {key: value for key, value in base.items() if value is not None}}},
    }
    last = len(points) - 1
    x, y = points[last]
    log = simulate(world, feedback_rate=0.01)((0.0, track(goal_id=last)), (0.0, go(2.0 * x, 2.0 * y)))

    assert [*range(last + 1)] == [passed for _, passed, _, _, new in told(log) if not new]
    assert "SUCCEEDED" == log.changes(A)[-1][1] == log.changes(B)[-1][1]
    assert log.changes(A)[-1][0] <= log.changes(B)[-1][0]
