"""External planners: their requests, and the effect of each answer."""

from __future__ import annotations

import math

import pytest

from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.interfaces.simulation_interfaces import SetSimulationState, SimulationState
from hmrsim.protocol.commands import Advance, CallService, CancelGoal, PlanAnswered, PlannerPresent
from hmrsim.protocol.outputs import PlanWanted
from hmrsim.protocol.time import Join
from hmrsim.protocol.topics import Topic
from hmrsim.trace.replay import replay
from tests.simulation import A, B, C, at, in_lockstep, send, simulate

HERE = PlannerPresent(True)
WORLD = {
    "bounds": [0, 0, 20, 10],
    "waypoints": {"home": [1, 2], "shelf": [9, 2]},
    "lanes": [["home", "shelf"]],
    "walls": [[[12, 0], [12, 5]]],
    "robots": {
        "eve": {"at": "home", "yaw": 0.5, "planner": "external"},
        "bob": {"at": "shelf", "planner": "external"},
        "wall_e": {"at": "home"},
    },
}


def go(x, y, goal_id=A, robot="eve", yaw=0.0):
    return send("navigate_to_pose", goal_id, robot, pose=at(x, y, yaw))


def answer(request, *points, **fields):
    result = {"path": {"poses": [at(*point) for point in points]}, **fields}
    return PlanAnswered(request, ComputePathToPose.Result.model_validate(result))


@pytest.fixture
def outside():
    run = simulate(WORLD)
    run((0.0, HERE), until=0.0)
    return run


def wanted(log):
    return [(time, event.request, event.robot) for time, event in log.events if isinstance(event, PlanWanted)]


class TestPresence:
    @pytest.mark.parametrize(
        ("action", "goal"),
        [
            ("navigate_to_pose", {"pose": at(9, 2)}),
            ("navigate_through_poses", {"poses": {"goals": [at(9, 2)]}}),
            ("follow_waypoints", {"poses": [at(9, 2)]}),
        ],
    )
    def test_without_a_planner_a_goal_is_rejected(self, action, goal):
        run = simulate(WORLD)
        log = run(
            (0.0, send(action, robot="eve", **goal)),
            (1.0, HERE),
            (1.0, send(action, B, "eve", **goal)),
            (2.0, PlannerPresent(False)),
            (2.0, send(action, C, "eve", **goal)),
            until=2.0,
        )

        assert [False, True, False] == [log.answer(each).accepted for each in (A, B, C)]
        assert "not_ready" == log.answer(A).reason
        assert "eve has an external planner, and none has announced itself" == log.answer(A).error_msg

    def test_its_presence_is_published_once(self):
        run = simulate(WORLD)
        log = run((1.0, HERE), (2.0, HERE), (3.0, PlannerPresent(False)))

        assert [(1.0, {"present": True}), (3.0, {"present": False})] == log.happened("planner")

    def test_other_robots_don_t_need_it(self):
        assert "SUCCEEDED" == simulate(WORLD)((0.0, go(9, 2, robot="wall_e"))).changes(A)[-1][1]


