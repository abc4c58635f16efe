"""The states of a vehicle, the events that move it between them, and the one table of transitions.

Two rules: nothing else in hmrsim sets a vehicle's state, and this module knows neither routes nor traffic.

A vehicle stands, moves, or waits on its way::

                  ┌──────────set_out──────────► DRIVING ──block──► BLOCKED ─┐
                  │                              ▲   ▲                      │
                  │                              │   └─────resume, reroute──┤
    IDLE ◄──────► WORKING                        └─────resume, reroute──┐   │
     │  │                                                               │   │
     │  ├────────────yield───► YIELDING ──────────arrive───────► YIELDED   yield
     │  │                        ▲  └──block──► YIELD_BLOCKED           │   │
     │  │                        └──────────────resume, reroute, yield──┴───┘
     │  └────────────maneuver──► MANEUVERING ──block──► MANEUVER_BLOCKED
     │
     └──disable, enable──► DISABLED

A moving or waiting vehicle returns to IDLE by ``arrive`` at the end of its route, and by ``halt`` anywhere on it.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Final


class VehicleState(Enum):
    """The activity of a vehicle.

    Attributes:
        stands: Whether it goes nowhere.
        moves: Whether it is in motion.
        waits: Whether it has stopped before the end of its route or motion.
        yields: Whether it drives aside for another vehicle, or waits on the way there.
        maneuvers: Whether it carries out one motion, or waits to begin it.
        needs_admission: Whether it asks for the right of way before each lane.
    """

    IDLE = "idle"
    """It stands, and yields to others."""
    WORKING = "working"
    """It stands still for its goal, and yields to no other vehicle."""
    DISABLED = "disabled"
    """It stands, and can do nothing."""
    DRIVING = "driving"
    """It follows a route, with its lanes and turns, and asks for the right of way before each lane."""
    MANEUVERING = "maneuvering"
    """It carries out one motion, such as a spin, and asks for no right of way."""
    YIELDING = "yielding"
    """It drives aside for another vehicle."""
    BLOCKED = "blocked"
    """It waits for the right of way."""
    MANEUVER_BLOCKED = "maneuver_blocked"
    """It was stopped at the instant at which it began a maneuver."""
    YIELD_BLOCKED = "yield_blocked"
    """It waits for the right of way to the place where it yields."""
    YIELDED = "yielded"
    """It waits aside until traffic lets it resume its route."""

    stands: bool
    moves: bool
    waits: bool
    yields: bool
    maneuvers: bool
    needs_admission: bool

    __hash__ = object.__hash__
    """Enum's own hash is written in Python and would dominate the cost of a transition."""

    def __init__(self, name: str) -> None:
        # Attributes of the members: each is looked up several times a lane.
        self.moves = name.endswith("ing") and name != "working"
        self.waits = name.endswith("blocked") or name == "yielded"
        self.stands = not (self.moves or self.waits)
        self.yields = name in {"yielding", "yield_blocked"}
        self.maneuvers = name.startswith("maneuver")
        self.needs_admission = not (self.stands or self.maneuvers)


class VehicleEvent(Enum):
    """The events that change a vehicle's state."""

    __hash__ = object.__hash__

    SET_OUT = "set_out"
    """It begins to follow a route."""
    MANEUVER = "maneuver"
    """It begins a motion that asks for no right of way."""
    YIELD = "yield"
    """It begins to drive aside for another vehicle."""
    BLOCK = "block"
    """It gets no right of way, or loses it at the instant at which it sets out."""
    RESUME = "resume"
    """It goes on from where it waits."""
    REROUTE = "reroute"
    """It takes another route from where it waits."""
    REDIRECT = "redirect"
    """It gets another route, to follow after it has yielded."""
    RESCALE = "rescale"
    """It goes on at another speed."""
    ARRIVE = "arrive"
    """It reaches the end of its route; a vehicle that has yielded has no route to resume."""
    HALT = "halt"
    """It stops where it is, for good."""
    WORK = "work"
    """Its goal needs it to stand still."""
    FINISH_WORK = "finish_work"
    """Its goal no longer needs it to stand still."""
    DISABLE = "disable"
    """It can do nothing from now on."""
    ENABLE = "enable"
    """It can be used again."""


