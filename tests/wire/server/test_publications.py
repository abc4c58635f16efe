"""Published messages: status, feedback, odometry, clock and events, their order and names."""

from __future__ import annotations

import itertools
import json
import time

import pytest
import zenoh

from tests.wire.server.conftest import Heard, statuses

A, B = "a" * 32, "b" * 32
NAVIGATE = "wall_e/navigate_to_pose"
ALIAS = "navigate_to_pose/wall_e"
WAIT = "wall_e/wait"
STATUS = "wall_e/navigate_to_pose/_action/status"
FEEDBACK = "wall_e/navigate_to_pose/_action/feedback"


def nanoseconds(stamp):
    return stamp["sec"] * 1_000_000_000 + stamp["nanosec"]


class TestStatus:
    """The list of all remembered goals, published at each transition."""

    def test_each_transition_is_published(self, fast, go):
        """A client that subscribes and then sends a goal gets all its transitions, however fast it ends."""
        heard = fast.hear(STATUS)

        fast.send(NAVIGATE, go(9, 2), A)

        assert [[(A, 1)], [(A, 2)], [(A, 4)]] == [statuses(body) for body in heard.wait_for_status(A, 4)]

    def test_the_first_status_of_a_first_subscriber_is_never_lost(self, serve, wait):
        owner = serve(real_time_factor=0)
        seen = []
        for number in range(1, 61):
            client = serve.tester(serve.hosts[0])
            heard = client.hear(f"{WAIT}/_action/status")
            goal_id = f"{number:032x}"
            client.send(WAIT, wait(1), goal_id)
            bodies = heard.wait_for_status(goal_id, 4)
            seen.append([dict(statuses(body))[goal_id] for body in bodies])
            client.close()

        assert [[1, 2, 4]] * 60 == seen
        assert 60 == len(owner.status(WAIT))


