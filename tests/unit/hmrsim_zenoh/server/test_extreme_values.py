"""No value of a request ends the simulator, keeps it busy for ever, or comes out as what JSON can't state."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from hmrsim.actions import registry as actions
from hmrsim.protocol.commands import CallService, SendGoal
from hmrsim.protocol.goal import WORLD, CancelResponse, GoalResponse, Refused, ResultResponse
from hmrsim.protocol.outputs import Answered, EventStamped, FeedbackSent, GoalChanged, Sampled, StatusChanged
from hmrsim.services import registry as services
from hmrsim_zenoh.wire import encoding
from tests.extremes import bodies
from tests.profiles import examples
from tests.simulation import simulate

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Topic

WORLD_FILE = {
    "waypoints": {"home": [1, 2], "door": [5, 2], "shelf": [9, 2]},
    "lanes": [["home", "door"], ["door", "shelf"]],
    "items": {"parcel": {"at": [9, 2.3]}},
    "docks": {"berth": {"at": "home"}},
    "robot_types": {
        "nurse": {
            "base": {"turning_rate": 1.0, "acceleration": 0.5},
            "components": {"claw": {}, "camera": {}, "battery": {"capacity": 1e6, "drain": {"default": 1}}},
        }
    },
    "robots": {"wall_e": {"type": "nurse", "at": "home"}, "eve": {"type": "nurse", "at": "shelf"}},
    "traffic": {"policy": "reserve"},
}
NAMES = [
    "wall_e",
    "eve",
    "parcel",
    "berth",
    "home",
    "map",
    "",
    "breakdown",
    "slip",
    "localisation_jump",
    "robot_type:nurse",
]
MOST_EVENTS = 300
FAR = 1e12

ACTIONS = sorted(actions())
SERVICES = sorted(name for name, service in services().items() if name != "load_world")


class Encoding:
    """A sink that encodes every output as for clients."""

    def emit(self, output: Output) -> None:
        """Encode an output of the simulation."""
        match output:
            case GoalChanged() | EventStamped():
                payload = encoding.event_payload(output)
            case FeedbackSent():
                payload = encoding.feedback_message(output.goal_id, output.feedback)
            case StatusChanged():
                payload = encoding.status_array(output)
            case Sampled():
                payload = encoding.message(output.message)
            case Answered():
                payload = _answer(output.answer)
            case _:
                return
        json.loads(payload, parse_constant=_no_constant)

    def wants(self, _topic: Topic) -> bool:
        """Return True: every topic has a subscriber."""
        return True


def _no_constant(text: str) -> None:
    raise ValueError(f"JSON has no {text}")


def _answer(answer: Any) -> bytes:
    match answer:
        case GoalResponse():
            return encoding.goal_response(answer)
        case CancelResponse():
            return encoding.cancel_response(answer)
        case ResultResponse():
            return encoding.result_response(answer)
        case Refused(field, value, text):
            return encoding.error(text, field, value)
        case _:
            return encoding.message(answer)


def run_of(world: object = None) -> Any:
    """Return a simulation that encodes every output and ends at the first bug."""
    return simulate(world or WORLD_FILE, sinks=[Encoding()], odom_rate=1e-9, detection_rate=1e-9, feedback_rate=1e-9)


def read(kind: Any, body: dict[str, Any]) -> Any:
    """Return the message of a body; None if the body is refused."""
    try:
        return kind.model_validate_json(json.dumps(body))
    except ValidationError:
        return None


def go_on(run: Any) -> None:
    """Run for some simulated time as fast as possible."""
    left = MOST_EVENTS
    while left > 0 and run.simulator.process_events(FAR, 100, idle=False):
        left -= 100


@pytest.mark.parametrize("action", ACTIONS)
def test_no_goal_ends_the_simulator(action):
    """The goal is rejected or ends, and another goal continues."""

    @examples(30)
    @given(body=bodies(actions()[action].goal, NAMES), robot=st.sampled_from(["wall_e", "eve"]))
    def try_one(body, robot):
        goal = read(actions()[action].goal, body)
        if goal is None:
            return
        run = run_of()
        whose = WORLD if actions()[action].of_world else robot
        run.simulator.submit(SendGoal(whose, action, goal, f"{1:032x}", "reply"))
        go_on(run)

        assert 1 == len(run.log.answers("reply"))
        assert sum(status in {"SUCCEEDED", "ABORTED"} for _, status in run.log.changes(f"{1:032x}")) <= 1

    try_one()


@pytest.mark.parametrize("service", SERVICES)
def test_no_request_of_a_service_ends_the_simulator(service):
    """The request is refused or answered, and goals continue."""

    @examples(30)
    @given(body=bodies(services()[service].request, NAMES))
    def try_one(body):
        request = read(services()[service].request, body)
        if request is None:
            return
        run = run_of()
        goal = actions()["navigate_to_pose"].goal.model_validate({"pose": {"pose": {"position": {"x": 9.0, "y": 2.0}}}})
        run.simulator.submit(SendGoal("wall_e", "navigate_to_pose", goal, f"{1:032x}"))
        run.simulator.advance(1.0)
        run.simulator.submit(CallService(service, request, "reply"))
        go_on(run)

        assert len(run.log.answers("reply")) <= 1

    try_one()
