"""Joining, advancing and clocks by the keys below ``_world/time``."""

from __future__ import annotations

import threading

import pytest

from hmrsim_zenoh.hosting.host import Host
from tests.patience import PATIENCE

A = "a" * 32


@pytest.fixture
def steps(serve):
    """Return a client of the small world in lockstep, for one participant."""
    return serve(clock="lockstep")


def advance(tester, name="nurse", epoch=0, until=None, **fields):
    request = {"participant": name, "epoch": epoch, "until": until, "wake": ["result"], **fields}
    return tester.begin("_world/time/advance", request)


def test_a_participant_is_woken_by_each_result(steps, go, wait):
    joined = steps.one("_world/time/join", {"name": "nurse"})
    commands = [
        {"robot": "wall_e", "action": "navigate_to_pose", "goal": go(5, 2)},
        {"robot": "eve", "action": "wait", "goal_id": A, "goal": wait(3)},
    ]
    first = advance(steps, commands=commands).one()
    second = advance(steps, epoch=first["epoch"]).one()
    third = advance(steps, epoch=second["epoch"]).one()
    left = steps.one("_world/time/leave", {"participant": "nurse"})

    assert {"participant": "nurse", "epoch": 0, "now": 0.0, "goals": 0} == joined
    assert [(1, 3.0, "event"), (2, 4.0, "event"), (3, 4.0, "idle")] == [
        (each["epoch"], each["now"], each["reason"]) for each in (first, second, third)
    ]
    assert [True, True] == [each["accepted"] for each in first["accepted"]]
    assert [
        {
            "stamp": {"sec": 3, "nanosec": 0},
            "kind": "result",
            "robot": "eve",
            "action": "wait",
            "goal_id": A,
            "status": 4,
            "result": {"total_elapsed_time": {"sec": 3, "nanosec": 0}, "error_code": 0, "error_msg": ""},
        }
    ] == first["events"]
    assert first["accepted"][0]["goal_id"] == second["events"][0]["goal_id"]
    assert {"participant": "nurse"} == left