class TestFeedback:
    """Feedback comes at 10 Hz of simulated time."""

    def test_feedback_has_the_fields_of_kilted(self, serve, go):
        tester = serve(real_time_factor=0.5)
        heard = tester.hear(FEEDBACK)
        tester.send(NAVIGATE, go(1.25, 2), A)

        feedback = heard.wait(lambda bodies: bodies)[0]["feedback"]

        assert {
            "current_pose",
            "navigation_time",
            "estimated_time_remaining",
            "number_of_recoveries",
            "distance_remaining",
        } == set(feedback)
        assert "map" == feedback["current_pose"]["header"]["frame_id"]
        assert 1.1 == pytest.approx(feedback["current_pose"]["pose"]["position"]["x"])
        assert 150_000_000 == nanoseconds(feedback["estimated_time_remaining"])
        assert 0 == feedback["number_of_recoveries"]

    def test_a_client_gets_the_messages_of_a_goal_in_order(self, serve, go):
        tester = serve(real_time_factor=1.0)
        heard = tester.hear(STATUS, FEEDBACK)
        for verb, payload in {"send_goal": {"goal_id": A, "goal": go(1.25, 2)}, "get_result": {"goal_id": A}}.items():
            tester.session.get(
                tester.key(f"{NAVIGATE}/_action/{verb}"),
                zenoh.handlers.Callback(heard.on_reply, indirect=False),
                payload=json.dumps(payload),
                # By default Zenoh hands out a reply only after all replies have come, which may be a little later.
                consolidation=zenoh.ConsolidationMode.NONE,
            )

        heard.wait(lambda bodies: any("result" in body for body in bodies))
        tester.one("_world/clock")  # whatever was sent before this is here now

        order = [_told(body) for body in heard.bodies]
        assert ["accepted", 1, 2, "feedback", 4, "result"] == [told for told, _ in itertools.groupby(order)]

    def test_the_last_feedback_comes_at_the_greatest_speed(self, fast, go):
        heard = fast.hear(STATUS, FEEDBACK)

        fast.send(NAVIGATE, go(9, 2), A)

        bodies = heard.wait(lambda bodies: any("status_list" in body and (A, 4) in statuses(body) for body in bodies))
        assert 0 == bodies[-2]["feedback"]["distance_remaining"]
        assert 8_000_000_000 == nanoseconds(bodies[-2]["feedback"]["navigation_time"])

    def test_feedback_comes_at_most_twenty_times_per_wall_second(self, serve, wait):
        """A wait of 100 s has 1,000 samples in half a wall second."""
        tester = serve(real_time_factor=200.0)
        heard = tester.hear(f"{WAIT}/_action/feedback")
        began = time.monotonic()

        tester.do(WAIT, wait(100))

        took = time.monotonic() - began
        assert 1 <= len(heard.items) <= 2 + 20 * took

    def test_other_subscribers_do_not_change_the_times_of_feedback(self, serve, go):
        tester = serve(real_time_factor=0.5)
        heard = tester.hear(FEEDBACK)
        tester.send(NAVIGATE, go(1.55, 2), A)

        for _ in range(100):
            tester.session.declare_subscriber("hmrsim/_world/clock").undeclare()

        bodies = heard.wait(lambda bodies: bodies and bodies[-1]["feedback"]["distance_remaining"] == 0)
        times = [nanoseconds(body["feedback"]["navigation_time"]) // 1_000_000 for body in bodies]
        assert [100, 200, 300, 400, 500, 550] == times


def _told(body):
    """Return a short form of a message, to compare orders."""
    if "status_list" in body:
        return statuses(body)[0][1]
    return next(name for name in ("accepted", "feedback", "result") if name in body)


class TestAliases:
    """Further names of actions, from the world's remap table."""

    def test_a_goal_sent_by_its_real_name_can_be_canceled_by_alias(self, live, go):
        """Either name gives its result."""
        live.send(NAVIGATE, go(9, 2), A)

        assert 0 == live.cancel(ALIAS, A)["return_code"]
        assert [5, 5] == [live.result(name, A)["status"] for name in (NAVIGATE, ALIAS)]

    @pytest.mark.parametrize("name", [NAVIGATE, ALIAS])
    def test_feedback_and_status_appear_under_both_names(self, serve, go, name):
        tester = serve(real_time_factor=1.0)
        real = tester.hear(STATUS, FEEDBACK)
        alias = tester.hear(f"{ALIAS}/_action/status", f"{ALIAS}/_action/feedback")

        tester.send(name, go(1.25, 2), A)

        for heard in (real, alias):
            heard.wait(lambda bodies: any("status_list" in body and (A, 4) in statuses(body) for body in bodies))
        assert real.bodies == alias.bodies
        assert any("feedback" in body for body in real.bodies)

    def test_a_status_queried_by_alias_is_answered_on_the_alias(self, fast, go):
        fast.send(NAVIGATE, go(9, 2), A)
        fast.result(NAVIGATE, A)

        (reply,) = fast.ask(f"{ALIAS}/_action/status")

        assert ("hmrsim/navigate_to_pose/wall_e/_action/status", [(A, 4)]) == (reply.key, statuses(reply.body))

    def test_an_alias_has_the_encoding_of_its_action(self, fast):
        (reply,) = fast.ask("wall_e/grab/_action/send_goal", {"goal_id": A, "goal": {"target_name": "letter"}})

        assert (True, "application/json;moveit_msgs/action/Pickup_SendGoal_Response") == (
            reply.body["accepted"],
            reply.encoding,
        )
        assert 1 == fast.result("wall_e/pickup", A)["result"]["error_code"]["val"]


class TestWorld:
    def test_the_clock_ticks_ten_times_a_second_without_other_events(self, live):
        live.one("_world/clock")
        heard = live.hear("_world/clock")

        bodies = heard.wait(lambda bodies: len(bodies) >= 4)

        times = [nanoseconds(body["clock"]) for body in bodies]
        assert {100_000_000} == {after - before for before, after in itertools.pairwise(times)}
        assert {0} == {at % 100_000_000 for at in times}

    def test_the_clock_ticks_again_after_a_gap_without_subscribers(self, live):
        first = live.session.declare_subscriber("hmrsim/_world/clock")
        first.recv()
        first.undeclare()

        heard = live.hear("_world/clock")

        assert heard.wait(lambda bodies: len(bodies) >= 2)

    def test_the_clock_at_the_greatest_speed_stops_with_the_last_event(self, fast, wait):
        heard = fast.hear("_world/clock")

        fast.send(WAIT, wait(2), A)

        bodies = heard.wait(lambda bodies: bodies and nanoseconds(bodies[-1]["clock"]) == 2_000_000_000)
        times = [nanoseconds(body["clock"]) for body in bodies]
        assert sorted(set(times)) == times
        assert set(range(100_000_000, 2_000_000_001, 100_000_000)) <= set(times)

    def test_odometry_has_pose_and_velocity(self, serve, go):
        tester = serve(real_time_factor=5.0)
        heard = tester.hear("wall_e/odom")
        tester.do(NAVIGATE, go(3, 2))

        bodies = heard.wait(lambda bodies: bodies and bodies[-1]["pose"]["pose"]["position"]["x"] == 3)

        speeds = [body["twist"]["twist"]["linear"]["x"] for body in bodies]
        assert "wall_e/base_link" == bodies[0]["child_frame_id"]
        assert {0.0, 1.0} == set(speeds)
        assert 0.0 == speeds[-1]

    def test_events_report_goals_motion_and_items_with_their_times(self, fast, go):
        heard = fast.hear("_world/events")
        fast.send(NAVIGATE, go(5, 2), A)
        fast.result(NAVIGATE, A)
        fast.do("eve/pickup", {"target_name": "parcel"})
        fast.send("eve/place", {"attached_object_name": "parcel"}, B)

        bodies = heard.wait(lambda bodies: any(body.get("goal_id") == B and "result" in body for body in bodies))

        first = [{key: value for key, value in body.items() if key != "result"} for body in bodies[:6]]
        status = {"kind": "status", "robot": "wall_e", "action": "navigate_to_pose", "goal_id": A}
        start, end = {"sec": 0, "nanosec": 1}, {"sec": 4, "nanosec": 0}
        motion = {"robot": "wall_e", "from": [1, 2, 0], "to": [5, 2, 0], "duration": 4.0, "lane": ["home", "door"]}
        asked = first.pop(0)
        assert ("goal", A, {"x": 5.0, "y": 2.0}) == (
            asked["kind"],
            asked["goal_id"],
            asked["goal"]["pose"]["pose"]["position"],
        )
        assert first == [
            status | {"stamp": start, "status": 1},
            status | {"stamp": start, "status": 2},
            {"kind": "route", "stamp": start, "robot": "wall_e", "points": [[5, 2]]},
            {"kind": "motion", "stamp": start} | motion,
            status | {"stamp": end, "status": 4},
        ]
        assert [{"stamp": end, "kind": "picked", "robot": "eve", "item": "parcel"}] == [
            body for body in bodies if body["kind"] == "picked"
        ]
        assert [{"stamp": end, "kind": "placed", "robot": "eve", "item": "parcel", "at": [9, 2]}] == [
            body for body in bodies if body["kind"] == "placed"
        ]


def test_the_log_lacks_events_for_watchers(fast, go):
    """A subscriber of the log alone causes no computation of motion."""
    heard = fast.hear("_world/log")

    fast.send(NAVIGATE, go(9, 2), A)
    fast.result(NAVIGATE, A)

    bodies = heard.wait(lambda bodies: any(body.get("status") == 4 for body in bodies))
    assert ["goal", "status", "status", "status"] == [body["kind"] for body in bodies]
    assert go(9, 2) == bodies[0]["goal"]


def test_encodings_of_replies_and_publications_name_the_ros_type(fast, go):
    heard = fast.hear("**")
    replies = Heard()
    requests = {"send_goal": {"goal_id": A, "goal": go(5, 2)}, "get_result": {"goal_id": A}, "cancel_goal": {}}
    for verb, body in requests.items():
        for reply in fast.ask(f"{NAVIGATE}/_action/{verb}", body):
            replies.add(reply)
    fast.one("_world/clock")
    published = {"status", "feedback", "odom", "clock", "events", "state"}
    heard.wait(lambda _: published <= {item.key.rpartition("/")[2] for item in heard.items})

    encodings = {item.key.removeprefix("hmrsim/").rpartition("/")[2]: item.encoding for item in heard.items}
    encodings |= {item.key.rpartition("/")[2]: item.encoding for item in replies.items}
    assert encodings == {
        "send_goal": "application/json;nav2_msgs/action/NavigateToPose_SendGoal_Response",
        "get_result": "application/json;nav2_msgs/action/NavigateToPose_GetResult_Response",
        "cancel_goal": "application/json;action_msgs/srv/CancelGoal_Response",
        "status": "application/json;action_msgs/msg/GoalStatusArray",
        "feedback": "application/json;nav2_msgs/action/NavigateToPose_FeedbackMessage",
        "odom": "application/json;nav_msgs/msg/Odometry",
        "clock": "application/json;rosgraph_msgs/msg/Clock",
        "events": "application/json;hmrsim/Event",
        "log": "application/json;hmrsim/Event",
        "state": "application/json;hmrsim/TimeState",
    }
