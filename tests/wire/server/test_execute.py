"""execute: a goal in one query, answered by the acceptance, by feedback on request, and by the result."""

from __future__ import annotations

import json
import threading

import pytest
import zenoh

from tests.patience import PATIENCE
from tests.wire.server.conftest import Heard

A, B = "a" * 32, "b" * 32
NAVIGATE = "wall_e/navigate_to_pose"
WAIT = "wall_e/wait"


class Execution:
    """A goal in one query, whose replies are stored as they come."""

    def __init__(self, tester, name, request):
        self._heard = Heard()
        self._ended = threading.Event()
        handler = zenoh.handlers.Callback(self._heard.on_reply, self._ended.set, indirect=False)
        tester.session.get(
            tester.key(f"{name}/_action/execute"),
            handler,
            payload=json.dumps(request),
            timeout=PATIENCE,
            consolidation=zenoh.ConsolidationMode.NONE,
        )

    def wait(self, until=bool):
        """Return the bodies of the replies, once *until* holds for them."""
        return self._heard.wait(until)

    def all(self):
        assert self._ended.wait(PATIENCE), self._heard.items
        return self._heard.items

    def bodies(self):
        """Return the bodies of all replies, once the query has ended."""
        return [reply.body for reply in self.all()]


def begun(tester, name, request):
    execution = Execution(tester, name, request)
    accepted, *_ = execution.wait()
    assert accepted["accepted"], accepted
    return execution


def long_wait(goal_id=A, **fields):
    """Return the request of a goal that outlasts every test."""
    return {"goal_id": goal_id, "goal": {"time": {"sec": 1000}}, **fields}


class TestReplies:
    def test_an_accepted_goal_is_answered_by_the_acceptance_and_the_result(self, fast, wait):
        accepted, ended = Execution(fast, WAIT, {"goal_id": A, "goal": wait(7)}).all()

        assert {"accepted": True, "goal_id": A, "stamp": {"sec": 0, "nanosec": 1}} == accepted.body
        assert fast.result(WAIT, A) == ended.body
        assert [(True, "hmrsim/wall_e/wait/_action/execute")] * 2 == [(each.ok, each.key) for each in (accepted, ended)]
        assert [
            "application/json;nav2_msgs/action/Wait_SendGoal_Response",
            "application/json;nav2_msgs/action/Wait_GetResult_Response",
        ] == [accepted.encoding, ended.encoding]

    def test_by_default_a_get_has_the_result_alone(self, fast, wait):
        """By default, Zenoh keeps the latest reply on a key."""
        (reply,) = fast.ask(f"{WAIT}/_action/execute", {"goal_id": A, "goal": wait(7)})

        assert fast.result(WAIT, A) == reply.body

    def test_the_acceptance_comes_while_the_goal_runs(self, live):
        begun(live, WAIT, long_wait())

        assert [(A, 2)] == live.status(WAIT)

    def test_a_goal_without_id_gets_one(self, fast, go):
        accepted, ended = Execution(fast, NAVIGATE, {"goal": go(5, 2)}).bodies()

        assert ended == fast.result(NAVIGATE, accepted["goal_id"])

    def test_the_replies_are_on_the_alias_of_the_query(self, fast, go):
        replies = Execution(fast, "navigate_to_pose/wall_e", {"goal": go(5, 2)}).all()

        assert ["hmrsim/navigate_to_pose/wall_e/_action/execute"] * 2 == [reply.key for reply in replies]
        assert 4 == replies[-1].body["status"]

    @pytest.mark.parametrize("how", ["each", "latest"])
    @pytest.mark.parametrize(
        ("name", "goal", "goal_id", "reason"),
        [
            (NAVIGATE, {}, "not-a-uuid", "invalid_goal_id"),
            ("nobody/wait", {}, A, "unknown_robot"),
            ("wall_e/fly", {"wings": 2}, A, "unknown_action"),
            (NAVIGATE, {"pose": {"header": {"frame_id": "odom"}}}, A, "invalid_goal"),
        ],
    )
    def test_a_rejected_goal_is_answered_once(self, shared, name, goal, goal_id, reason, how):
        request = {"goal_id": goal_id, "goal": goal, "feedback": True}
        if how == "each":
            (reply,) = Execution(shared, name, request).all()
        else:
            (reply,) = shared.ask(f"{name}/_action/execute", request)

        assert (True, reason) == (reply.ok, reply.body["reason"])
        assert shared.send(name, goal, goal_id) == reply.body