class TestPath:
    def test_the_request_has_start_and_goal(self, outside):
        log = outside((3.0, go(9, 2, yaw=1.0)), until=4.0)
        (asked,) = [event for _, event in log.events if isinstance(event, PlanWanted)]
        start, goal = asked.goal.start.pose, asked.goal.goal.pose

        assert [(3.0, 1, "eve")] == wanted(log)
        assert asked.goal.use_start
        assert (1.0, 2.0) == (start.position.x, start.position.y)
        assert (9.0, 2.0) == (goal.position.x, goal.position.y)
        assert (math.sin(0.25), math.sin(0.5)) == (start.orientation.z, goal.orientation.z)
        assert [(3.0, {"robot": "eve", "request": 1})] == log.happened("plan_wanted")

    def test_the_robot_drives_straight_from_pose_to_pose(self, outside):
        log = outside((0.0, go(4, 6, yaw=1.0)), (2.0, answer(1, (1, 2), (1, 6), (4, 6, 3.0))))

        assert (2.0 + 4.0 + 3.0, "SUCCEEDED") == log.changes(A)[-1]
        assert (4.0, 6.0, 1.0) == outside.simulator.robots["eve"].pose()

    def test_the_robot_first_drives_to_the_start_of_the_path(self, outside):
        log = outside((0.0, go(4, 6)), (0.0, answer(1, (1, 6), (4, 6))))

        assert (7.0, "SUCCEEDED") == log.changes(A)[-1]

    def test_the_robot_stops_at_the_end_of_the_path(self, outside):
        """Nav2's controller knows only the path, too."""
        log = outside((0.0, go(4, 6)), (0.0, answer(1, (1, 2), (1, 6))))

        assert (4.0, "SUCCEEDED") == log.changes(A)[-1]
        assert (1.0, 6.0) == outside.simulator.robots["eve"].pose().point

    def test_an_obstacle_stops_the_robot_before_the_blocked_segment(self, outside):
        log = outside((0.0, go(15, 2)), (0.0, answer(1, (9, 2), (15, 2))))

        assert (8.0, "ABORTED") == log.changes(A)[-1]
        assert 106 == log.result(A).error_code
        assert "blocked: an obstacle stands between (9, 2) and (15, 2)" == log.result(A).error_msg
        assert (9.0, 2.0) == outside.simulator.robots["eve"].pose().point

    @pytest.mark.parametrize(
        ("given", "code", "text"),
        [
            (answer(1), 208, "the planner gave a path without poses"),
            (answer(1, error_code=204, error_msg="off the map"), 204, "off the map"),
            (answer(1, (1, 2), error_code=200), 200, "the planner gave code 200"),
        ],
    )
    def test_without_a_path_the_goal_is_aborted(self, outside, given, code, text):
        log = outside((0.0, go(9, 2)), (1.0, given))

        assert (1.0, "ABORTED") == log.changes(A)[-1]
        assert (code, text) == (log.result(A).error_code, log.result(A).error_msg)
        assert (1.0, 2.0) == outside.simulator.robots["eve"].pose().point

    def test_a_path_in_an_unknown_frame_is_aborted(self, outside):
        path = {"header": {"frame_id": "odom"}, "poses": [at(9, 2)]}
        log = outside((0.0, go(9, 2)), (1.0, answer(1, path=path)))

        assert (202, "the planner's path is in the unknown frame 'odom'; use 'map' or leave it empty") == (
            log.result(A).error_code,
            log.result(A).error_msg,
        )

    def test_a_path_through_poses_is_requested_leg_by_leg(self, outside):
        goal = {"poses": {"goals": [at(1, 6), at(4, 6)]}}
        log = outside(
            (0.0, send("navigate_through_poses", robot="eve", **goal)),
            (1.0, answer(1, (1, 2), (1, 6))),
            (2.0, answer(2, (1, 6), (4, 6))),
        )
        starts = [event.goal.start.pose.position.y for _, event in log.events if isinstance(event, PlanWanted)]

        assert [2.0, 6.0] == starts
        assert (9.0, "SUCCEEDED") == log.changes(A)[-1]

    def test_waypoints_are_requested_one_by_one(self, outside):
        log = outside(
            (0.0, send("follow_waypoints", robot="eve", poses=[at(1, 6), at(15, 2), at(4, 6)])),
            (1.0, answer(1, (1, 2), (1, 6))),
            (6.0, answer(2, error_code=208, error_msg="a wall")),
            (7.0, answer(3, (4, 6))),
        )

        assert [(0.0, 1, "eve"), (5.0, 2, "eve"), (6.0, 3, "eve")] == wanted(log)
        assert (10.0, "SUCCEEDED") == log.changes(A)[-1]
        assert [(1, 208)] == [(each.waypoint_index, each.error_code) for each in log.result(A).missed_waypoints]

    def test_a_given_path_needs_no_planner(self):
        log = simulate(WORLD)((0.0, send("follow_path", robot="eve", path={"poses": [at(9, 2)]})))

        assert (8.0, "SUCCEEDED") == log.changes(A)[-1]


