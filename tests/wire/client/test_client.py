"""The client, with a simulator that loses requests, rejects, hangs and dies."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time

import pytest
from zenoh import ext

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client import zenoh_connection
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.errors import (
    BadOptions,
    ClientClosed,
    GoalRejectedError,
    GoalTimeout,
    RequestError,
    RequestTimeout,
    SimulatorGone,
    SimulatorNotFound,
    Unreachable,
)
from hmrsim_zenoh.wire.envelopes import UnreadableError, around
from hmrsim_zenoh.wire.keys import Verb
from hmrsim_zenoh.wire.session import SessionOptions, open_client
from tests.patience import PATIENCE

GOAL = Wait.Goal(time=Duration(sec=2))
ID = "0123456789abcdef0123456789abcdef"
OTHER_ID = "f" * 32
FOR_EVER = 1e6
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


@pytest.fixture
def wait_client(client):
    return client.action_client("wall_e", registry()["wait"])


# --- the ordinary trip ---------------------------------------------------------------------------------------


def test_a_goal_ends_with_its_result(simulator, wait_client):
    simulator.steps["get_result"] = [simulator.end(SUCCEEDED, total_elapsed_time={"sec": 2, "nanosec": 0})]
    goal = wait_client.send_goal(GOAL)

    assert goal.result(PATIENCE) == Wait.Result(total_elapsed_time=Duration(sec=2))
    assert (goal.status, goal.accepted, goal.done, goal.error) == (GoalStatus.SUCCEEDED, True, True, None)


def test_the_readers_that_a_goal_uses_are_prepared(simulator, wait_client, monkeypatch):
    used = set()
    monkeypatch.setattr(zenoh_connection, "around", lambda *types: used.add(types) or around(*types))
    zenoh_connection.prepare_messages(registry()["wait"])
    prepared, used = used, set()
    simulator.steps["get_result"] = [simulator.end(SUCCEEDED)]
    wait_client.send_goal(GOAL, on_feedback=print).result(PATIENCE)

    assert prepared == used != set()


def test_the_request_has_the_goal_and_the_clients_id(simulator, wait_client):
    goal = wait_client.send_goal(GOAL)

    assert simulator.wait_for(Verb.SEND_GOAL) == [{"goal_id": goal.goal_id, "goal": {"time": {"sec": 2, "nanosec": 0}}}]
    assert simulator.wait_for(Verb.GET_RESULT) == [{"goal_id": goal.goal_id}]


def test_a_goal_may_be_given_in_plain_values(simulator, wait_client):
    """The simulator validates them, not the client."""
    simulator.steps["send_goal"] = [simulator.say_error('{"error": "goal.tiem: Extra inputs are not permitted"}')]
    goal = wait_client.send_goal({"tiem": {"sec": 2}})

    with pytest.raises(RequestError, match="tiem"):
        goal.result(PATIENCE)
    assert simulator.wait_for(Verb.SEND_GOAL) == [{"goal_id": goal.goal_id, "goal": {"tiem": {"sec": 2}}}]


@pytest.mark.parametrize(("status", "result"), [(SUCCEEDED, None), (ABORTED, Wait.Result(error_msg="tired"))])
def test_an_unwanted_result_is_decoded_only_if_the_goal_failed(simulator, wait_client, status, result):
    fields = {"error_msg": "tired"} if result else {"of_another_version": 1}
    simulator.steps["get_result"] = [simulator.end(status, **fields)]
    done = threading.Event()
    goal = wait_client.send_goal(GOAL, read_result=False, on_change=lambda goal: goal.done and done.set())

    assert done.wait(PATIENCE)
    assert (goal.status, goal.error, goal.result_message) == (status, None, result)


def test_an_aborted_goal_has_a_result_too(simulator, wait_client):
    simulator.steps["get_result"] = [simulator.end(ABORTED, error_code=740, error_msg="tired")]
    goal = wait_client.send_goal(GOAL)

    assert goal.result(PATIENCE).error_msg == "tired"
    assert goal.status is GoalStatus.ABORTED


# --- refusals ------------------------------------------------------------------------------------------------


def test_a_rejected_goal_has_a_reason_and_a_message(simulator, wait_client):
    simulator.steps["send_goal"] = [simulator.refuse("busy")]
    simulator.steps["get_result"] = [simulator.end(0)]
    goal = wait_client.send_goal(GOAL)

    with pytest.raises(GoalRejectedError, match="busy: because of busy") as caught:
        goal.result(PATIENCE)
    assert (caught.value.reason, caught.value.error_code, goal.accepted) == ("busy", 1, False)
    with pytest.raises(GoalRejectedError):
        goal.wait_accepted(PATIENCE)


def test_an_error_reply_lists_the_invalid_fields(simulator, wait_client):
    details = [{"field": "goal.time.sec", "message": "too large", "value": 1}]
    simulator.steps["send_goal"] = [simulator.say_error(json.dumps({"error": "no", "details": details}))]
    goal = wait_client.send_goal(GOAL)

    with pytest.raises(RequestError, match="no") as caught:
        goal.result(PATIENCE)
    assert caught.value.details == tuple(details)


def test_an_error_that_is_not_json_is_shown_unchanged(simulator, wait_client):
    simulator.steps["send_goal"] = [simulator.say_error("kaputt")]

    with pytest.raises(RequestError, match="kaputt"):
        wait_client.send_goal(GOAL).result(PATIENCE)


@pytest.mark.parametrize("verb", ["send_goal", "get_result"])
def test_a_malformed_reply_is_an_error(simulator, wait_client, verb):
    simulator.steps["get_result"] = [simulator.hold]
    simulator.steps[verb] = [simulator.say({"nonsense": 1})]

    with pytest.raises(UnreadableError, match="Field required"):
        wait_client.send_goal(GOAL).result(PATIENCE)


# --- losses --------------------------------------------------------------------------------------------------


def test_a_goal_whose_answer_was_lost_is_sent_again(simulator, wait_client):
    """The second request finds our own goal: it counts as accepted, with its present status."""
    simulator.steps["send_goal"] = [simulator.lose, simulator.refuse("duplicate_goal_id", status=2)]
    goal = wait_client.send_goal(GOAL)
    goal.wait_accepted(PATIENCE)

    first, second = simulator.wait_for(Verb.SEND_GOAL, 2)
    assert (first, goal.accepted, goal.status) == (second, True, GoalStatus.EXECUTING)


@pytest.mark.parametrize("loss", ["silence", "timeout"])
def test_a_result_whose_answer_was_lost_is_asked_for_again(simulator, wait_client, loss):
    """Neither a missing reply nor Zenoh's own timeout means that the goal is gone."""
    lost = {"silence": simulator.lose, "timeout": simulator.say_error("Timeout")}[loss]
    simulator.steps["get_result"] = [simulator.hold, lost, lost, simulator.end(SUCCEEDED)]
    goal = wait_client.send_goal(GOAL)
    goal.wait_accepted(PATIENCE)
    simulator.wait_for(Verb.GET_RESULT)
    simulator.release(lost, verb=Verb.GET_RESULT)

    assert goal.result(PATIENCE) == Wait.Result()
    assert simulator.count(Verb.GET_RESULT) == 4


