"""The messages of events in logs, recordings and the demo."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import ValidationError

from hmrsim.actions import registry as actions
from hmrsim.cli.goal_summary import summary
from hmrsim.events import Severity
from hmrsim.events.goals import GoalAccepted

if TYPE_CHECKING:
    from hmrsim.events import Event


def text_of(event: Event) -> str:
    """Return the text of an event without its subject; "" for one that is too frequent for a log."""
    if event.severity is Severity.DEBUG:
        return ""
    return event.text({"goal": lambda _goal: _asked(event)}) if isinstance(event, GoalAccepted) else event.text()


def _asked(event: GoalAccepted) -> str:
    action = actions().get(event.action)
    try:
        return summary(action.goal.model_validate(event.goal)) if action else ""
    except ValidationError:
        # From a simulator of another version.
        return ""