class TestFeedback:
    def test_feedback_comes_between_acceptance_and_result(self, serve, go):
        tester = serve(real_time_factor=20.0)
        topic = tester.hear(f"{NAVIGATE}/_action/feedback")

        goal = Execution(tester, NAVIGATE, {"goal_id": A, "goal": go(9, 2), "feedback": True})
        accepted, *between, ended = goal.all()

        assert (True, 4) == (accepted.body["accepted"], ended.body["status"])
        (encoding,) = {each.encoding for each in between}
        assert "application/json;nav2_msgs/action/NavigateToPose_FeedbackMessage" == encoding
        assert 0.0 == between[-1].body["feedback"]["distance_remaining"]
        assert [each.body for each in between] == topic.wait(lambda bodies: len(bodies) == len(between))

    def test_feedback_needs_no_subscriber(self, fast, go):
        _, *between, _ = Execution(fast, NAVIGATE, {"goal_id": A, "goal": go(9, 2), "feedback": True}).bodies()

        assert {A} == {each["goal_id"] for each in between}

    def test_each_query_has_the_feedback_of_its_goal(self, fast, go):
        """Two robots have goals of the same id."""
        goals = [Execution(fast, f"{robot}/navigate_to_pose", _far(go, robot)) for robot in ("wall_e", "eve")]

        last = [goal.bodies()[-2]["feedback"]["current_pose"]["pose"]["position"]["x"] for goal in goals]
        assert [5.0, 1.0] == last

    @pytest.mark.parametrize("asked", [{}, {"feedback": False}])
    def test_feedback_does_not_come_by_default(self, fast, go, asked):
        topic = fast.hear(f"{NAVIGATE}/_action/feedback")

        bodies = Execution(fast, NAVIGATE, {"goal": go(9, 2), **asked}).bodies()

        assert topic.wait(bool)
        assert [True, 4] == [bodies[0]["accepted"], bodies[1]["status"]]

    def test_with_feedback_a_default_get_has_the_result_alone(self, fast, go):
        (reply,) = fast.ask(f"{NAVIGATE}/_action/execute", {"goal": go(9, 2), "feedback": True})

        assert 4 == reply.body["status"]

    def test_no_feedback_is_computed_after_the_goal(self, serve, go):
        tester = serve(real_time_factor=0)
        Execution(tester, NAVIGATE, {"goal": go(9, 2), "feedback": True}).all()
        tester.status(NAVIGATE)  # answered after what came of the goal's end

        assert not serve.hosts[0].simulator.interest.feedback


def _far(go, robot):
    """Return the request to drive one of two robots past the other."""
    return {"goal_id": A, "goal": go(5 if robot == "wall_e" else 1, 2), "feedback": True}