def test_waiting_for_a_result_can_time_out(simulator, wait_client):
    """The goal continues, and its result may still come."""
    goal = wait_client.send_goal(GOAL)
    with pytest.raises(GoalTimeout, match=r"no result of goal .* after 0.05 s; it goes on"):
        goal.result(0.05)
    assert not goal.done

    simulator.wait_for(Verb.GET_RESULT)
    simulator.release(simulator.end(SUCCEEDED), verb=Verb.GET_RESULT)
    assert goal.result(PATIENCE) == Wait.Result()


def test_waiting_for_acceptance_raises_timeout_error(simulator, wait_client):
    simulator.steps["send_goal"] = [simulator.hold]

    with pytest.raises(TimeoutError, match="no answer to goal"):
        wait_client.send_goal(GOAL).wait_accepted(0.05)


# --- a simulator that goes -----------------------------------------------------------------------------------


def test_the_clock_of_a_slow_simulator_is_not_guessed(simulator):
    """A controller that took lockstep for real time would wait forever."""
    losses = iter([simulator.lose] * 4)
    lockstep = simulator.say({"clock": "lockstep"})

    def inform(query, body):
        step = next(losses, lockstep)
        step(query, body)

    simulator.inform = inform
    serve(simulator, simulator.keys.world("time/join"), simulator.say({"epoch": 0, "now": 0.0}))
    serve(simulator, simulator.keys.world("time/leave"), simulator.say({}))

    with Client(SessionOptions(connect=(simulator.endpoint,))) as client:
        assert client.lockstep is not None
    assert next(losses, None) is None


def test_a_simulator_that_dies_fails_its_goals(simulator, wait_client):
    goal = wait_client.send_goal(GOAL)
    goal.wait_accepted(PATIENCE)
    simulator.wait_for(Verb.GET_RESULT)
    simulator.close()

    with pytest.raises(SimulatorGone, match="its token 'hmrsim/_world/alive' has disappeared"):
        goal.result(PATIENCE)
    assert goal.accepted


