"""The states of doors, and closed lanes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from hmrsim.events.facilities import DoorClosed, DoorOpened, DoorOpening
from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.events.traffic import LaneClosed, LaneOpened
from hmrsim.history.occurrence import SceneSeen, lane, records, text, texts
from hmrsim.properties.observing.signal import Signal

if TYPE_CHECKING:
    from hmrsim.history.timeline import Timeline
    from hmrsim.world.model import World

_STATES: Final[Mapping[type, str]] = {DoorOpening: "opening", DoorOpened: "open", DoorClosed: "closed"}
_JAMMED: Final = "jammed"
_FAULT: Final = "door_jammed"


class Doors:
    """Follows the doors of a world."""

    def __init__(self, world: World, timeline: Timeline) -> None:
        self._world = world
        self._states: dict[str, str] = {}
        self._jams: dict[str, str] = {}
        self._signals: dict[tuple[str, str], Signal] = {}
        self.begin_anew()
        for kind in _STATES:
            timeline.on(kind, lambda _at, event: self._change(event.door, _STATES[type(event)]))
        for fault in (FaultBegan, FaultEnded):
            timeline.on(fault, self._fault)
        timeline.on(SceneSeen, self._see)

    def is_(self, door: str, state: str) -> Signal:
        """Return whether a door is in a state; a jammed one is open or closed, too."""
        signal = self._signals.get((door, state))
        if signal is None:
            signal = self._signals[door, state] = Signal()
            self._settle(door)
        return signal

    def begin_anew(self) -> None:
        """Let all doors be as they are at the start."""
        self._jams.clear()
        for name, door in self._world.doors.items():
            self._change(name, "open" if door.open else "closed")

    def _change(self, door: str, state: str) -> None:
        self._states[door] = state
        self._settle(door)

    def _fault(self, _at: int, event: FaultBegan | FaultEnded) -> None:
        door = event.settings.get("door")
        if event.fault == _FAULT and isinstance(door, str):
            if isinstance(event, FaultBegan):
                self._jams[event.name] = door
            else:
                self._jams.pop(event.name, None)
            self._settle(door)

    def _see(self, at: int, scene: SceneSeen) -> None:
        for fixture in records(scene.fields, "fixtures"):
            tags = texts(fixture, "tags")
            state = next((tag for tag in tags if tag in _STATES.values()), None)
            if fixture.get("kind") == "door" and state is not None:
                self._change(text(fixture, "name"), state)
        self._jams.clear()
        for fault in records(scene.fields, "faults"):
            self._fault(at, FaultBegan.from_json(fault))

    def _settle(self, door: str) -> None:
        for (name, state), signal in self._signals.items():
            if name == door:
                jammed = state == _JAMMED and door in self._jams.values()
                signal.say(holds=jammed or state == self._states.get(door))


class Lanes:
    """Follows which lanes are closed."""

    def __init__(self, timeline: Timeline) -> None:
        self._closed: dict[tuple[str, str], Signal] = {}
        timeline.on(LaneClosed, lambda _at, event: self.closed(event.lane).say(holds=True))
        timeline.on(LaneOpened, lambda _at, event: self.closed(event.lane).say(holds=False))
        timeline.on(SceneSeen, self._see)

    def closed(self, named: tuple[str, str]) -> Signal:
        """Return whether a lane is closed."""
        return self._closed.setdefault((named[0], named[1]), Signal())

    def begin_anew(self) -> None:
        """Let all lanes be open."""
        for signal in self._closed.values():
            signal.say(holds=False)

    def _see(self, _at: int, scene: SceneSeen) -> None:
        self.begin_anew()
        for said in records(scene.fields, "closed_lanes"):
            named = lane(said)
            if named is not None:
                self.closed(named).say(holds=True)
