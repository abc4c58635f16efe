"""The facilities of a run: the states of doors and lanes, and the usage of doors, lanes, lifts and docks."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Generic, TypeVar

from hmrsim.events.facilities import DoorClosed, DoorOpened, DoorOpening, LiftArrived, LiftCalled, LiftDeparted
from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.events.robots import Docked, DockQueued, Undocked
from hmrsim.events.traffic import LaneClosed, LaneOpened
from hmrsim.history.occurrence import SceneSeen, lane, records, text, texts
from hmrsim.history.timeline import Part

if TYPE_CHECKING:
    from hmrsim.history.timeline import Timeline
    from hmrsim.world.model import World

N = TypeVar("N", str, tuple[str, str])
"""The name of a facility; a lane is named by its waypoints."""


@dataclass(slots=True)
class Use:
    """The usage of one facility; times in nanoseconds.

    Attributes:
        robots: The robots that have used it.
        time: The total time in use.
        queue: The length of its longest queue.
        inside: The robots in it now; only docks track them.
        since: The beginning of the current use; None while it is not in use.
    """

    uses: int = 0
    robots: set[str] = field(default_factory=set)
    time: int = 0
    queue: int = 0
    inside: set[str] = field(default_factory=set)
    since: int | None = None

    def begin(self, at: int) -> None:
        """Record the beginning of a use, unless it is in use already."""
        if self.since is None:
            self.since = at

    def end(self, at: int) -> None:
        """Record the end of the use."""
        if self.since is not None:
            self.time, self.since = self.time + at - self.since, None
        self.inside.clear()


class _Facilities(Part, Generic[N]):
    """The facilities of one kind.

    Attributes:
        uses: The usage of each facility, by name; unused ones may be missing.
    """

    def __init__(self, timeline: Timeline) -> None:
        super().__init__()
        self.uses: dict[N, Use] = defaultdict(Use)
        self._timeline = timeline

    def begin_anew(self) -> None:
        """End all uses at the current time, as after a reset."""
        self.end(self._timeline.now)
        for name in self.uses:
            self.changed(name)

    def end(self, at: int) -> None:
        """Record the end of all uses, for instance at the end of the run."""
        for use in self.uses.values():
            use.end(at)


_STATES: Final = {DoorOpening: "opening", DoorOpened: "open", DoorClosed: "closed"}
_JAM: Final = "door_jammed"
"""The fault that jams a door."""


class Doors(_Facilities[str]):
    """The doors of a run, watched by name; a door is in use while it is open.

    *world* has their initial states; it is None if it is unknown.
    """

    def __init__(self, timeline: Timeline, world: World | None = None) -> None:
        super().__init__(timeline)
        self._world = world
        self._states: dict[str, str] = {}
        self._jams: dict[str, str] = {}
        self.begin_anew()
        timeline.on(tuple(_STATES), self._move)
        timeline.on((FaultBegan, FaultEnded), self._jam)
        timeline.on(SceneSeen, self._see)

    def is_(self, door: str, state: str) -> bool:
        """Return whether a door is in a state; a jammed door is also open or closed."""
        return self._states.get(door) == state or (state == "jammed" and door in self._jams.values())

    def begin_anew(self) -> None:
        """Return all doors to their initial states."""
        self._jams.clear()
        for name, door in self._world.doors.items() if self._world else ():
            self._set(name, "open" if door.open else "closed")

    def _set(self, door: str, state: str) -> None:
        self._states[door] = state
        self.changed(door)

    def _move(self, at: int, event: DoorOpening | DoorOpened | DoorClosed) -> None:
        use = self.uses[event.door]
        match event:
            case DoorOpening(by=by) | DoorOpened(by=by) if by:
                use.robots.add(by)
        match event:
            case DoorOpening():
                use.uses += 1
            case DoorOpened():
                use.begin(at)
            case DoorClosed():
                use.end(at)
        self._set(event.door, _STATES[type(event)])

    def _jam(self, _at: int, event: FaultBegan | FaultEnded) -> None:
        door = event.settings.get("door")
        if event.fault == _JAM and isinstance(door, str):
            if isinstance(event, FaultBegan):
                self._jams[event.name] = door
            else:
                self._jams.pop(event.name, None)
            self.changed(door)

    def _see(self, at: int, scene: SceneSeen) -> None:
        self.end(at)
        for fixture in records(scene.fields, "fixtures"):
            state = next((tag for tag in texts(fixture, "tags") if tag in _STATES.values()), None)
            if fixture.get("kind") == "door" and state is not None:
                self._set(text(fixture, "name"), state)
                if state == "open":
                    self.uses[text(fixture, "name")].begin(at)
        self._jams.clear()
        for fault in records(scene.fields, "faults"):
            self._jam(at, FaultBegan.from_json(fault))


class Lanes(_Facilities[tuple[str, str]]):
    """The lanes of a run, watched by the waypoints of a lane; a lane counts as in use while it is closed."""

    def __init__(self, timeline: Timeline) -> None:
        super().__init__(timeline)
        timeline.on(LaneClosed, lambda at, event: self._close(at, event.lane))
        timeline.on(LaneOpened, lambda at, event: self._open(at, event.lane))
        timeline.on(SceneSeen, self._see)

    def is_closed(self, lane: tuple[str, str]) -> bool:
        """Return whether a lane is closed."""
        return lane in self.uses and self.uses[lane].since is not None

    def closed(self) -> list[tuple[str, str]]:
        """Return all closed lanes."""
        return [name for name, use in self.uses.items() if use.since is not None]

    def _close(self, at: int, name: tuple[str, str]) -> None:
        self.uses[name].begin(at)
        self.changed(name)

    def _open(self, at: int, name: tuple[str, str]) -> None:
        self.uses[name].end(at)
        self.changed(name)

    def _see(self, at: int, scene: SceneSeen) -> None:
        self.begin_anew()
        for closed in records(scene.fields, "closed_lanes"):
            named = lane(closed)
            if named is not None:
                self._close(at, named)


class Lifts(_Facilities[str]):
    """The lifts of a run; a lift is in use while it moves."""

    def __init__(self, timeline: Timeline) -> None:
        super().__init__(timeline)
        timeline.on(LiftCalled, lambda _at, event: self.uses[event.lift])
        timeline.on(LiftDeparted, self._depart)
        timeline.on(LiftArrived, self._arrive)
        timeline.on(SceneSeen, lambda _at, _scene: self.begin_anew())

    def _depart(self, at: int, event: LiftDeparted) -> None:
        use = self.uses[event.lift]
        use.robots.update(event.robots)
        use.uses += 1
        use.begin(at)

    def _arrive(self, at: int, event: LiftArrived) -> None:
        use = self.uses[event.lift]
        use.robots.update(event.robots)
        use.end(at)


class Docks(_Facilities[str]):
    """The docks of a run; a dock is in use while any robot is docked."""

    def __init__(self, timeline: Timeline) -> None:
        super().__init__(timeline)
        timeline.on(DockQueued, self._queue)
        timeline.on(Docked, self._dock)
        timeline.on(Undocked, self._undock)
        timeline.on(SceneSeen, self._see)

    def _queue(self, _at: int, event: DockQueued) -> None:
        use = self.uses[event.dock]
        use.queue = max(use.queue, event.position)

    def _dock(self, at: int, event: Docked) -> None:
        use = self.uses[event.dock]
        use.uses += 1
        use.robots.add(event.robot)
        use.inside.add(event.robot)
        use.begin(at)

    def _undock(self, at: int, event: Undocked) -> None:
        use = self.uses[event.dock]
        use.inside.discard(event.robot)
        if not use.inside:
            use.end(at)

    def _see(self, at: int, scene: SceneSeen) -> None:
        self.begin_anew()
        for robot in records(scene.fields, "robots"):
            if isinstance(robot.get("dock"), str):
                use = self.uses[robot["dock"]]
                use.inside.add(text(robot, "name"))
                use.begin(at)