def test_a_goal_sent_to_a_simulator_that_has_gone_fails(simulator, client, wait_client):
    client.wait_for_simulator(PATIENCE)
    simulator.close()

    with pytest.raises(SimulatorGone, match="is gone"):
        wait_client.send_goal(GOAL).result(PATIENCE)


def test_a_goal_survives_a_short_network_outage(simulator, another):
    """The same goal is known afterwards, and its result is requested again."""
    with Client(SessionOptions(connect=(simulator.endpoint,)), grace=30.0) as client:
        goal = client.action_client("wall_e", registry()["wait"]).send_goal(GOAL)
        goal.wait_accepted(PATIENCE)
        simulator.wait_for(Verb.GET_RESULT)
        simulator.close()
        back = another(endpoint=simulator.endpoint)
        back.wait_for(Verb.GET_RESULT)
        back.release(back.end(SUCCEEDED), verb=Verb.GET_RESULT)

        assert goal.result(PATIENCE) == Wait.Result()


def test_a_restarted_simulator_does_not_know_the_goal(simulator, another):
    """Its status 0 means that the accepted goal is lost."""
    with Client(SessionOptions(connect=(simulator.endpoint,)), grace=30.0) as client:
        goal = client.action_client("wall_e", registry()["wait"]).send_goal(GOAL)
        goal.wait_accepted(PATIENCE)
        simulator.wait_for(Verb.GET_RESULT)
        simulator.close()
        restarted = another(endpoint=simulator.endpoint)
        restarted.wait_for(Verb.GET_RESULT)
        restarted.release(restarted.end(0), verb=Verb.GET_RESULT)

        with pytest.raises(SimulatorGone, match=r"does not know goal .* any more"):
            goal.result(PATIENCE)


def test_a_router_without_a_simulator_is_no_simulator(another):
    """The client is connected but sees no token, so the error comes after the grace."""
    router = another(present=False)
    router.steps["send_goal"] = router.steps["get_result"] = [router.lose]
    with Client(SessionOptions(connect=(router.endpoint,)), grace=0.2) as client:
        goal = client.action_client("wall_e", registry()["wait"]).send_goal(GOAL)

        with pytest.raises(
            SimulatorNotFound, match="there is no token 'hmrsim/_world/alive'; start `hmrsim run WORLD`"
        ):
            goal.result(PATIENCE)


# --- cancel --------------------------------------------------------------------------------------------------


def test_a_canceled_goal_is_canceling_and_then_canceled(simulator, wait_client, watched):
    simulator.steps["cancel_goal"] = [simulator.canceling]
    goal = wait_client.send_goal(GOAL, on_change=lambda goal: watched(goal.status))
    goal.wait_accepted(PATIENCE)
    goal.cancel()
    watched.wait(lambda seen: GoalStatus.CANCELING in seen)
    simulator.wait_for(Verb.GET_RESULT)
    simulator.release(simulator.end(CANCELED), verb=Verb.GET_RESULT)

    goal.result(PATIENCE)
    assert goal.status is GoalStatus.CANCELED
    assert simulator.wait_for(Verb.CANCEL_GOAL) == [
        {"goal_info": {"goal_id": goal.goal_id, "stamp": {"sec": 0, "nanosec": 0}}}
    ]


def test_all_goals_of_an_action_can_be_canceled(simulator, wait_client):
    simulator.steps["cancel_goal"] = [simulator.canceling]
    wait_client.cancel_all()

    assert [{"goal_info": {"goal_id": "0" * 32, "stamp": {"sec": 0, "nanosec": 0}}}] == simulator.wait_for(
        Verb.CANCEL_GOAL
    )


def test_a_rejected_cancel_of_all_goals_is_an_error(simulator, wait_client):
    simulator.steps["cancel_goal"] = [simulator.say_error('{"error": "no such action", "details": []}')]

    with pytest.raises(RequestError, match="no such action"):
        wait_client.cancel_all()


# --- feedback ------------------------------------------------------------------------------------------------

FEEDBACK_KEY = "hmrsim/wall_e/wait/_action/feedback"


def feedback(goal_id: str, seconds: int) -> str:
    """Return a payload of feedback."""
    return json.dumps({"goal_id": goal_id, "feedback": {"time_left": {"sec": seconds, "nanosec": 0}}})