class TestWaiting:
    def test_time_continues_while_a_plan_is_pending(self, outside):
        log = outside((0.0, go(9, 2)), (0.0, go(9, 2, goal_id=B, robot="wall_e")), until=8.0)

        assert (8.0, "SUCCEEDED") == log.changes(B)[-1]
        assert [0.0] == [*{feedback.distance_remaining for _, feedback in log.feedback(A)}]

    def test_a_cancel_works_at_once_and_a_late_answer_is_dropped(self, outside):
        log = outside((0.0, go(9, 2)), (1.0, CancelGoal("eve", "navigate_to_pose", A)), (2.0, answer(1, (9, 2))))

        assert (1.0, "CANCELED") == log.changes(A)[-1]
        assert (1.0, 2.0) == outside.simulator.robots["eve"].pose().point
        assert not outside.simulator.plans.awaited

    def test_an_answer_is_taken_while_the_simulation_is_paused(self, outside):
        pause = SetSimulationState.Request(state=SimulationState(state=SimulationState.STATE_PAUSED))
        log = outside(
            (0.0, go(9, 2)),
            (1.0, CallService("set_simulation_state", pause)),
            (1.0, answer(1, error_code=208)),
            until=1.0,
        )

        assert (1.0, "ABORTED") == log.changes(A)[-1]

    def test_another_goal_preempts_a_pending_plan(self, outside):
        log = outside((0.0, go(9, 2)), (1.0, go(1, 6, goal_id=B)), (2.0, answer(1, (9, 2))), (3.0, answer(2, (1, 6))))

        assert (1.0, "ABORTED") == log.changes(A)[-1]
        assert (7.0, "SUCCEEDED") == log.changes(B)[-1]


class TestLockstep:
    @pytest.fixture
    def steps(self):
        run, lockstep = in_lockstep(WORLD, topics=frozenset({Topic.EVENTS}))
        run.simulator.submit(HERE)
        lockstep.join(Join("nurse", "join"), 0.0)
        return run, lockstep

    @staticmethod
    def move(lockstep):
        if lockstep.ready:
            lockstep.begin()
        while lockstep.proceed(3, 0.0):
            pass

    @staticmethod
    def ask(lockstep, *commands, until=math.inf):
        lockstep.advance(Advance("nurse", 0, until, frozenset({"result"}), commands=commands, reply_to="granted"), 0.0)

    def test_time_waits_for_the_path(self, steps):
        run, lockstep = steps
        self.ask(lockstep, go(9, 2), go(9, 2, goal_id=B, robot="wall_e"))
        self.move(lockstep)
        stood = (run.simulator.now, run.log.answers("granted"))
        run.simulator.plans.keep(answer(1, (5, 2)))
        self.move(lockstep)

        assert (0.0, []) == stood
        assert (4.0, "event") == run.log.answer("granted")[1:3]

    def test_paths_are_taken_in_order_of_their_requests(self):
        traces = []
        for order in ((1, 2), (2, 1)):
            run, lockstep = in_lockstep(WORLD, traced=True)
            run.simulator.submit(HERE)
            lockstep.join(Join("nurse"), 0.0)
            self.ask(lockstep, go(5, 2), go(5, 2, goal_id=B, robot="bob"))
            self.move(lockstep)
            for request in order:
                run.simulator.plans.keep(answer(request, (5, 2)))
                self.move(lockstep)
            traces.append("".join(run.lines()))

        assert '"command":"plan_answered"' in traces[0]
        assert traces[0] == traces[1]

    def test_pending_paths_are_taken_when_lockstep_ends(self, steps):
        run, lockstep = steps
        self.ask(lockstep, go(5, 2), go(5, 2, goal_id=B, robot="bob"))
        self.move(lockstep)
        run.simulator.plans.keep(answer(1, (5, 2)))
        lockstep.dismiss("the clock was set to realtime")
        run.simulator.run()

        assert (4.0, "SUCCEEDED") == run.log.changes(A)[-1]
        assert [2] == [*run.simulator.plans.awaited]

    def test_a_cancel_from_outside_resumes_time(self, steps):
        run, lockstep = steps
        self.ask(lockstep, go(9, 2))
        self.move(lockstep)
        run.simulator.submit(CancelGoal("eve", "navigate_to_pose", A))
        self.move(lockstep)

        assert (0.0, "event") == run.log.answer("granted")[1:3]


def test_a_replay_of_a_run_with_a_planner_is_identical():
    """The trace contains the presence and the answers of the planner."""
    run = simulate(WORLD, traced=True)
    run(
        (0.0, go(9, 2, goal_id=C)),
        (0.5, HERE),
        (1.0, go(9, 2)),
        (1.5, go(4, 6, goal_id=B)),
        (2.0, answer(1, (9, 2))),
        (2.5, answer(2, (1, 2), (1, 6), (4, 6))),
        (3.0, PlannerPresent(False)),
    )
    outcome = replay(run.lines())

    assert (9.5, "SUCCEEDED") == run.log.changes(B)[-1]
    assert (None, True) == (outcome.difference, outcome.complete)
    assert 6 == outcome.commands
