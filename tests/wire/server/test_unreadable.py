"""Malformed messages get exactly one error reply, which locates the error."""

from __future__ import annotations

import json
import random

import pytest

A = "a" * 32
SEND = "wall_e/navigate_to_pose/_action/send_goal"
CANCEL = "wall_e/navigate_to_pose/_action/cancel_goal"
RESULT = "wall_e/navigate_to_pose/_action/get_result"
X = '{"goal": {"pose": {"pose": {"position": {"x": %s}}}}}'


@pytest.mark.parametrize(
    ("key", "payload", "field", "message", "value"),
    [
        (SEND, b"go home", "", "Invalid JSON", None),
        (SEND, b'{"goal": {}', "", "Invalid JSON", None),
        (SEND, b"\xff\xfe\x00", "", "Invalid JSON", None),
        (SEND, b"[]", "", "an object", "[]"),
        (SEND, b"null", "", "an object", None),
        (SEND, b"3", "", "an object", 3),
        (SEND, b"[" * 100_000, "", "Invalid JSON", None),
        (SEND, None, "", "empty payload", None),
        (SEND, b"", "", "empty payload", None),
        (SEND, {}, "goal", "required", "{}"),
        (SEND, {"goal_id": A}, "goal", "required", None),
        (SEND, {"goal": None}, "goal", "an object", None),
        (SEND, {"goal": [1]}, "goal", "an object", "[1]"),
        (SEND, {"goal": {}, "goal_id": 7}, "goal_id", "valid string", 7),
        (SEND, {"goal": {}, "priority": 7}, "priority", "not permitted", 7),
        (SEND, {"goal": {"speed": 2.5}}, "goal.speed", "not permitted", 2.5),
        (SEND, {"goal": {"behavior_tree": False}}, "goal.behavior_tree", "valid string", False),
        (SEND, (X % '"far"').encode(), "goal.pose.pose.position.x", "valid number", "far"),
        (SEND, (X % "true").encode(), "goal.pose.pose.position.x", "valid number", True),
        (SEND, (X % "NaN").encode(), "goal.pose.pose.position.x", "finite number", "nan"),
        (SEND, (X % "Infinity").encode(), "goal.pose.pose.position.x", "finite number", "inf"),
        (SEND, (X % "-Infinity").encode(), "goal.pose.pose.position.x", "finite number", "-inf"),
        (SEND, (X % "1e999").encode(), "goal.pose.pose.position.x", "finite number", "inf"),
        (SEND, {"goal": {"pose": {"header": {"stamp": {"sec": 1.5}}}}}, "goal.pose.header.stamp.sec", "integer", 1.5),
        (SEND, {"goal": {"pose": {"header": {"stamp": {"nanosec": -1}}}}}, "goal.pose.header.stamp.nanosec", "0", -1),
        ("wall_e/pickup/_action/send_goal", {"goal": {"target_name": 5}}, "goal.target_name", "valid string", 5),
        ("nobody/navigate_to_pose/_action/send_goal", {"goal": 5}, "goal", "an object", 5),
        ("wall_e/fly/_action/send_goal", {"goal_id": A}, "goal", "required", None),
        (RESULT, b"what?", "", "Invalid JSON", None),
        (RESULT, None, "", "empty payload", None),
        (RESULT, {}, "goal_id", "required", "{}"),
        (RESULT, {"goal_id": 5}, "goal_id", "valid string", 5),
        (RESULT, {"goal_id": "me"}, "goal_id", "'me' is not a UUID", "me"),
        (RESULT, {"goal_id": A, "timeout": 5}, "timeout", "not permitted", 5),
        (CANCEL, b"stop", "", "Invalid JSON", None),
        (CANCEL, None, "", "empty payload", None),
        (CANCEL, {"goal_id": A}, "goal_id", "not permitted", A),
        (CANCEL, {"goal_info": {"goal_id": 5}}, "goal_info.goal_id", "valid string", 5),
        (CANCEL, {"goal_info": {"goal_id": "me"}}, "goal_info.goal_id", "'me' is not a UUID", "me"),
        (CANCEL, {"goal_info": {"stamp": {"sec": "1"}}}, "goal_info.stamp.sec", "valid integer", "1"),
        (CANCEL, {"goal_info": {"stamp": 5}}, "goal_info.stamp", "an object", 5),
    ],
)
def test_an_invalid_field_is_named_with_its_path(shared, key, payload, field, message, value):
    (reply,) = shared.ask(key, payload)

    (detail,) = reply.body["details"]
    assert (False, "application/json", {"error", "details"}) == (reply.ok, reply.encoding, set(reply.body))
    assert {"field", "message", "value"} == set(detail)
    assert (field, True) == (detail["field"], message in detail["message"])
    assert value in (None, detail["value"])
    assert field in reply.body["error"]


