"""The topics of robots and of the world; topics that no sink wants are not computed."""

from __future__ import annotations

from enum import Enum


class Topic(Enum):
    """The topics that a sink may want."""

    __hash__ = object.__hash__
    """Faster than Enum's, which is written in Python."""

    STATUS = "status"
    FEEDBACK = "feedback"
    ODOM = "odom"
    BATTERY_STATE = "battery_state"
    DETECTIONS = "detections"
    CLOCK = "clock"
    EVENTS = "events"
    MOTION = "motion"
    """The topic of the events that are not in traces (`hmrsim.events.Event.traced`)."""
    TIME = "time/state"
    """The state of time, and the participants that it waits for."""
