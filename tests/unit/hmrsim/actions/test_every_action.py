"""The guarantees of every action in the registry."""

from __future__ import annotations

import json

import jsonschema
import pytest

from hmrsim.actions import error_of, registry
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes, Pickup
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.interfaces.simulation_interfaces import SetSimulationState, SimulationState
from hmrsim.protocol.commands import CallService, CancelGoal, GetResult, SendGoal
from hmrsim.protocol.goal import WORLD as THE_WORLD
from hmrsim_zenoh.schemas import action_schema
from hmrsim_zenoh.wire.envelopes import SendGoalRequest, around, read
from tests.simulation import simulate

WORLD = {
    "waypoints": {"here": [0, 0], "there": [10, 0]},
    "lanes": [["here", "there"]],
    "docks": {"charger": {"at": [13, 0], "type": "charger"}},
    "items": {"parcel": {"at": [0, 0.5], "weight": 0.2}},
    "robots": {
        "tester": {
            "at": "here",
            "base": {"turning_rate": 1},
            "components": {"claw": {"handling_time": 2}, "battery": {}},
        }
    },
}
FIRST, GOAL, NEXT = (letter * 32 for letter in "abc")
PAUSE = SetSimulationState.Request(state=SimulationState(state=SimulationState.STATE_PAUSED))


def example(action):
    return action.goal.model_validate(action.example)


def _code(result):
    """Return the error code of a result, which the world's actions nest."""
    return result.error_code if hasattr(result, "error_code") else result.result.result


def owner_of(action):
    return THE_WORLD if action.of_world else "tester"


def prepare(action):
    run = simulate(WORLD)
    if action.of_world:
        run.simulator.submit(CallService("set_simulation_state", PAUSE))
    if action.example_after:
        before = registry()[action.example_after]
        run((0.0, SendGoal("tester", before.name, example(before), FIRST)))
    return run, run.simulator.now


def takes_time(action):
    run, now = prepare(action)
    log = run((now, SendGoal(owner_of(action), action.name, example(action), GOAL)))
    return any(at > now for at, _ in log.changes(GOAL))


LASTING = [action for action in registry().values() if takes_time(action)]
INSTANT = [action for action in registry().values() if action not in LASTING]


@pytest.fixture(params=registry().values(), ids=registry())
def action(request):
    return request.param


@pytest.fixture
def owner(action):
    return owner_of(action)


@pytest.fixture
def prepared(action):
    return prepare(action)


def test_its_example_succeeds_and_leaves_the_robot_free(action, owner, prepared):
    run, now = prepared
    log = run((now, SendGoal(owner, action.name, example(action), GOAL)))

    assert "SUCCEEDED" == log.changes(GOAL)[-1][1]
    assert run.simulator.dispatcher.goal_of(owner) is None
    assert isinstance(log.result(GOAL), action.result)


def test_its_result_stays_the_same_after_the_next_goal(action, owner, prepared):
    run, now = prepared
    log = run((now, SendGoal(owner, action.name, example(action), GOAL)))
    later = run.simulator.now
    log = run(
        (later, SendGoal(owner, action.name, example(action), NEXT)),
        (later + 100.0, GetResult(owner, action.name, GOAL, "again")),
    )

    assert log.changes(NEXT)
    assert log.result(GOAL) == log.answer("again").result


@pytest.mark.parametrize("action", LASTING, ids=lambda action: action.name)
def test_a_cancel_ends_it_at_once(action, owner, prepared):
    run, now = prepared
    cancel = CancelGoal(owner, action.name, GOAL, reply_to="cancel")
    log = run((now, SendGoal(owner, action.name, example(action), GOAL)), (now + 0.5, cancel))

    assert (now + 0.5, "CANCELED") == log.changes(GOAL)[-1]
    assert 0 == log.answer("cancel").return_code
    assert "canceled" == error_of(log.result(GOAL))
    assert _code(action.failure(action.codes.canceled, "canceled")) == _code(log.result(GOAL))


@pytest.mark.parametrize("action", INSTANT, ids=lambda action: action.name)
def test_an_instant_action_can_not_be_canceled(action, owner, prepared):
    run, now = prepared
    cancel = CancelGoal(owner, action.name, GOAL, reply_to="cancel")
    log = run((now, SendGoal(owner, action.name, example(action), GOAL)), (now + 0.5, cancel))

    assert (now, "SUCCEEDED") == log.changes(GOAL)[-1]
    assert 3 == log.answer("cancel").return_code


def test_a_robot_can_repeat_the_goal_after_a_cancel(action, owner, prepared):
    run, now = prepared
    log = run(
        (now, SendGoal(owner, action.name, example(action), GOAL)),
        (now + 0.5, CancelGoal(owner, action.name, GOAL)),
        (now + 0.5, SendGoal(owner, action.name, example(action), NEXT)),
    )

    assert "SUCCEEDED" == log.changes(NEXT)[-1][1]


def test_its_last_feedback_precedes_its_end(action, owner, prepared):
    run, now = prepared
    log = run((now, SendGoal(owner, action.name, example(action), GOAL)))

    assert all(isinstance(feedback, action.feedback) for _, feedback in log.feedback(GOAL))
    assert bool(action.feedback.model_fields) == bool(log.feedback(GOAL))
    assert all(at <= log.changes(GOAL)[-1][0] for at, _ in log.feedback(GOAL))


def test_its_messages_survive_json(action):
    for message in (example(action), action.result(), action.feedback()):
        assert message == type(message).model_validate_json(message.model_dump_json())
    payload = json.dumps({"goal_id": GOAL, "goal": action.example}).encode()
    assert example(action) == read(around(SendGoalRequest, action.goal), payload).goal


def test_its_schema_accepts_the_example_but_no_unknown_field(action):
    schema = action_schema(action)
    validator = jsonschema.Draft202012Validator({"$defs": schema["$defs"], **schema["properties"]["send_goal"]})
    goal = action.example

    validator.validate({"goal": goal})
    with pytest.raises(jsonschema.ValidationError, match="Additional properties"):
        validator.validate({"goal": goal | {"colour": "red"}})


def test_its_ros_type_is_that_of_its_messages(action):
    assert [f"{action.ros_type}_{part}" for part in ("Goal", "Result", "Feedback")] == [
        message.ros_type for message in (action.goal, action.result, action.feedback)
    ]


def test_the_error_of_a_nav2_result_is_its_text():
    assert "no way" == error_of(NavigateToPose.Result(error_code=208, error_msg="no way"))


def test_the_error_of_a_moveit_result_is_its_message():
    assert "too far" == error_of(Pickup.Result(error_code=MoveItErrorCodes(val=-1, message="too far")))


def test_a_result_without_an_error_has_no_text():
    assert "" == error_of(Wait.Result())