def test_all_invalid_fields_are_named_at_once(shared):
    body = shared.one(SEND, {"goal": {"pose": {"pose": {"position": {"x": "a", "y": "b"}}}}})

    assert ["goal.pose.pose.position.x", "goal.pose.pose.position.y"] == [item["field"] for item in body["details"]]


@pytest.mark.parametrize("key", [SEND, CANCEL, RESULT])
@pytest.mark.parametrize("size", [1024 * 1024 + 1, 10_000_000])
def test_a_payload_over_one_mebibyte_is_refused_with_both_sizes(shared, key, size):
    (reply,) = shared.ask(key, b"{" + b" " * (size - 2) + b"}")

    assert (False, f"payload of {size} bytes; at most 1048576 are taken") == (reply.ok, reply.body["error"])


def test_a_payload_of_one_mebibyte_is_read(shared):
    payload = json.dumps({"goal": {}}).encode().ljust(1024 * 1024)

    assert shared.one(SEND, payload)["accepted"]


def test_the_maximum_payload_can_be_set(serve):
    tester = serve(real_time_factor=0, max_payload=100)

    replies = [*tester.ask(SEND, b'{"goal": {}}'.ljust(100)), *tester.ask(SEND, b'{"goal": {}}'.ljust(101))]

    assert [True, False] == [reply.ok for reply in replies]


@pytest.mark.parametrize(
    "payload",
    [
        b'{"goal": {"pose": {"header": {"stamp": {"sec": 1' + b"0" * 6000 + b"}}}}}",
        b'{"goal": {"pose": {"pose": {"position": {"x": ["' + b"9" * 6000 + b'", 1' + b"0" * 6000 + b"]}}}}}",
        b'{"goal": {"behavior_tree": "\\ud800"}}',
        b'{"goal": {"\\ud800": 1}}',
        b'{"goal_id": "' + b"x" * 1_000_000 + b'", "goal": {"a": 1}}',
        b'{"goal": {"' + b"x" * 1_000_000 + b'": 1}}',
        b'{"goal": {' + b",".join(b'"%d": 1' % number for number in range(50_000)) + b"}}",
        b'{"goal": ' + b'{"a":' * 500 + b"1" + b"}" * 500 + b"}",
    ],
    ids=["digits", "digits in a list", "surrogate", "surrogate key", "long id", "long key", "many keys", "deep"],
)
def test_a_deeply_nested_message_gets_one_short_error_reply(shared, payload):
    (reply,) = shared.ask(SEND, payload)

    assert not reply.ok
    assert len(json.dumps(reply.body)) < 20_000
    assert shared.one("_world/info")["contract"] == 1


def test_a_huge_id_is_abridged_in_the_answer(shared):
    (reply,) = shared.ask(SEND, {"goal_id": "x" * 1_000_000, "goal": {}})

    assert (True, "invalid_goal_id") == (reply.ok, reply.body["reason"])
    assert len(json.dumps(reply.body)) < 2_000


