"""The parts of the picture of a world that events change."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Any, NamedTuple


class Part(StrEnum):
    """A part of what a client that draws the world keeps; most are fields of ``_world/scene``.

    The page changes its picture by the part that an event's kind declares, never by the kind.
    """

    MOTION = "robots.motion"
    ROUTE = "robots.route"
    POSE = "robots.pose"
    WAITING = "robots.waiting"
    YIELDING = "robots.yielding"
    GOALS = "robots.goals"
    DOCK = "robots.dock"
    BATTERY = "robots.battery"
    SCRIPT = "robots.script"
    CARRIER = "items.carrier"
    ENTITIES = "entities"
    DOOR = "fixtures.door"
    LIFT = "fixtures.lift"
    CLOSED_LANES = "closed_lanes"
    DEADLOCKS = "deadlocks"
    FAULTS = "faults"
    ORDERS = "orders"
    PARTICIPANTS = "participants"
    PLANNER = "planner_present"
    STATE = "simulation_state"
    SCENE = "scene"
    WORLD = "world"


class Change(NamedTuple):
    """What an event of a kind changes.

    Attributes:
        part: What of the picture; one of `Part`.
        sets: Values beside the fields of the event, which tell kinds that change one part from each other.
    """

    part: str
    sets: Mapping[str, Any]
