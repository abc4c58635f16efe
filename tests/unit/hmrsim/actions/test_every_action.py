"""What every action in the registry promises."""

from __future__ import annotations

import json

import jsonschema
import pytest

from hmrsim.actions import error_of, registry
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
    """Return an action's example as a goal."""
    return action.goal.model_validate(action.example)


def _code(result):
    """Return the error code of a result, which the simulation's have inside of their own result."""
    return result.error_code if hasattr(result, "error_code") else result.result.result


def owner_of(action):
    """Return who serves an action."""
    return THE_WORLD if action.of_world else "tester"


def prepare(action):
    """Return a simulation in which an action's example can be done, and the time at which."""
    run = simulate(WORLD)
    if action.of_world:
        run.simulator.submit(CallService("set_simulation_state", PAUSE))
    if action.example_after:
        before = registry()[action.example_after]
        run((0.0, SendGoal("tester", before.name, example(before), FIRST)))
    return run, run.simulator.now


def takes_time(action):
    """Return whether the example of an action does not end at the instant at which it is asked for."""
    run, now = prepare(action)
    log = run((now, SendGoal(owner_of(action), action.name, example(action), GOAL)))
    return any(at > now for at, _ in log.changes(GOAL))


LASTING = [action for action in registry().values() if takes_time(action)]
INSTANT = [action for action in registry().values() if action not in LASTING]


@pytest.fixture(params=registry().values(), ids=registry())
def action(request):
    """Return each action in turn."""
    return request.param


@pytest.fixture
def owner(action):
    """Return who serves the action."""
    return owner_of(action)


@pytest.fixture
def prepared(action):
    """Return a simulation in which the action's example can be done, and the time at which."""
    return prepare(action)


def test_its_example_succeeds_and_leaves_the_robot_free(action, owner, prepared):
    """The goal ends SUCCEEDED, and nothing is scheduled any more."""
    run, now = prepared
    log = run((now, SendGoal(owner, action.name, example(action), GOAL)))

    assert "SUCCEEDED" == log.changes(GOAL)[-1][1]
    assert run.simulator.dispatcher.goal_of(owner) is None
    assert isinstance(log.result(GOAL), action.result)


def test_its_result_can_be_read_when_the_next_goal_has_ended(action, owner, prepared):
    """It is the same as at its end."""
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
def test_it_is_canceled_at_the_instant_of_a_cancel(action, owner, prepared):
    """In the middle of it: CANCELED then and there, with its code and 'canceled'."""
    run, now = prepared
    cancel = CancelGoal(owner, action.name, GOAL, reply_to="cancel")
    log = run((now, SendGoal(owner, action.name, example(action), GOAL)), (now + 0.5, cancel))

    assert (now + 0.5, "CANCELED") == log.changes(GOAL)[-1]
    assert 0 == log.answer("cancel").return_code
    assert "canceled" == error_of(log.result(GOAL))
    assert _code(action.failure(action.codes.canceled, "canceled")) == _code(log.result(GOAL))


@pytest.mark.parametrize("action", INSTANT, ids=lambda action: action.name)
def test_one_that_takes_no_time_can_not_be_canceled_any_more(action, owner, prepared):
    """It has succeeded already, without taking any time."""
    run, now = prepared
    cancel = CancelGoal(owner, action.name, GOAL, reply_to="cancel")
    log = run((now, SendGoal(owner, action.name, example(action), GOAL)), (now + 0.5, cancel))

    assert (now, "SUCCEEDED") == log.changes(GOAL)[-1]
    assert 3 == log.answer("cancel").return_code


def test_a_robot_can_go_on_after_a_cancel(action, owner, prepared):
    """The same goal, sent again, succeeds."""
    run, now = prepared
    log = run(
        (now, SendGoal(owner, action.name, example(action), GOAL)),
        (now + 0.5, CancelGoal(owner, action.name, GOAL)),
        (now + 0.5, SendGoal(owner, action.name, example(action), NEXT)),
    )

    assert "SUCCEEDED" == log.changes(NEXT)[-1][1]


def test_its_last_feedback_comes_before_its_end(action, owner, prepared):
    """It reports something of its own type, if that has any fields, and nothing afterwards."""
    run, now = prepared
    log = run((now, SendGoal(owner, action.name, example(action), GOAL)))

    assert all(isinstance(feedback, action.feedback) for _, feedback in log.feedback(GOAL))
    assert bool(action.feedback.model_fields) == bool(log.feedback(GOAL))
    assert all(at <= log.changes(GOAL)[-1][0] for at, _ in log.feedback(GOAL))


def test_its_messages_survive_json(action):
    """Goal, result and feedback are the same after a round trip; so is the envelope."""
    for message in (example(action), action.result(), action.feedback()):
        assert message == type(message).model_validate_json(message.model_dump_json())
    payload = json.dumps({"goal_id": GOAL, "goal": action.example}).encode()
    assert example(action) == read(around(SendGoalRequest, action.goal), payload).goal


def test_its_schema_takes_its_example_and_refuses_an_unknown_field(action):
    """The schema says what the server does."""
    schema = action_schema(action)
    validator = jsonschema.Draft202012Validator({"$defs": schema["$defs"], **schema["properties"]["send_goal"]})
    goal = action.example

    validator.validate({"goal": goal})
    with pytest.raises(jsonschema.ValidationError, match="Additional properties"):
        validator.validate({"goal": goal | {"colour": "red"}})


def test_its_ros_type_is_that_of_its_messages(action):
    """One name, spelled once."""
    assert [f"{action.ros_type}_{part}" for part in ("Goal", "Result", "Feedback")] == [
        message.ros_type for message in (action.goal, action.result, action.feedback)
    ]