TRANSITIONS: Final[Mapping[tuple[VehicleState, VehicleEvent], VehicleState]] = {
    (VehicleState.IDLE, VehicleEvent.SET_OUT): VehicleState.DRIVING,
    (VehicleState.IDLE, VehicleEvent.MANEUVER): VehicleState.MANEUVERING,
    (VehicleState.IDLE, VehicleEvent.YIELD): VehicleState.YIELDING,
    (VehicleState.IDLE, VehicleEvent.WORK): VehicleState.WORKING,
    (VehicleState.IDLE, VehicleEvent.DISABLE): VehicleState.DISABLED,
    # Goals that do not hold the base run beside others: one may drive while another has it stand still.
    (VehicleState.WORKING, VehicleEvent.SET_OUT): VehicleState.DRIVING,
    (VehicleState.WORKING, VehicleEvent.MANEUVER): VehicleState.MANEUVERING,
    (VehicleState.WORKING, VehicleEvent.WORK): VehicleState.WORKING,
    (VehicleState.WORKING, VehicleEvent.FINISH_WORK): VehicleState.IDLE,
    (VehicleState.WORKING, VehicleEvent.DISABLE): VehicleState.DISABLED,
    (VehicleState.DISABLED, VehicleEvent.WORK): VehicleState.DISABLED,
    (VehicleState.DISABLED, VehicleEvent.DISABLE): VehicleState.DISABLED,
    (VehicleState.DISABLED, VehicleEvent.ENABLE): VehicleState.IDLE,
    (VehicleState.DRIVING, VehicleEvent.BLOCK): VehicleState.BLOCKED,
    (VehicleState.DRIVING, VehicleEvent.RESCALE): VehicleState.DRIVING,
    (VehicleState.DRIVING, VehicleEvent.ARRIVE): VehicleState.IDLE,
    (VehicleState.DRIVING, VehicleEvent.HALT): VehicleState.IDLE,
    (VehicleState.BLOCKED, VehicleEvent.RESUME): VehicleState.DRIVING,
    (VehicleState.BLOCKED, VehicleEvent.REROUTE): VehicleState.DRIVING,
    (VehicleState.BLOCKED, VehicleEvent.YIELD): VehicleState.YIELDING,
    (VehicleState.BLOCKED, VehicleEvent.RESCALE): VehicleState.BLOCKED,
    (VehicleState.BLOCKED, VehicleEvent.HALT): VehicleState.IDLE,
    (VehicleState.MANEUVERING, VehicleEvent.BLOCK): VehicleState.MANEUVER_BLOCKED,
    (VehicleState.MANEUVERING, VehicleEvent.ARRIVE): VehicleState.IDLE,
    (VehicleState.MANEUVERING, VehicleEvent.HALT): VehicleState.IDLE,
    (VehicleState.MANEUVER_BLOCKED, VehicleEvent.RESUME): VehicleState.MANEUVERING,
    (VehicleState.MANEUVER_BLOCKED, VehicleEvent.HALT): VehicleState.IDLE,
    (VehicleState.YIELDING, VehicleEvent.BLOCK): VehicleState.YIELD_BLOCKED,
    (VehicleState.YIELDING, VehicleEvent.REDIRECT): VehicleState.YIELDING,
    (VehicleState.YIELDING, VehicleEvent.RESCALE): VehicleState.YIELDING,
    (VehicleState.YIELDING, VehicleEvent.ARRIVE): VehicleState.YIELDED,
    (VehicleState.YIELDING, VehicleEvent.HALT): VehicleState.IDLE,
    (VehicleState.YIELD_BLOCKED, VehicleEvent.RESUME): VehicleState.YIELDING,
    (VehicleState.YIELD_BLOCKED, VehicleEvent.REROUTE): VehicleState.YIELDING,
    (VehicleState.YIELD_BLOCKED, VehicleEvent.REDIRECT): VehicleState.YIELD_BLOCKED,
    (VehicleState.YIELD_BLOCKED, VehicleEvent.RESCALE): VehicleState.YIELD_BLOCKED,
    (VehicleState.YIELD_BLOCKED, VehicleEvent.YIELD): VehicleState.YIELDING,
    (VehicleState.YIELD_BLOCKED, VehicleEvent.HALT): VehicleState.IDLE,
    (VehicleState.YIELDED, VehicleEvent.RESUME): VehicleState.DRIVING,
    (VehicleState.YIELDED, VehicleEvent.REROUTE): VehicleState.DRIVING,
    (VehicleState.YIELDED, VehicleEvent.YIELD): VehicleState.YIELDING,
    (VehicleState.YIELDED, VehicleEvent.RESCALE): VehicleState.YIELDED,
    (VehicleState.YIELDED, VehicleEvent.ARRIVE): VehicleState.IDLE,
    (VehicleState.YIELDED, VehicleEvent.HALT): VehicleState.IDLE,
}
"""All legal transitions; any other event is illegal in that state."""


class IllegalTransition(RuntimeError):
    """An event met a vehicle in a state in which it is illegal; the state stays as it was."""


def next_state(state: VehicleState, event: VehicleEvent) -> VehicleState:
    """Return the state that *event* leads to.

    Raises:
        IllegalTransition: The event is illegal in this state, which is a bug of the caller.
    """
    try:
        return TRANSITIONS[state, event]
    except KeyError:
        raise IllegalTransition(f"{event.value} is illegal for a vehicle that is {state.value}") from None