def test_a_goal_gets_only_its_own_feedback(simulator, wait_client, watched):
    """Feedback of other goals arrives on the same key, and malformed feedback is skipped."""
    goal = wait_client.send_goal(GOAL, goal_id=ID, on_feedback=watched)
    goal.wait_accepted(PATIENCE)
    for payload in (feedback(OTHER_ID, 9), "nonsense", feedback(ID, 2), feedback(ID, 1)):
        simulator.publish_feedback(FEEDBACK_KEY, payload)

    assert watched.wait(lambda seen: len(seen) == 2) == [
        Wait.Feedback(time_left=Duration(sec=2)),
        Wait.Feedback(time_left=Duration(sec=1)),
    ]
    assert (goal.feedback, goal.status) == (Wait.Feedback(time_left=Duration(sec=1)), GoalStatus.EXECUTING)


# --- closing -------------------------------------------------------------------------------------------------


def test_closing_the_client_fails_its_open_goals(client, wait_client):
    goal = wait_client.send_goal(GOAL)
    goal.wait_accepted(PATIENCE)
    caught = []

    def wait():
        try:
            goal.result(PATIENCE)
        except ClientClosed as error:
            caught.append(str(error))

    thread = threading.Thread(target=wait)
    thread.start()
    client.close()
    thread.join(PATIENCE)

    assert caught == ["the client was closed while the goal was under way"]
    with pytest.raises(ClientClosed, match="closed"):
        wait_client.send_goal(GOAL)
    with pytest.raises(ClientClosed, match="closed"):
        client.get("hmrsim/_world/info")
    with pytest.raises(ClientClosed, match="closed"):
        client.subscribe("hmrsim/_world/info", print)


def test_a_borrowed_session_stays_open(simulator):
    """The client undeclares everything that it declared on the session."""
    with open_client(SessionOptions(connect=(simulator.endpoint,))) as session:
        with Client(session=session) as client:
            sending = client.action_client("wall_e", registry()["wait"])
            sending.send_goal(GOAL, on_feedback=lambda _: None).wait_accepted(PATIENCE)
            client.subscribe("hmrsim/_world/events", print)

        assert not session.is_closed()