@pytest.mark.parametrize("others", [[], ["_world/time/state"]])
def test_a_subscriber_gets_every_message_of_an_advance(steps, others):
    steps.hear(*others)
    steps.one("_world/time/join", {"name": "nurse"})
    heard = steps.hear("_world/clock")
    advance(steps, until=5.0).one()

    clocks = heard.wait(lambda bodies: any(5 == body["clock"]["sec"] for body in bodies))
    tenths = [body["clock"]["sec"] * 10 + body["clock"]["nanosec"] // 100_000_000 for body in clocks]
    assert list(range(1, 51)) == sorted({*tenths} - {0})


def test_commands_can_use_aliases(steps, go):
    steps.one("_world/time/join", {"name": "nurse"})
    sent = {"robot": "navigate_to_pose", "action": "wall_e", "goal_id": A, "goal": go(5, 2)}
    granted = advance(steps, until=1.0, commands=[sent]).one()
    canceled = {"robot": "wall_e", "action": "navigate_to_pose", "cancel": A}
    ended = advance(steps, epoch=1, commands=[canceled]).one()

    assert (1.0, "until") == (granted["now"], granted["reason"])
    assert (0, A) == (ended["accepted"][0]["return_code"], ended["accepted"][0]["goals_canceling"][0]["goal_id"])
    assert (5, 1.0) == (ended["events"][0]["status"], ended["now"])


def test_time_stops_for_each_condition_by_name(steps, go):
    steps.one("_world/time/join", {"name": "nurse"})
    sent = {"robot": "wall_e", "action": "navigate_to_pose", "goal": go(5, 2)}
    near = {
        "watch": "near",
        "key": "navigate_to_pose/wall_e/_action/feedback",
        "when": [["/feedback/distance_remaining", "<", 1.05]],
    }
    begun = {"watch": "begun", "key": "_world/events", "when": [["/kind", "==", "status"], ["/status", "==", 2]]}
    never = {"watch": "x", "key": "wall_e/odom", "when": [["/twist/twist/linear/x", ">", 1e3]]}
    first = advance(steps, wake=[], commands=[near, begun, never, sent]).one()
    second = advance(steps, wake=[], epoch=1, commands=[{"unwatch": "x"}]).one()

    assert [{"watching": True}] * 3 == first["accepted"][:3]
    assert (0.0, ["begun"], "event") == (first["now"], first["met"], first["reason"])
    assert ([{"watching": False}], 3.0, ["near"]) == (second["accepted"], second["now"], second["met"])
    assert "met" not in advance(steps, wake=[], epoch=2, until=5.0).one()


@pytest.mark.parametrize(
    ("bad", "field", "text"),
    [
        ({"key": "wall_e/odometer"}, "key", "no topic 'wall_e/odometer' for conditions; there are: _world/events, R"),
        ({"key": "_world/clock"}, "key", "no topic '_world/clock' for conditions"),
        ({"key": "zoe/odom"}, "key", "no such robot or action: zoe/"),
        ({"key": "eve/battery_state"}, "key", "eve has no battery"),
        ({}, "key", "Field required"),
        ({"key": "eve/odom", "when": [["x", "<", 1]]}, "when.0.0", "not a JSON pointer, such as '/percentage'"),
        ({"key": "eve/odom", "when": [["/x", "=", 1]]}, "when.0.1", "no operator '='; there are: == != < <= > >="),
        ({"key": "eve/odom", "when": [["/x", "<", 1e999]]}, "when.0.2", "Input should be a finite number"),
        ({"key": "eve/odom", "when": [["/x", "<", []]]}, "when.0.2", "Input should be a valid"),
        ({"key": "eve/odom", "when": [["/x", "<"]]}, "when.0", "List should have at least 3 items"),
        ({"key": "eve/odom", "when": [["/x", "<", 1]] * 21}, "when", "List should have at most 20 items"),
        ({"key": "eve/odom", "robot": "eve"}, "robot", "Extra inputs are not permitted"),
    ],
)
def test_an_invalid_condition_is_an_error_in_its_place(steps, bad, field, text):
    steps.one("_world/time/join", {"name": "nurse"})
    granted = advance(steps, until=9.0, commands=[{"watch": "a", **bad}]).one()
    (error,) = granted["accepted"]

    assert any(text in each["message"] and each["field"].startswith(field) for each in error["details"])
    assert 0.0 == granted["now"]


@pytest.mark.parametrize(
    ("key", "request_", "field", "text"),
    [
        ("join", {}, "name", "Field required"),
        ("join", {"name": "two words"}, "name", "String should match pattern"),
        ("join", {"name": "nurse", "x": 1}, "x", "Extra inputs are not permitted"),
        ("leave", {"participant": "zoe"}, "participant", "no participant 'zoe'; join first"),
        ("advance", {"participant": "zoe", "epoch": 0}, "participant", "no participant 'zoe'; join first"),
        ("advance", {"participant": "zoe", "epoch": "0"}, "epoch", "Input should be a valid integer"),
        ("advance", {"participant": "zoe", "epoch": 0, "wake": ["rain"]}, "wake.0", "Input should be 'status', 'feedb"),
        ("advance", {"participant": "z", "epoch": 0, "commands": {}}, "commands", "Input should be a valid array"),
        ("advance", {"participant": "z", "epoch": 0, "until": 1e18}, "until", "Input should be less than 2147483648"),
        ("set", {"clock": "sundial"}, "clock", "Input should be 'realtime' or 'lockstep'"),
        ("set", {"real_time_factor": -1}, "real_time_factor", "Value error, -1 is not 0, or from 1e-06 to 1e+06"),
        ("state", {"x": 1}, "x", "Extra inputs are not permitted"),
    ],
)
def test_an_invalid_request_applies_nothing_and_names_the_field(steps, key, request_, field, text):
    (reply,) = steps.ask(f"_world/time/{key}", request_)

    assert not reply.ok
    assert field == reply.body["details"][0]["field"]
    assert text in reply.body["details"][0]["message"]


@pytest.mark.parametrize(
    ("bad", "field", "text"),
    [
        ({}, "", "a command has either a goal to send, or the id of one as cancel or as result"),
        ({"cancel": A, "goal": {}}, "", "a command has either a goal to send"),
        ({"cancel": A, "goal_id": A}, "", "a command has either a goal to send"),
        ({"goal": {"time": 3}}, "goal.time", "Input should be an object"),
        ({"goal": {"time": {"sec": 1e999}}}, "goal.time.sec", "Input should be a"),
        ({"goal": 3}, "goal", "Input should be an object"),
        ({"goal": {}, "x": 1}, "x", "Extra inputs are not permitted"),
        ({"cancel": "x"}, "cancel", "goal id 'x' is not a UUID"),
        ({"result": "x"}, "result", "goal id 'x' is not a UUID"),
        ({"action": "x" * 5000, "goal": {}}, "action", "a text of 5000 characters; at most 4096 are taken"),
        ({"action": "pickup", "goal": {"target_name": "x" * 5000}}, "goal.target_name", "a text of 5000 characters"),
    ],
)
def test_an_invalid_command_is_an_error_and_the_others_are_applied(steps, wait, bad, field, text):
    steps.one("_world/time/join", {"name": "nurse"})
    good = {"robot": "eve", "action": "wait", "goal": wait(3)}
    granted = advance(steps, commands=[{"robot": "eve", "action": "wait", **bad}, good]).one()
    error, answer = granted["accepted"]
    (detail,) = error["details"]

    assert (field, True) == (detail["field"], answer["accepted"])
    assert text in detail["message"]
    assert (0.0, "event") == (granted["now"], granted["reason"])
    assert 3.0 == advance(steps, epoch=1).one()["now"]


def test_a_command_is_answered_as_on_its_own_key(serve, steps, wait):
    other = serve(clock="lockstep")
    steps.one("_world/time/join", {"name": "nurse"})
    asked = [
        ("eve/wait", "send_goal", {"goal_id": A, "goal": wait(3)}, {"goal_id": A, "goal": wait(3)}),
        ("eve/wait", "send_goal", {"goal_id": A, "goal": {}}, {"goal_id": A, "goal": {}}),
        ("eve/wait", "send_goal", {"goal": {"time": 1}}, {"goal": {"time": 1}}),
        ("eve/wait", "send_goal", {"goal": 3}, {"goal": 3}),
        ("eve/wait", "send_goal", {"goal": [1]}, {"goal": [1]}),
        ("eve/wait", "send_goal", {"goal": {"time": []}}, {"goal": {"time": []}}),
        ("eve/fly", "send_goal", {"goal": [1]}, {"goal": [1]}),
        ("eve/fly", "send_goal", {"goal_id": A, "goal": {"x": 1}}, {"goal_id": A, "goal": {"x": 1}}),
        ("zoe/wait", "cancel_goal", {"goal_info": {"goal_id": A}}, {"cancel": A}),
        ("zoe/wait", "get_result", {"goal_id": A}, {"result": A}),
        ("eve/wait", "get_result", {"goal_id": "b" * 32}, {"result": "b" * 32}),
        ("eve/wait", "cancel_goal", {"goal_info": {"goal_id": "b" * 32}}, {"cancel": "b" * 32}),
    ]
    commands = [
        {"robot": name.partition("/")[0], "action": name.partition("/")[2], **command} for name, _, _, command in asked
    ]
    by_advance = advance(steps, commands=[*commands, 7]).one()["accepted"]
    by_keys = [other.ask(f"{name}/_action/{verb}", request)[0].body for name, verb, request, _ in asked]

    assert by_keys == by_advance[:-1]
    assert "Input should be" in by_advance[-1]["error"]


def test_a_requested_result_wakes_its_participant(steps, wait):
    """The result of an ended goal comes at once."""
    steps.one("_world/time/join", {"name": "nurse"})
    sent = [{"robot": "eve", "action": "wait", "goal_id": A, "goal": wait(3)}]
    wanted = [{"robot": "eve", "action": "wait", "result": A}]
    advance(steps, until=1.0, wake=[], commands=sent).one()
    early = advance(steps, epoch=1, until=2.0, wake=[], commands=wanted).one()
    ending = advance(steps, epoch=2, until=9.0, wake=[], commands=wanted).one()
    late = advance(steps, epoch=3, until=19.0, commands=wanted).one()

    assert ([None], 2.0) == (early["accepted"], early["now"])
    assert ([4], 9.0) == ([each["status"] for each in ending["accepted"]], ending["now"])
    assert (ending["accepted"], 9.0, "event") == (late["accepted"], late["now"], late["reason"])
    assert {"sec": 3, "nanosec": 0} == late["accepted"][0]["result"]["total_elapsed_time"]


class TestClocks:
    """Requests that change how time advances."""

    def test_state_and_info_have_the_clock(self, steps):
        info = steps.one("_world/info")

        assert {
            "now": 0.0,
            "clock": "lockstep",
            "real_time_factor": 1.0,
            "paused": False,
            "epoch": 0,
            "participants": [],
            "waiting_for": ["1 more to join"],
            "lag": 0.0,
        } == steps.one("_world/time/state")
        assert ("lockstep", 1.0) == (info["clock"], info["real_time_factor"])

    def test_joining_in_real_time_is_an_error_with_a_remedy(self, live):
        (reply,) = live.ask("_world/time/join", {"name": "nurse"})

        assert "the clock is realtime; set it to lockstep first" == reply.body["error"]

    def test_the_clock_can_be_changed_during_a_run(self, live, wait):
        live.one("_world/time/set", {"clock": "lockstep"})
        live.one("_world/time/join", {"name": "nurse"})
        granted = advance(live, commands=[{"robot": "eve", "action": "wait", "goal": wait(1000)}]).one()
        live.one("_world/time/set", {"clock": "realtime", "real_time_factor": 0})

        assert granted["now"] >= 1000.0
        assert 4 == live.do("eve/wait", wait(1000))["status"]

    def test_the_factor_can_be_changed_during_a_run(self, live, wait):
        live.send("eve/wait", wait(1000), A)
        state = live.one("_world/time/set", {"real_time_factor": 0})

        assert ("realtime", 0.0) == (state["clock"], state["real_time_factor"])
        assert 4 == live.result("eve/wait", A)["status"]

    def test_a_participant_is_removed_when_the_clock_is_set(self, serve):
        """The reason is `end`: without lockstep there are no participants."""
        tester = serve(clock="lockstep", participants=2)
        tester.one("_world/time/join", {"name": "nurse"})
        held = advance(tester)
        state = tester.one("_world/time/set", {"clock": "realtime"})

        assert [] == state["participants"]
        assert "end" == held.one()["reason"]

    def test_the_state_is_published_for_each_new_participant(self, steps):
        heard = steps.hear("_world/time/state")
        steps.one("_world/time/join", {"name": "nurse"})

        assert heard.wait(lambda bodies: any(["nurse"] == body["participants"] for body in bodies))


def test_steps_without_a_participant_are_rejected(steps):
    steps.one("_world/set_simulation_state", {"state": {"state": 2}})
    answer = steps.one("_world/step_simulation", {"steps": 2})

    assert 4 == answer["result"]["result"]
    assert "lockstep has no participant" in answer["result"]["error_message"]
    assert steps.one("_world/time/state")["paused"]


def test_a_participant_without_its_token_is_dropped_before_any_timeout(serve):
    tester, other = serve(clock="lockstep", participants=2), serve.tester(serve.hosts[0])
    token = other.session.liveliness().declare_token("hmrsim/_participant/b")
    for one, name in ((tester, "a"), (other, "b")):
        one.one("_world/time/join", {"name": name})
    held = advance(tester, "a", until=5.0)
    token.undeclare()

    assert 5.0 == held.one()["now"]


def test_a_participant_that_joins_again_outlives_its_earlier_token(serve, monkeypatch):
    """The thread that is told of tokens may lag behind: the first one goes when the second one is there."""
    gate, noted, note_token = threading.Event(), [], Host._note_token

    def note_late(host, sample):
        gate.wait(PATIENCE)
        note_token(host, sample)
        noted.append(sample.kind)
        if 3 == len(noted):
            all_noted.set()

    all_noted = threading.Event()
    monkeypatch.setattr(Host, "_note_token", note_late)
    tester = serve(clock="lockstep")
    for ends in (True, False):
        token = tester.session.liveliness().declare_token("hmrsim/_participant/a")
        tester.one("_world/time/join", {"name": "a"})
        if ends:
            tester.one("_world/time/leave", {"participant": "a"})
            token.undeclare()
    gate.set()
    all_noted.wait(PATIENCE)

    assert ["a"] == tester.one("_world/time/state")["participants"]
