"""What happens in the world, in a few words for people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    Words = Callable[[Mapping[str, Any]], str]


def words_for(event: Mapping[str, Any]) -> str:
    """Return what an event of ``_world/events`` says beside goals, items and motion; "" if that is too little."""
    words = _WORDS.get(event["kind"])
    return words(event) if words else ""


def _waits(event: Mapping[str, Any]) -> str:
    return f"waits: {event['why']}" if event.get("why") else f"waits for {' and '.join(event['for']) or 'its turn'}"


def _share(event: Mapping[str, Any]) -> str:
    return f"{event['percentage']:.0%}"


_WORDS: Mapping[str, Words] = {
    "waiting": _waits,
    "rerouted": lambda _event: "takes another way",
    "made_room": lambda event: f"makes room for {event['by']}",
    "deadlock": lambda event: f"deadlock of {', '.join(event['robots'])}",
    "fault_began": lambda event: f"{event['name']} begins ({event['fault']})",
    "fault_ended": lambda event: f"{event['name']} is over",
    "dock_queued": lambda event: f"queues for {event['dock']}, as number {event['position']}",
    "dock_docked": lambda event: f"docked at {event['dock']}",
    "dock_undocked": lambda event: f"left {event['dock']}",
    "battery_low": lambda event: f"battery low, {_share(event)}",
    "battery_critical": lambda event: f"battery critical, {_share(event)}",
    "battery_empty": lambda _event: "battery empty",
    "battery_full": lambda _event: "battery full",
}
"""Doors, lifts and lanes open and close too often to be told."""