@pytest.mark.parametrize("verb", ["cancel_goal", "get_result"])
@pytest.mark.parametrize(
    ("name", "field", "value"), [("nobody/wait", "robot", "nobody"), ("cart/pickup", "action", "pickup")]
)
def test_other_requests_to_an_unknown_robot_list_the_robots(shared, verb, name, field, value):
    (reply,) = shared.ask(f"{name}/_action/{verb}", {} if verb == "cancel_goal" else {"goal_id": A})

    (detail,) = reply.body["details"]
    assert (False, field, value) == (reply.ok, detail["field"], detail["value"])
    assert repr(value) in reply.body["error"]


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("wall_e/wait/_action/feedback", "feedback is only published"),
        ("wall_e/weather", "wall_e has no topic 'weather' to get; it has: odom"),
        ("nobody/odom", "no robot 'nobody'; there are: wall_e, eve, cart"),
        ("nobody/wait/_action/status", "nobody/wait"),
        ("_world/weather", "the world has no 'weather' to get; there are: call_lift, clear_fault"),
    ],
)
def test_an_unknown_reading_lists_the_known_ones(shared, key, text):
    (reply,) = shared.ask(key)

    assert (False, True) == (reply.ok, text in reply.body["error"])


LATCHED = ["_world/info", "_world/route_graph", "_world/clock", "wall_e/odom", "wall_e/wait/_action/status", "_world/*"]


@pytest.mark.parametrize("key", LATCHED)
def test_a_reading_with_fields_is_refused(shared, key):
    """The client must not take an ignored field for applied."""
    (reply,) = shared.ask(key, {"x": 3})

    (detail,) = reply.body["details"]
    assert (False, "x", 3) == (reply.ok, detail["field"], detail["value"])
    assert "x: Extra inputs are not permitted" == reply.body["error"]


@pytest.mark.parametrize("payload", [None, b"", b"{}", b" { } "])
@pytest.mark.parametrize("key", LATCHED)
def test_a_reading_may_have_an_empty_payload_or_object(shared, key, payload):
    assert {True} == {reply.ok for reply in shared.ask(key, payload)}


@pytest.mark.parametrize("verb", ["send_goal", "execute"])
@pytest.mark.parametrize("key", ["*/navigate_to_pose/_action/", "**/", "wall_e/*/_action/"])
def test_a_request_with_wildcards_is_an_error(shared, key, verb):
    """A goal is for one robot."""
    (reply,) = shared.ask(f"{key}{verb}", {"goal": {}})

    assert (False, True) == (reply.ok, "without wildcards" in reply.body["error"])


def test_an_unknown_key_of_a_robot_is_named(shared):
    (reply,) = shared.ask("wall_e/wait/_action/fly", {"goal": {}})

    assert not reply.ok
    assert "wall_e has no key 'hmrsim/wall_e/wait/_action/fly'; see docs/reference/keys.md" == reply.body["error"]


@pytest.mark.parametrize("key", ["nothing", "one/two/three/four", "_planner/compute_path_to_pose", "_participant/me"])
def test_a_key_of_another_node_gets_no_reply(shared, key):
    assert [] == shared.ask(key, {"goal": {}})


def test_random_bytes_on_any_key_get_one_error_each(fast, wait):
    random_bytes = random.Random(7)
    names = ("wall_e/wait", "eve/pickup", "navigate_to_pose/wall_e", "cart/fly", "nobody/wait")
    verbs = ("send_goal", "cancel_goal", "get_result", "execute")
    keys = [f"{name}/_action/{verb}" for name in names for verb in verbs] * 10

    pending = [fast.begin(key, random_bytes.randbytes(random_bytes.randrange(200))) for key in keys]

    assert [[False]] * 200 == [[reply.ok for reply in replies.all()] for replies in pending]
    assert 4 == fast.do("wall_e/wait", wait(1))["status"]
