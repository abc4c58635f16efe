"""execute: a goal in one query, which is answered by the acceptance, by feedback if asked for, and by the result."""

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
    """A goal in one query, each of whose replies is taken as it comes."""

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
        """Return the bodies of the replies, once *until* says so of them."""
        return self._heard.wait(until)

    def all(self):
        """Return the replies when all have come."""
        assert self._ended.wait(PATIENCE), self._heard.items
        return self._heard.items

    def bodies(self):
        """Return what the replies say when all have come."""
        return [reply.body for reply in self.all()]


def begun(tester, name, request):
    """Return a goal that is executing."""
    execution = Execution(tester, name, request)
    accepted, *_ = execution.wait()
    assert accepted["accepted"], accepted
    return execution


def long_wait(goal_id=A, **fields):
    """Return the request of a goal that outlasts every test."""
    return {"goal_id": goal_id, "goal": {"time": {"sec": 1000}}, **fields}


class TestReplies:
    """What the replies are, and in which order they come."""

    def test_an_accepted_goal_is_answered_by_the_acceptance_and_the_result(self, fast, wait):
        """As send_goal and get_result answer, on one key; the encodings say which is which, too."""
        accepted, ended = Execution(fast, WAIT, {"goal_id": A, "goal": wait(7)}).all()

        assert {"accepted": True, "goal_id": A, "stamp": {"sec": 0, "nanosec": 1}} == accepted.body
        assert fast.result(WAIT, A) == ended.body
        assert [(True, "hmrsim/wall_e/wait/_action/execute")] * 2 == [(each.ok, each.key) for each in (accepted, ended)]
        assert [
            "application/json;nav2_msgs/action/Wait_SendGoal_Response",
            "application/json;nav2_msgs/action/Wait_GetResult_Response",
        ] == [accepted.encoding, ended.encoding]

    def test_by_default_a_get_has_the_result_alone(self, fast, wait):
        """Zenoh keeps the latest reply on a key: a goal is one question with one answer."""
        (reply,) = fast.ask(f"{WAIT}/_action/execute", {"goal_id": A, "goal": wait(7)})

        assert fast.result(WAIT, A) == reply.body

    def test_the_acceptance_comes_while_the_goal_goes_on(self, live):
        """It is not kept for the end."""
        begun(live, WAIT, long_wait())

        assert [(A, 2)] == live.status(WAIT)

    def test_a_goal_without_id_gets_one(self, fast, go):
        """The acceptance says which."""
        accepted, ended = Execution(fast, NAVIGATE, {"goal": go(5, 2)}).bodies()

        assert ended == fast.result(NAVIGATE, accepted["goal_id"])

    def test_the_replies_are_on_the_name_that_was_asked(self, fast, go):
        """An action's further name is as good as its own."""
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
        """As send_goal answers; there will be no result."""
        request = {"goal_id": goal_id, "goal": goal, "feedback": True}
        if how == "each":
            (reply,) = Execution(shared, name, request).all()
        else:
            (reply,) = shared.ask(f"{name}/_action/execute", request)

        assert (True, reason) == (reply.ok, reply.body["reason"])
        assert shared.send(name, goal, goal_id) == reply.body


