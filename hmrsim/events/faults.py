"""Events of faults that begin and end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup, Part


class FaultEvent(Event, subject=("robot", "door", "lane", "dock", "lift", "item"), rest="settings"):
    """An event of a fault. In JSON the settings are fields of the event: `robot`, `at`, `duration`, ...

    Note:
        The field `at` of a fault is a time, in simulated seconds.
    """

    fault: Annotated[str, Field(description="The fault's type, such as `breakdown`.")]
    name: Annotated[str, Field(description="The fault's name.")]
    settings: Annotated[Mapping[str, Any], Field(description="The fault's settings, each a separate field in JSON.")]

    @property
    def robot(self) -> str:
        """The robot that has the fault; empty if the subject is not a robot."""
        robot = self.settings.get("robot", "")
        return robot if isinstance(robot, str) else ""


class FaultBegan(
    FaultEvent,
    kind="fault_began",
    severity="warning",
    text="has the fault {name} ({fault})",
    changes=Part.FAULTS,
    sets={"active": True},
):
    """A fault begins at its subject."""


class FaultEnded(
    FaultEvent,
    kind="fault_ended",
    text="no longer has the fault {name} ({fault})",
    changes=Part.FAULTS,
    sets={"active": False},
):
    """A fault ends at its subject."""


class FaultMissed(
    FaultEvent, kind="fault_missed", severity="warning", text="is not hit by the fault {name} ({fault}): {why}"
):
    """A fault is due but does not begin because its subject, or a component of its robot, does not exist."""

    why: Annotated[str, Field(description="The missing subject or component.")]


EVENTS: Final = EventGroup("faults", (FaultBegan, FaultEnded, FaultMissed))