class TestEnds:
    """An accepted goal has exactly one result."""

    @pytest.mark.parametrize("feedback", [False, True])
    def test_a_goal_can_be_canceled_by_another_query(self, live, feedback):
        goal = begun(live, WAIT, long_wait(feedback=feedback))

        live.cancel(WAIT, A)

        assert [5] == [body["status"] for body in goal.bodies() if "status" in body]

    def test_a_goal_of_the_same_id_is_rejected(self, live):
        """The query of the first goal still gets its result."""
        goal = begun(live, WAIT, long_wait())

        (again,) = Execution(live, WAIT, long_wait()).bodies()

        assert (False, "duplicate_goal_id", 2) == (again["accepted"], again["reason"], again["status"])
        live.cancel(WAIT, A)
        assert [True, 5] == [goal.bodies()[0]["accepted"], goal.bodies()[1]["status"]]

    def test_other_clients_can_get_the_result(self, live):
        goal = begun(live, WAIT, long_wait())
        held = live.begin(f"{WAIT}/_action/get_result", {"goal_id": A})

        live.cancel(WAIT, A)

        assert goal.bodies()[-1] == held.one() == live.result(WAIT, A)

    def test_a_goal_is_aborted_before_the_simulator_ends(self, live, serve):
        goal = begun(live, WAIT, long_wait(feedback=True))

        serve.hosts[0].stop()

        ended = goal.bodies()[-1]
        assert (6, "the simulator was stopped") == (ended["status"], ended["result"]["error_msg"])

    def test_a_get_that_times_out_still_has_the_acceptance(self, live):
        """The acceptance has the id with which to request the result."""
        request = json.dumps({"goal": {"time": {"sec": 1000}}})

        replies = [*live.session.get(live.key(f"{WAIT}/_action/execute"), payload=request, timeout=3.0)]

        # Zenoh gives them in either order, and on a busy machine not always the timeout.
        (goal_id,) = [json.loads(reply.ok.payload.to_string())["goal_id"] for reply in replies if reply.ok]
        assert {"Timeout"}.issuperset(reply.err.payload.to_string() for reply in replies if reply.err)
        live.cancel(WAIT, goal_id)
        assert 5 == live.result(WAIT, goal_id)["status"]

    def test_the_result_is_held_until_the_connection_is_back(self, serve, wait):
        """The robot continues meanwhile, without feedback."""
        tester = serve(real_time_factor=10.0)
        goal = begun(tester, WAIT, {"goal_id": A, "goal": wait(10), "feedback": True})
        tester.one("_world/inject_fault", {"type": "messages_lost", "robot": "wall_e", "duration": 20.0})

        *_, ended = goal.bodies()

        assert (4, {"sec": 10, "nanosec": 0}) == (ended["status"], ended["result"]["total_elapsed_time"])
        assert 20 <= tester.one("_world/clock")["clock"]["sec"]

    def test_in_lockstep_the_result_is_held_until_time_advances(self, serve, wait):
        tester = serve(clock="lockstep")
        goal = begun(tester, WAIT, {"goal_id": A, "goal": wait(3)})
        tester.one("_world/time/join", {"name": "nurse"})
        advance = {"participant": "nurse", "epoch": 0, "until": None, "wake": ["result"]}

        granted = tester.one("_world/time/advance", advance)

        assert (3.0, "event") == (granted["now"], granted["reason"])
        assert [A] == [each["goal_id"] for each in granted["events"]]
        assert 4 == goal.bodies()[-1]["status"]

    def test_a_thousand_goals_at_once_have_one_result_each(self, serve, wait):
        """All are for one robot, so each preempts the previous one."""
        tester = serve(real_time_factor=0)

        goals = [Execution(tester, WAIT, {"goal": wait(1), "feedback": True}) for _ in range(1000)]

        ends = [[body["status"] for body in goal.bodies() if "status" in body] for goal in goals]
        assert {1} == {len(each) for each in ends}
        assert [4] == ends[-1]


class TestUnreadable:
    @pytest.mark.parametrize(
        ("request_", "field", "message"),
        [
            ({}, "goal", "required"),
            ({"goal": {"speed": 2.5}}, "goal.speed", "not permitted"),
            ({"goal": {}, "feedback": "yes"}, "feedback", "valid boolean"),
            ({"goal": {}, "feedback": None}, "feedback", "valid boolean"),
            ({"goal": {}, "priority": 7}, "priority", "not permitted"),
            ([], "", "an object"),
        ],
    )
    def test_a_malformed_request_gets_one_error_with_the_field(self, shared, request_, field, message):
        (reply,) = Execution(shared, NAVIGATE, request_).all()

        (detail,) = reply.body["details"]
        assert (False, field) == (reply.ok, detail["field"])
        assert message in detail["message"]
        assert [] == shared.status(NAVIGATE)

    def test_send_goal_rejects_the_feedback_field(self, shared):
        (reply,) = shared.ask(f"{NAVIGATE}/_action/send_goal", {"goal": {}, "feedback": True})

        assert not reply.ok