class TestFeedback:
    """Feedback in between, if asked for."""

    def test_it_comes_between_acceptance_and_result(self, serve, go):
        """The same messages as on the topic, the last one at the goal's end."""
        tester = serve(real_time_factor=20.0)
        topic = tester.hear(f"{NAVIGATE}/_action/feedback")

        goal = Execution(tester, NAVIGATE, {"goal_id": A, "goal": go(9, 2), "feedback": True})
        accepted, *between, ended = goal.all()

        assert (True, 4) == (accepted.body["accepted"], ended.body["status"])
        (encoding,) = {each.encoding for each in between}
        assert "application/json;nav2_msgs/action/NavigateToPose_FeedbackMessage" == encoding
        assert 0.0 == between[-1].body["feedback"]["distance_remaining"]
        assert [each.body for each in between] == topic.wait(lambda bodies: len(bodies) == len(between))

    def test_it_comes_without_another_subscriber(self, fast, go):
        """Nobody else has to listen, and all of it is of this goal."""
        _, *between, _ = Execution(fast, NAVIGATE, {"goal_id": A, "goal": go(9, 2), "feedback": True}).bodies()

        assert {A} == {each["goal_id"] for each in between}

    def test_each_query_has_that_of_its_own_goal(self, fast, go):
        """Also where two robots have a goal of the same id."""
        goals = [Execution(fast, f"{robot}/navigate_to_pose", _far(go, robot)) for robot in ("wall_e", "eve")]

        last = [goal.bodies()[-2]["feedback"]["current_pose"]["pose"]["position"]["x"] for goal in goals]
        assert [5.0, 1.0] == last

    @pytest.mark.parametrize("asked", [{}, {"feedback": False}])
    def test_it_does_not_come_unasked(self, fast, go, asked):
        """Although a subscriber gets it."""
        topic = fast.hear(f"{NAVIGATE}/_action/feedback")

        bodies = Execution(fast, NAVIGATE, {"goal": go(9, 2), **asked}).bodies()

        assert topic.wait(bool)
        assert [True, 4] == [bodies[0]["accepted"], bodies[1]["status"]]

    def test_by_default_a_get_has_the_result_alone(self, fast, go):
        """The latest reply is not the last feedback."""
        (reply,) = fast.ask(f"{NAVIGATE}/_action/execute", {"goal": go(9, 2), "feedback": True})

        assert 4 == reply.body["status"]

    def test_none_is_made_after_the_goal(self, serve, go):
        """What has no listener is not computed."""
        tester = serve(real_time_factor=0)
        Execution(tester, NAVIGATE, {"goal": go(9, 2), "feedback": True}).all()
        tester.status(NAVIGATE)  # answered after what came of the goal's end

        assert not serve.hosts[0].simulator.interest.feedback


def _far(go, robot):
    """Return the request to drive one of two robots past the other."""
    return {"goal_id": A, "goal": go(5 if robot == "wall_e" else 1, 2), "feedback": True}