def test_a_process_that_does_not_close_its_client_still_ends(simulator):
    script = f"""
import atexit
atexit.register(lambda: print(client.session.is_closed()))
from hmrsim.actions import registry
from hmrsim_zenoh import Client, SessionOptions
client = Client(SessionOptions(connect=({simulator.endpoint!r},)))
action = registry()["wait"]
goal = client.action_client("wall_e", action).send_goal(action.goal(), on_feedback=id)
client.subscribe("hmrsim/**", id)
goal.wait_accepted(10)
print(client.alive)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)

    assert (done.returncode, done.stdout, done.stderr) == (0, "True\nTrue\n", "")


# --- presence and values -------------------------------------------------------------------------------------


def test_presence_follows_the_token(simulator, client):
    assert client.alive

    simulator.close()
    until = time.monotonic() + PATIENCE
    while client.alive and time.monotonic() < until:
        pass
    assert not client.alive


def test_waiting_for_a_missing_simulator_names_the_endpoint(another):
    router = another(present=False)
    with Client(SessionOptions(connect=(router.endpoint,))) as client:
        assert not client.alive
        with pytest.raises(SimulatorNotFound, match=r"within 0.05 s: there is no token 'hmrsim/_world/alive'"):
            client.wait_for_simulator(0.05)


def test_waiting_for_a_simulator_ends_with_its_token(another):
    router = another(present=False)
    with Client(SessionOptions(connect=(router.endpoint,))) as client:
        token = router.session.liveliness().declare_token("hmrsim/_world/alive")
        client.wait_for_simulator(PATIENCE)

        assert client.alive
        token.undeclare()


def serve(simulator, key, step):
    """Answer requests on a key, and return the payloads received."""
    came = []

    def on_query(query):
        came.append(query.payload.to_bytes() if query.payload else None)
        step(query, None)

    simulator.session.declare_queryable(key, on_query)
    return came


def test_info_is_the_description_of_the_simulator(simulator, client):
    simulator.inform = simulator.say({"contract": 1, "robots": []})

    assert client.info() == {"contract": 1, "robots": []}


@pytest.mark.parametrize("body", ["[]", "{"])
def test_info_that_is_not_an_object_is_an_error(simulator, client, body):
    simulator.inform = lambda query, _: query.reply(query.key_expr, body)

    with pytest.raises(UnreadableError, match=r"^hmrsim/_world/info: "):
        client.info()


def test_a_request_carries_its_payload(simulator, client):
    came = serve(simulator, "hmrsim/_world/step_simulation", simulator.say({"ok": 1}))

    assert client.get("hmrsim/_world/step_simulation", payload=b'{"steps":1}') == b'{"ok": 1}'
    assert came == [b'{"steps":1}']


def test_an_error_reply_to_a_request_is_raised(simulator, client):
    simulator.inform = simulator.say_error('{"error": "no", "details": []}')

    with pytest.raises(RequestError, match="no"):
        client.info()


def test_a_key_without_a_queryable_is_unreachable(client):
    with pytest.raises(Unreachable, match="nothing answers on 'hmrsim/eve/odom'"):
        client.get("hmrsim/eve/odom")


def test_a_lost_reading_is_repeated(simulator, client):
    came = serve(simulator, "hmrsim/_world/clock", simulator.lose)
    with pytest.raises(Unreachable, match="clock"):
        client.get("hmrsim/_world/clock")

    assert len(came) == 2


def test_a_lost_request_that_may_have_had_an_effect_is_not_repeated(simulator, client):
    came = serve(simulator, "hmrsim/_world/step_simulation", simulator.lose)
    with pytest.raises(Unreachable, match="step_simulation"):
        client.get("hmrsim/_world/step_simulation", payload=b"{}")

    assert len(came) == 1


def test_a_value_that_takes_too_long_times_out(simulator, client):
    serve(simulator, "hmrsim/_world/clock", simulator.hold)

    with pytest.raises(RequestTimeout, match=r"'hmrsim/_world/clock': no answer in 0.1 s"):
        client.get("hmrsim/_world/clock", 0.1)


def test_a_reading_of_all_ends_with_the_last_reply(simulator, client):
    for key in ("hmrsim/ann/odom", "hmrsim/bob/odom"):
        serve(simulator, key, lambda query, _body, key=key: query.reply(key, b"{}"))

    assert {"hmrsim/ann/odom": b"{}", "hmrsim/bob/odom": b"{}"} == client.get_all("hmrsim/*/odom", FOR_EVER)
    assert {} == client.get_all("hmrsim/*/battery_state", FOR_EVER)


def test_a_reading_without_a_simulator_is_an_error(another):
    router = another(present=False)
    options = SessionOptions(connect=(router.endpoint,))
    with Client(options, grace=0.1) as client, pytest.raises(SimulatorNotFound, match="no simulator answers"):
        client.get("hmrsim/_world/clock")


def test_a_topic_is_followed_until_it_is_closed(simulator, client, watched):
    subscription = client.subscribe("hmrsim/*/odom", watched)
    simulator.wait_for_subscriber("hmrsim/wall_e/odom", there=True)
    simulator.session.put("hmrsim/wall_e/odom", b"1")
    simulator.session.put("hmrsim/eve/odom", b"2")

    assert watched.wait(lambda seen: len(seen) == 2) == [("hmrsim/wall_e/odom", b"1"), ("hmrsim/eve/odom", b"2")]
    subscription.close()
    simulator.wait_for_subscriber("hmrsim/wall_e/odom", there=False)


def test_a_subscriber_with_history_gets_the_latest_sample(simulator, client, watched):
    publisher = ext.declare_advanced_publisher(
        simulator.session, "hmrsim/_world/clock", cache=ext.CacheConfig(max_samples=1), publisher_detection=True
    )
    publisher.put(b"1")
    publisher.put(b"2")
    client.subscribe("hmrsim/_world/clock", watched, history=True)

    assert watched.wait(lambda seen: len(seen) == 1) == [("hmrsim/_world/clock", b"2")]


@pytest.mark.parametrize("key", ["", "/hmrsim", "a//b"])
def test_a_malformed_key_is_named(client, key):
    """Zenoh's own error does not mention the key."""
    with pytest.raises(ValueError, match="is not a key"):
        client.get(key)
    with pytest.raises(ValueError, match="is not a key"):
        client.subscribe(key, print)


def test_a_closed_session_ends_everything(simulator):
    """This includes a session that is closed behind the client's back."""
    session = open_client(SessionOptions(connect=(simulator.endpoint,)))
    with Client(session=session) as client:
        goal = client.action_client("wall_e", registry()["wait"]).send_goal(GOAL)
        goal.wait_accepted(PATIENCE)
        session.close()

        with pytest.raises(ClientClosed, match="closed"):
            goal.result(PATIENCE)
        assert not client.alive
        with pytest.raises(ClientClosed, match="closed"):
            client.wait_for_simulator(PATIENCE)


def test_a_bad_prefix_is_reported_before_connecting():
    with pytest.raises(BadOptions, match=r"--prefix: prefix 'a\*' is not a plain key"):
        Client(SessionOptions(prefix="a*"))
