"""What a recording's ``/rosout`` says: goals and how they ended, faults, who waits for whom."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from hmrsim.actions import registry as actions
from hmrsim.cli.goal_summary import error_in, summary
from hmrsim.cli.telling import words_for
from hmrsim.errors import printable
from hmrsim.interfaces.message import Message
from hmrsim.interfaces.rcl_interfaces import Log
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.recording.recorder import Told

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

_NOBODY: Final = "world"
"""Whose events are whose that no robot is named in."""

_GRAVE: Final[Mapping[str, int]] = {
    "rejected": Log.WARN,
    "waiting": Log.WARN,
    "battery_low": Log.WARN,
    "battery_critical": Log.WARN,
    "fault_began": Log.WARN,
    "simulator_returned": Log.WARN,
    "battery_empty": Log.ERROR,
    "deadlock": Log.ERROR,
}
_ENDS: Final[Mapping[GoalStatus, int]] = {
    GoalStatus.SUCCEEDED: Log.INFO,
    GoalStatus.CANCELED: Log.WARN,
    GoalStatus.ABORTED: Log.ERROR,
}


def told(event: Mapping[str, Any]) -> Told | None:
    """Return what people are told of an event of ``_world/events``; None for nothing."""
    kind = event["kind"]
    words = _WORDS.get(kind, words_for)(event)
    level = _ENDS.get(event["status"], Log.INFO) if kind == "status" else _GRAVE.get(kind, Log.INFO)
    return Told(level, str(event.get("robot") or event.get("entity") or _NOBODY), printable(words)) if words else None


def _asked(event: Mapping[str, Any]) -> str:
    action = actions().get(event["action"])
    try:
        goal = summary(action.goal.model_validate(event["goal"])) if action else ""
    except ValidationError:
        # Of a simulator of another version.
        goal = ""
    return f"{event['action']} accepted {goal}".strip()


def _ended(event: Mapping[str, Any]) -> str:
    status, result = GoalStatus(event["status"]), event.get("result")
    if status not in _ENDS:
        return ""
    plain = result.model_dump(mode="json") if isinstance(result, Message) else result or {}
    why = error_in(plain) if status is GoalStatus.ABORTED else ""
    return f"{event['action']} {status.name}{f': {why}' if why else ''}"


def _of_entity(words: str) -> Callable[[Mapping[str, Any]], str]:
    return lambda _event: words


_WORDS: Final[Mapping[str, Callable[[Mapping[str, Any]], str]]] = {
    "goal": _asked,
    "status": _ended,
    "rejected": lambda event: f"{event['action']} rejected: {event['error_msg']}",
    "picked": lambda event: f"picked up {event['item']}",
    "placed": lambda event: f"put down {event['item']}",
    "dropped": lambda event: f"dropped {event['item']}",
    "spawned": _of_entity("was spawned"),
    "deleted": _of_entity("was deleted"),
    "teleported": _of_entity("was put elsewhere"),
    "reset": _of_entity("was reset"),
    "world_loaded": lambda event: f"is {event['name']} now",
    "simulator_returned": _of_entity("the simulator was out of reach, and is there again"),
}
