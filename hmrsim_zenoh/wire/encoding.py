"""The encoding of events and answers as JSON, with the names of the encodings on the wire."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pydantic_core import to_json

from hmrsim.interfaces.action_msgs import CancelGoal, GoalStatusArray
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.message import Message
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim_zenoh.wire.envelopes import dump

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.protocol.goal import CancelResponse, GoalEntry, GoalResponse, ResultResponse
    from hmrsim.protocol.outputs import StatusChanged

JSON = "application/json"
CANCEL_RESPONSE = f"{JSON};{CancelGoal.Response.ros_type}"
STATUS = f"{JSON};{GoalStatusArray.ros_type}"
EVENT = f"{JSON};hmrsim/Event"
INFO = f"{JSON};hmrsim/WorldInfo"
ROUTE_GRAPH = f"{JSON};hmrsim/RouteGraph"
SCENE = f"{JSON};hmrsim/Scene"
DEMAND = f"{JSON};hmrsim/Demand"
VIEW = f"{JSON};hmrsim/View"

_MAX_SHOWN = 200
"""Characters of an invalid goal id that an error shows."""


def of_message(message: Message) -> str:
    """Return the encoding of a ROS message."""
    return f"{JSON};{message.ros_type}"


def ros_type(mime: str) -> str:
    """Return the ROS type that an encoding names; an empty text if it names none."""
    return mime.partition(";")[2]


def of_action(action: AnyAction, part: str) -> str:
    """Return the encoding of a part of an action, such as ``FeedbackMessage``."""
    return f"{JSON};{action.ros_type}_{part}"


def message(value: Message) -> bytes:
    """Return a ROS message as JSON."""
    return value.__pydantic_serializer__.to_json(value)


def _stamp(nanoseconds: int) -> str:
    sec, nanosec = divmod(nanoseconds, NANOSECONDS)
    return f'{{"sec":{sec},"nanosec":{nanosec}}}'


def _stamp_fields(nanoseconds: int) -> dict[str, int]:
    sec, nanosec = divmod(nanoseconds, NANOSECONDS)
    return {"sec": sec, "nanosec": nanosec}


def _goal_info(entry: GoalEntry) -> str:
    return f'{{"goal_id":"{entry.goal_id}","stamp":{_stamp(entry.stamp)}}}'


def goal_response(answer: GoalResponse) -> bytes:
    """Return the answer to send_goal."""
    if answer.accepted:
        sec, nanosec = divmod(answer.stamp, NANOSECONDS)
        return b'{"accepted":true,"goal_id":"%b","stamp":{"sec":%d,"nanosec":%d}}' % (
            answer.goal_id.encode(),
            sec,
            nanosec,
        )
    fields: dict[str, Any] = {
        "accepted": False,
        "goal_id": answer.goal_id[:_MAX_SHOWN],
        "stamp": _stamp_fields(answer.stamp),
        "reason": answer.reason,
        "error_code": answer.error_code,
        "error_msg": answer.error_msg,
    }
    if answer.status is not None:
        fields["status"] = int(answer.status)
    return dump(fields)


def cancel_response(answer: CancelResponse) -> bytes:
    """Return the answer to cancel_goal."""
    goals = ",".join(_goal_info(entry) for entry in answer.goals_canceling)
    return f'{{"return_code":{answer.return_code},"goals_canceling":[{goals}]}}'.encode()


def result_response(answer: ResultResponse) -> bytes:
    """Return the answer to get_result."""
    return b'{"status":%d,"result":%b}' % (answer.status, message(answer.result))


def cause(name: str) -> bytes:
    """Return the JSON field with the cause of a goal's failure; an empty text if there is no cause."""
    return b'"cause":"%b",' % name.encode() if name else b""


def feedback_message(goal_id: str, feedback: Message | Mapping[str, Any]) -> bytes:
    """Return the message on a feedback key."""
    return b'{"goal_id":"%b","feedback":%b}' % (goal_id.encode(), feedback_body(feedback))


def feedback_body(feedback: Message | Mapping[str, Any]) -> bytes:
    """Return feedback as JSON, without the id of its goal."""
    return message(feedback) if isinstance(feedback, Message) else to_json(feedback)


def status_array(event: StatusChanged) -> bytes:
    """Return the message on a status key."""
    entries = ",".join(f'{{"goal_info":{_goal_info(entry)},"status":{int(entry.status)}}}' for entry in event.goals)
    return f'{{"status_list":[{entries}]}}'.encode()


def event_payload(event: GoalChanged | EventStamped) -> bytes:
    """Return an event as a message of ``_world/events``."""
    if isinstance(event, EventStamped):
        inner = event.event
        return dump({"stamp": _stamp_fields(event.stamp), "kind": inner.kind, **inner.as_dict()})
    head = (
        f'{{"stamp":{_stamp(event.stamp)},"kind":"status","robot":"{event.robot}","action":"{event.action}",'
        f'"goal_id":"{event.goal_id}","status":{int(event.status)}'
    )
    if event.result is None:
        return f"{head}}}".encode()
    return head.encode() + b',%b"result":' % cause(event.cause) + message(event.result) + b"}"


def error(text: str, field: str = "", value: object = None) -> bytes:
    """Return the body of an error reply with a single error."""
    return dump({"error": text, "details": [{"field": field, "message": text, "value": value}]})