class TestEnds:
    """However it ends, an accepted goal has one result."""

    @pytest.mark.parametrize("feedback", [False, True])
    def test_it_can_be_canceled(self, live, feedback):
        """By its id, over another query."""
        goal = begun(live, WAIT, long_wait(feedback=feedback))

        live.cancel(WAIT, A)

        assert [5] == [body["status"] for body in goal.bodies() if "status" in body]

    def test_another_goal_preempts_it(self, live, wait):
        """It is told by which."""
        goal = begun(live, WAIT, long_wait())

        live.send(WAIT, wait(1000), B)

        _, ended = goal.bodies()
        assert (6, f"preempted by goal {B}") == (ended["status"], ended["result"]["error_msg"])

    def test_a_goal_of_the_same_id_is_rejected(self, live):
        """The first one goes on, and its query has its result."""
        goal = begun(live, WAIT, long_wait())

        (again,) = Execution(live, WAIT, long_wait()).bodies()

        assert (False, "duplicate_goal_id", 2) == (again["accepted"], again["reason"], again["status"])
        live.cancel(WAIT, A)
        assert [True, 5] == [goal.bodies()[0]["accepted"], goal.bodies()[1]["status"]]

    def test_others_may_ask_for_the_result_too(self, live):
        """By get_result, while it goes on and afterwards."""
        goal = begun(live, WAIT, long_wait())
        held = live.begin(f"{WAIT}/_action/get_result", {"goal_id": A})

        live.cancel(WAIT, A)

        assert goal.bodies()[-1] == held.one() == live.result(WAIT, A)

    @pytest.mark.parametrize(
        ("service", "request_", "text"),
        [
            ("delete_entity", {"entity": "wall_e"}, "the robot was deleted"),
            ("reset_simulation", {}, "the simulation was reset"),
            ("load_world", {"resource_string": '{"robots": {"zoe": {"at": [0, 0]}}}'}, "another world was loaded"),
        ],
    )
    def test_it_is_aborted_by_what_takes_its_robot(self, live, service, request_, text):
        """With the reason."""
        goal = begun(live, WAIT, long_wait(feedback=True))

        live.one(f"_world/{service}", request_)

        ended = goal.bodies()[-1]
        assert (6, text) == (ended["status"], ended["result"]["error_msg"])

    def test_it_is_aborted_at_the_end_of_the_simulator(self, live, serve):
        """The query does not end before."""
        goal = begun(live, WAIT, long_wait(feedback=True))

        serve.hosts[0].stop()

        ended = goal.bodies()[-1]
        assert (6, "the simulator was stopped") == (ended["status"], ended["result"]["error_msg"])

    def test_it_goes_on_when_its_client_has_gone(self, live, serve):
        """Another client gets its result."""
        dying = serve.tester(serve.hosts[0])
        begun(dying, WAIT, long_wait(feedback=True))

        dying.close()

        assert [(A, 2)] == live.status(WAIT)
        live.cancel(WAIT, A)
        assert 5 == live.result(WAIT, A)["status"]

    def test_what_is_left_at_a_timeout_is_the_acceptance(self, live):
        """A get that gives up learns the goal's id, with which its result can be asked for."""
        request = json.dumps({"goal": {"time": {"sec": 1000}}})

        replies = [*live.session.get(live.key(f"{WAIT}/_action/execute"), payload=request, timeout=3.0)]

        # Zenoh gives them in either order, and on a busy machine not always the timeout.
        (goal_id,) = [json.loads(reply.ok.payload.to_string())["goal_id"] for reply in replies if reply.ok]
        assert {"Timeout"}.issuperset(reply.err.payload.to_string() for reply in replies if reply.err)
        live.cancel(WAIT, goal_id)
        assert 5 == live.result(WAIT, goal_id)["status"]

    def test_the_result_is_held_until_the_connection_is_back(self, serve, wait):
        """The robot goes on meanwhile, and no feedback comes."""
        tester = serve(real_time_factor=10.0)
        goal = begun(tester, WAIT, {"goal_id": A, "goal": wait(10), "feedback": True})
        tester.one("_world/inject_fault", {"type": "messages_lost", "robot": "wall_e", "duration": 20.0})

        *_, ended = goal.bodies()

        assert (4, {"sec": 10, "nanosec": 0}) == (ended["status"], ended["result"]["total_elapsed_time"])
        assert 20 <= tester.one("_world/clock")["clock"]["sec"]

    def test_in_lockstep_it_is_held_until_time_advances(self, serve, wait):
        """A participant is woken by its end as by that of any other goal."""
        tester = serve(clock="lockstep")
        goal = begun(tester, WAIT, {"goal_id": A, "goal": wait(3)})
        tester.one("_world/time/join", {"name": "nurse"})
        advance = {"participant": "nurse", "epoch": 0, "until": None, "wake": ["result"]}

        granted = tester.one("_world/time/advance", advance)

        assert (3.0, "event") == (granted["now"], granted["reason"])
        assert [A] == [each["goal_id"] for each in granted["events"]]
        assert 4 == goal.bodies()[-1]["status"]

    def test_a_thousand_at_once_have_one_result_each(self, serve, wait):
        """Of one robot, so that each preempts the one before."""
        tester = serve(real_time_factor=0)

        goals = [Execution(tester, WAIT, {"goal": wait(1), "feedback": True}) for _ in range(1000)]

        ends = [[body["status"] for body in goal.bodies() if "status" in body] for goal in goals]
        assert {1} == {len(each) for each in ends}
        assert [4] == ends[-1]


class TestUnreadable:
    """What can't be read gets one error reply, and nothing is executed."""

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
    def test_the_error_says_where_the_mistake_is(self, shared, request_, field, message):
        """As for send_goal."""
        (reply,) = Execution(shared, NAVIGATE, request_).all()

        (detail,) = reply.body["details"]
        assert (False, field) == (reply.ok, detail["field"])
        assert message in detail["message"]
        assert [] == shared.status(NAVIGATE)

    def test_feedback_is_no_part_of_send_goal(self, shared):
        """A field that would be ignored is refused."""
        (reply,) = shared.ask(f"{NAVIGATE}/_action/send_goal", {"goal": {}, "feedback": True})

        assert not reply.ok
