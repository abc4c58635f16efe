"""The models of world files, and the checks of a model that need more than one field.

Lengths are in the world's unit (meters or pixels), speeds in that unit per second, weights in kg, angles in radians.
In pixels y points down and yaw runs from +x to +y. Coordinates are never flipped.
"""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, partial
from itertools import pairwise, permutations
from typing import TYPE_CHECKING, Annotated, Any, Generic, Literal, Self, TypeVar, overload

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetPydanticSchema,
    SerializerFunctionWrapHandler,
    Tag,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapSerializer,
    WrapValidator,
    model_validator,
)

from hmrsim.distributions import PositiveRandomSeconds, RandomFactor, RandomSeconds, mean
from hmrsim.geometry import MAX_COORDINATE, Obstacles, PlaceNames, distance
from hmrsim.interfaces.quantities import ACCELERATION, SECONDS, SPEED, TURNING_RATE
from hmrsim.world.network import Pairs, Way, as_networkx, levels, nearest
from hmrsim.world.segments import SegmentGrid

if TYPE_CHECKING:
    import networkx as nx

ROS_NAME = r"^[A-Za-z][A-Za-z0-9_]*$"
"""A ROS name that does not begin with an underscore; the simulator uses names with an underscore itself."""

CHARGER = "charger"
"""The type of docks that charge batteries, of any power."""

MAX_STOPS = 200
"""Maximum number of stops of a lift, which has a ride from each stop to each other one."""

MAX_RIDES = 100_000
"""Maximum number of rides of all lifts."""

DEFAULT_POLICY = "planned"
"""The traffic policy of a world that sets none, if two of its robots could touch."""

PIXEL_SPEED = 300.0
"""Default speed of robots in a world in pixels, in px/s: the original's 5 px per frame at 60 frames per second."""


class Model(BaseModel):
    """A part of a world file: unknown keys, NaN and infinity are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)


Coordinate = Annotated[float, Field(strict=True, ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
Point = Annotated[tuple[Coordinate, Coordinate], Field(description="x, y in the world's unit.")]
Name = Annotated[str, Field(min_length=1, max_length=100)]
RosName = Annotated[str, Field(pattern=ROS_NAME, max_length=100)]
Positive = Annotated[float, Field(strict=True, gt=0, le=1e9)]
Seconds = Annotated[float, SECONDS.field]
Capacity = Annotated[int, Field(strict=True, ge=1)]


def _point_or_name(value: Any) -> str:
    return "name" if isinstance(value, str) else "point"


Where = Annotated[
    Annotated[Point, Tag("point")] | Annotated[Name, Tag("name")],
    Discriminator(_point_or_name),
    Field(description="x, y, or the name of a waypoint, place or dock."),
]


def _not_a_point(points: tuple[Point, ...]) -> tuple[Point, ...]:
    if len(set(points)) == 1:
        raise ValueError(f"all its points are {points[0]}")
    return points


Outline = Annotated[
    tuple[Point, ...], Field(min_length=2, description="Corners in order."), AfterValidator(_not_a_point)
]


class Waypoint(Model):
    """A waypoint with settings, such as a capacity.

    Attributes:
        at: Its point.
        capacity: Maximum number of robots at once under a policy with reservations; None for the traffic's default.
    """

    at: Point
    capacity: Capacity | None = None


def _waypoint_or_point(value: Any) -> str:
    return "waypoint" if isinstance(value, (dict, Waypoint)) else "point"


PointOrWaypoint = Annotated[
    Annotated[Point, Tag("point")] | Annotated[Waypoint, Tag("waypoint")], Discriminator(_waypoint_or_point)
]


class Lane(Model):
    """A straight connection of two waypoints; in a file also ``[from, to]``.

    Attributes:
        from_: The waypoint where it begins.
        to: The waypoint where it ends.
        one_way: Whether robots may only drive from *from* to *to*.
        speed_limit: Maximum speed of all robots on it; None for no limit.
        capacity: Maximum number of robots at once under a policy with reservations; None for the traffic's default.
        speed_factor: Factor on the speed of robots, for example in a crowded corridor. A distribution is sampled for
            each trip of each robot. Route planning ignores it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False, populate_by_name=True)

    from_: Name = Field(alias="from")
    to: Name
    one_way: bool = Field(default=False, strict=True)
    speed_limit: Annotated[float, SPEED.field] | None = None
    capacity: Capacity | None = None
    speed_factor: RandomFactor = 1.0

    @model_validator(mode="before")
    @classmethod
    def _pair(cls, data: Any) -> Any:
        if isinstance(data, (list, tuple)):
            if len(data) != 2:  # noqa: PLR2004
                raise ValueError(f"a lane is [from, to], got {len(data)} names")
            return {"from": data[0], "to": data[1]}
        return data


class PlainLanes(Sequence[Lane]):
    """Lanes without settings, which are created when they are accessed; see `Pairs`."""

    def __init__(self, pairs: Pairs) -> None:
        self.pairs = pairs

    def __len__(self) -> int:
        """Return the number of lanes."""
        return len(self.pairs)

    @overload
    def __getitem__(self, index: int) -> Lane: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Lane, ...]: ...

    def __getitem__(self, index: int | slice) -> Lane | tuple[Lane, ...]:
        """Return a lane, or a slice of lanes."""
        if isinstance(index, slice):
            return tuple(self[i] for i in range(*index.indices(len(self))))
        return Lane.model_validate(self.pairs[index])

    def __iter__(self) -> Iterator[Lane]:
        """Yield all lanes in order."""
        return map(Lane.model_validate, self.pairs)

    def __eq__(self, other: object) -> bool:
        """Return whether *other* has the same lanes in the same order."""
        if isinstance(other, PlainLanes):
            return self.pairs == other.pairs
        return isinstance(other, tuple) and len(self) == len(other) and all(map(Lane.__eq__, self, other))

    __hash__ = None  # type: ignore[assignment]


def _plain_or_checked(lanes: Any, check: ValidatorFunctionWrapHandler) -> Sequence[Lane]:
    if isinstance(lanes, PlainLanes):
        return lanes
    checked: Sequence[Lane] = PlainLanes(lanes) if isinstance(lanes, Pairs) else check(lanes)
    return checked


def _dumped(lanes: Sequence[Lane], dump: SerializerFunctionWrapHandler) -> Any:
    return dump(tuple(lanes))


Lanes = Annotated[
    Sequence[Lane],
    GetPydanticSchema(
        lambda _, schema: schema(Annotated[tuple[Lane, ...], WrapValidator(_plain_or_checked), WrapSerializer(_dumped)])
    ),
]
"""Lanes in the order of the file; those of a grid are not validated again."""


class Solid(Model):
    """An obstacle: a closed outline that robots can't enter.

    Attributes:
        solid: The corners of the outline, at least three.
    """

    solid: Annotated[tuple[Point, ...], Field(min_length=3), AfterValidator(_not_a_point)]


def _outline_or_solid(value: Any) -> str:
    return "solid" if isinstance(value, (dict, Solid)) else "outline"


Wall = Annotated[Annotated[Outline, Tag("outline")] | Annotated[Solid, Tag("solid")], Discriminator(_outline_or_solid)]


class Place(Model):
    """A named point, for goals and items.

    Attributes:
        tags: Free texts for controllers; the simulator ignores them.
    """

    at: Point
    tags: tuple[Name, ...] = ()


class Dock(Model):
    """A dock, where robots charge or load.

    Attributes:
        at: Where a docked robot stands: x, y, or the name of a waypoint or place.
        type: The dock's type; a ``charger`` charges batteries.
        capacity: Maximum number of docked robots.
        yaw: The yaw of a docked robot; None for that of its arrival.
        power: Charging power, in units of energy per second. By default, a charger fills a fifteenth of the battery per
            minute, and other docks do not charge.
        staging: Where a robot lines up before it docks, and where it goes when it undocks; None for the nearest point
            of a lane with a clear line of sight.
        reserved_for: Robots and robot types that may dock there; None for all.
        docking_time: Seconds that docking takes after the robot has reached the dock.
    """

    at: Where
    type: Name = "dock"
    capacity: Capacity = 1
    yaw: Coordinate | None = None
    power: Positive | None = None
    staging: Point | None = None
    reserved_for: tuple[Name, ...] | None = None
    docking_time: RandomSeconds = 0.0

    @property
    def charges(self) -> bool:
        """True if the dock charges batteries."""
        return self.type == CHARGER or self.power is not None


class Door(Model):
    """A door across lanes: robots wait until it is open.

    Attributes:
        at: The two ends of the doorway.
        type: The door's type, such as ``sliding``.
        open: Whether the door is open at the start, and stays open until a client closes it.
        opening_time: Seconds that opening takes.
        opens_for: Names or types of the robots for which the door opens automatically; None for all robots.
        stays_open: Seconds until the door closes behind a robot for which it opened; None to stay open.
    """

    at: tuple[Point, Point]
    type: Name = "door"
    open: Annotated[bool, Field(strict=True)] = False
    opening_time: RandomSeconds = 2.0
    opens_for: tuple[Name, ...] | None = None
    stays_open: Seconds | None = 3.0


def _few_stops(stops: tuple[str, ...]) -> tuple[str, ...]:
    if len(stops) > MAX_STOPS:
        raise ValueError(f"{len(stops)} stops are more than the maximum of {MAX_STOPS}")
    return stops


class Lift(Model):
    """A lift that carries robots between waypoints, one per level.

    Attributes:
        stops: The waypoints where the lift stops, in order.
        at: The stop of the cabin at the start; None for the first.
        travel_time: Seconds between neighboring stops.
        door_time: Seconds to open or to close the doors.
        capacity: Maximum number of robots in the cabin.
    """

    stops: Annotated[tuple[Name, ...], Field(min_length=2), AfterValidator(_few_stops)]
    at: Name | None = None
    travel_time: PositiveRandomSeconds = 5.0
    door_time: RandomSeconds = 2.0
    capacity: Capacity = 1

    def seconds(self, start: int, end: int) -> float:
        """Return the mean duration of a ride between two stops, by their indices, including the doors."""
        return abs(end - start) * mean(self.travel_time) + 2 * mean(self.door_time)


class Item(Model):
    """An item that robots can pick up.

    Attributes:
        at: Where the item lies: x, y, or the name of a waypoint, place or dock.
        blocks: Whether the item blocks the lane on which it lies.
    """

    at: Where
    weight: Annotated[float, Field(strict=True, ge=0, le=1e9, description="kg")] = 0.0
    blocks: Annotated[bool, Field(strict=True)] = False


class Base(Model):
    """The mobile base of a robot.

    Attributes:
        speed: Maximum speed; None for 1 m/s, or 300 px/s in a world in pixels.
        acceleration: Acceleration and deceleration; None for instant changes of speed.
        turning_rate: Speed of turns in place, in radians per second; None for instant turns.
        radius: Radius of the footprint, which matters between robots only.
        flies: Whether the robot moves straight between any points, over lanes, walls and other robots.
    """

    speed: Annotated[float, SPEED.field] | None = None
    acceleration: Annotated[float, ACCELERATION.field] | None = None
    turning_rate: Annotated[float, TURNING_RATE.field] | None = None
    radius: Positive | None = None
    flies: Annotated[bool, Field(strict=True)] = False


class RobotType(Model):
    """A type of robots: the base and the components with their settings.

    Attributes:
        base: The mobile base: speed, acceleration and size.
        components: The settings of the components, by component.
    """

    base: Base = Base()
    components: dict[str, dict[str, Any]] = {}


BUILT_IN_TYPES = {"carrier": RobotType(), "fetcher": RobotType(components={"claw": {}})}
"""The built-in types, which a world may override."""


class RobotSpec(Model):
    """One robot of the world.

    Attributes:
        type: A robot type of this world or a built-in one.
        at: The initial position: x, y, or the name of a waypoint, place or dock.
        yaw: The initial yaw.
        base: Settings of the base that differ from the type's.
        components: Settings that differ from the type's, by component; null removes a component of the type.
        planner: ``graph`` to plan on the world's lanes, ``external`` for a planner on the network.
        script: Orders that the robot executes without a controller.
        tags: Free texts for controllers, such as skills; the simulator ignores them.
    """

    type: Name = "carrier"
    at: Where
    yaw: Coordinate = 0.0
    base: Base = Base()
    components: dict[str, dict[str, Any] | None] = {}
    planner: Literal["graph", "external"] = "graph"
    script: tuple[str, ...] = ()
    tags: tuple[Name, ...] = ()


def _as_list(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


_NAME_SCHEMA: dict[str, Any] = {"type": "string", "minLength": 1, "maxLength": 100}
Places = Annotated[
    tuple[Name, ...],
    BeforeValidator(_as_list),
    Field(min_length=1, max_length=1_000),
    WithJsonSchema(
        {"anyOf": [_NAME_SCHEMA, {"type": "array", "items": _NAME_SCHEMA, "minItems": 1, "maxItems": 1_000}]}
    ),
]
"""Names of places, docks or waypoints; a file may have a single name instead of a list."""


class Demand(Model):
    """A source of orders, each of which asks for an item to be brought from one place to another.

    Attributes:
        name: The base name of its orders, which are numbered.
        item: The base name of its items, which are numbered; None for the demand's name.
        at: Where the items appear; if there are several places, each order picks one at random.
        to: Where the items have to be brought; if there are several places, each order picks one at random.
        arrives: Seconds from one order to the next.
        first: Seconds until the first order; None to use *arrives*.
        within: Seconds after which an order is late; None for no deadline.
        priority: Priority of the orders; higher numbers come first.
        weight: Weight of each item, in kg.
        count: Maximum number of orders; None for no limit.
        until: Simulated seconds after which no orders arrive; None for no limit.
        most_open: Maximum number of open orders; no further order arrives until one of them ends.
    """

    name: RosName
    item: RosName | None = None
    at: Places
    to: Places
    arrives: PositiveRandomSeconds
    first: RandomSeconds | None = None
    within: PositiveRandomSeconds | None = None
    priority: Annotated[int, Field(strict=True, ge=-1_000_000, le=1_000_000)] = 0
    weight: Annotated[float, Field(strict=True, ge=0, le=1e9, description="kg")] = 0.0
    count: Capacity | None = None
    until: Seconds | None = None
    most_open: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 100


class _Open(Model):
    """A part that accepts further fields; their numbers must be finite."""

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True, allow_inf_nan=False)

    @model_validator(mode="after")
    def _finite(self) -> Self:
        for key, value in (self.model_extra or {}).items():
            if not _is_finite(value):
                raise ValueError(f"{key} must be a finite number, got {value!r:.100}")
        return self


def _is_finite(value: object) -> bool:
    if isinstance(value, dict):
        return all(_is_finite(part) for part in value.values())
    if isinstance(value, (list, tuple)):
        return all(_is_finite(part) for part in value)
    return not isinstance(value, float) or math.isfinite(value)


class Traffic(_Open):
    """The traffic: the name of the policy, and its settings.

    Attributes:
        policy: The name of the policy; None for the default, see `World.policy`.
    """

    policy: Name | None = None


class FaultEntry(_Open):
    """A fault; its fields besides *type* depend on the type."""

    type: Name


def _few_rides(lifts: dict[str, Lift]) -> dict[str, Lift]:
    rides = sum(len(lift.stops) * (len(lift.stops) - 1) for lift in lifts.values())
    if rides > MAX_RIDES:
        raise ValueError(f"{rides} rides from stop to stop are more than the maximum of {MAX_RIDES}")
    return lifts


class World(Model):
    """A map with its entities, robots, faults and demand.

    Attributes:
        name: The world's name in traces, on the page and in reports.
        units: The unit of lengths: meters, with y up, or pixels, with y down.
        waypoints: The points that lanes connect, by name: [x, y], or a mapping with a capacity.
        lanes: The lanes that robots drive: pairs of waypoints, for both directions, or mappings with further settings.
        walls: Polylines and outlines that block robots off the lanes.
        places: Named points, for goals and items.
        docks: Where robots charge or load, by name.
        doors: Doors across lanes, by name; they open for approaching robots.
        lifts: Lifts between waypoints on several levels, by name.
        items: The items that robots carry, by name.
        robot_types: The robot types, by name: base and components.
        robots: The robots, by name.
        traffic: The policy that decides which robot may be where, and its settings. Without a policy,
            robots keep apart if at least two that drive have a radius, and pass through each other otherwise.
        faults: The faults to inject, with their times.
        demand: The sources of orders.
        seed: The seed of all random numbers; ``--seed`` overrides it.
    """

    name: Name = "world"
    units: Literal["m", "px"] = "m"
    bounds: Annotated[
        tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None,
        Field(description="Minimum x and y, maximum x and y; by default the map has no bounds."),
    ] = None
    include: tuple[str, ...] = Field(
        default=(), description="Further files of any format in the same folder or below, or names of shipped worlds."
    )
    overlay: dict[str, Any] = Field(
        default={}, description="Changes by path, which are applied to this file and the files that it includes."
    )
    waypoints: dict[Name, PointOrWaypoint] = {}
    lanes: Lanes = ()
    walls: tuple[Wall, ...] = ()
    places: dict[Name, Place] = {}
    docks: dict[Name, Dock] = {}
    doors: dict[Name, Door] = {}
    lifts: Annotated[dict[Name, Lift], AfterValidator(_few_rides)] = {}
    items: dict[Name, Item] = {}
    robot_types: dict[Name, RobotType] = {}
    robots: dict[RosName, RobotSpec] = {}
    traffic: Traffic = Traffic()
    faults: tuple[FaultEntry, ...] = ()
    demand: tuple[Demand, ...] = ()
    remap: dict[str, str] = Field(default={}, description="Aliases of actions: from the alias to <robot>/<action>.")
    seed: Annotated[int, Field(strict=True)] = 0

    @property
    def origin(self) -> World:
        """The world of which this is a copy with more faults; the world itself if it is no copy."""
        origin: World = self.__dict__.get("_origin", self)
        return origin

    def with_faults(self, faults: Sequence[FaultEntry]) -> World:
        """Return a copy with further faults; values derived from the rest are shared, see `Derived`."""
        copy = self.model_copy(update={"faults": (*self.faults, *faults)})
        copy.__dict__["_origin"] = self.origin
        return copy

    @property
    def policy(self) -> str:
        """The name of the traffic policy in force: the one that the world sets, else the default.

        By default robots keep apart if at least two of them have bodies, and pass through each other otherwise. The
        robots of the world file decide; robots that are spawned later don't change the policy.
        """
        return self.traffic.policy or (DEFAULT_POLICY if len(self.bodies) > 1 else "free")

    @property
    def bodies(self) -> list[str]:
        """The names of the robots that could touch others: they drive and have a radius."""
        known = {*self.robot_types, *BUILT_IN_TYPES}
        bases = {name: self.robot_type(robot).base for name, robot in self.robots.items() if robot.type in known}
        return [name for name, base in bases.items() if base.radius is not None and not base.flies]

    @cached_property
    def points(self) -> dict[str, Point]:
        """The coordinates of each waypoint, by name."""
        return {name: at.at if isinstance(at, Waypoint) else at for name, at in self.waypoints.items()}

    @property
    def place_names(self) -> PlaceNames:
        """The names of the points of waypoints, places and docks."""
        return _PLACE_NAMES(self)

    @property
    def polylines(self) -> list[Sequence[Point]]:
        """The walls that are not solid."""
        return [wall for wall in self.walls if isinstance(wall, tuple)]

    @property
    def solids(self) -> list[Sequence[Point]]:
        """The corners of the solid walls."""
        return [wall.solid for wall in self.walls if isinstance(wall, Solid)]

    @property
    def outlines(self) -> list[Sequence[Point]]:
        """All walls as polylines, in order; those of solids are closed."""
        return [(*wall.solid, wall.solid[0]) if isinstance(wall, Solid) else wall for wall in self.walls]

    @property
    def sides(self) -> list[tuple[Point, Point]]:
        """The straight pieces of all walls, by their ends."""
        return [side for outline in self.outlines for side in pairwise(outline)]

    def obstacles(self, *, doors: bool = False) -> Obstacles:
        """Return the walls as obstacles; with *doors*, also all doors, as if they were closed."""
        closed = [door.at for door in self.doors.values()] if doors else []
        return Obstacles([*self.polylines, *closed], self.solids)

    @property
    def rides(self) -> Iterator[tuple[str, str, str, float]]:
        """The rides of lifts: the stops where they begin and end, the lift, and the mean duration in seconds."""
        for name, lift in self.lifts.items():
            for (i, start), (j, end) in permutations(enumerate(lift.stops), 2):
                yield start, end, name, lift.seconds(i, j)

    @cached_property
    def ways(self) -> tuple[Way, ...]:
        """Lanes in each direction in which they can be driven, and rides in lifts, by the waypoints where they begin.

        If two connect the same waypoints in the same direction, the last one counts.
        """
        found: dict[str, dict[str, Way]] = {name: {} for name in self.waypoints}
        for lane in self.lanes:
            length = distance(self.points[lane.from_], self.points[lane.to])
            limits = lane.speed_limit or math.inf, lane.capacity
            for start, end in [(lane.from_, lane.to), (lane.to, lane.from_)][: 1 if lane.one_way else 2]:
                found[start][end] = Way(start, end, length, *limits, one_way=lane.one_way)
        for start, end, name, seconds in self.rides:
            found[start][end] = Way(start, end, 0.0, math.inf, self.lifts[name].capacity, seconds, name)
        return tuple(way for ways in found.values() for way in ways.values())

    @cached_property
    def named(self) -> dict[str, str]:
        """The nearest waypoint of each place and dock, by name; empty in a world without lanes and lifts."""
        points = {name: place.at for name, place in self.places.items()}
        points |= {name: self.dock_point(name) for name in self.docks}
        touched = {end: self.points[end] for end in self._touched()} if points else {}
        return nearest(touched, points) if touched else {}

    def _touched(self) -> Iterator[str]:
        """Yield the waypoints at the ends of lanes, and the stops of lifts."""
        if isinstance(self.lanes, PlainLanes):
            yield from self.lanes.pairs.touched()
        else:
            for lane in self.lanes:
                yield from (lane.from_, lane.to)
        for lift in self.lifts.values():
            yield from lift.stops

    @cached_property
    def graph(self) -> nx.DiGraph[str]:
        """The route graph for networkx: waypoints as nodes, and an edge for each direction of each lane.

        The graph has the state of the file, without later changes, and is frozen; change a ``copy()`` of it.
        networkx is imported upon first use. Lengths are in the world's unit, durations in seconds.

        Graph attributes: ``name``; ``units``; ``speed``, the default speed of robots, which costs are for.

        Node attributes: ``pos`` (x, y); ``level``, from 0, where lifts connect one level with the next; ``capacity``,
        or None; ``places``, the names of the places and docks whose nearest waypoint it is; ``lifts``, the names of
        the lifts that stop there.

        Edge attributes: ``length``; ``speed_limit``, infinite without one; ``cost``, in seconds; ``capacity``, or None;
        ``one_way``; ``lift``, a name or None; ``ride``, the seconds that the lift takes, or 0; ``doors``, the names of
        the doors across the lane; ``closed``, whether one of these doors opens for no robot.
        """
        level = levels(self.waypoints, self.ways, {name: lift.stops for name, lift in self.lifts.items()})
        nodes: dict[str, dict[str, Any]] = {
            name: {"pos": self.points[name], "level": level[name], "capacity": None, "places": (), "lifts": ()}
            for name in self.waypoints
        }
        for name, waypoint in self.waypoints.items():
            if isinstance(waypoint, Waypoint):
                nodes[name]["capacity"] = waypoint.capacity
        for place, name in self.named.items():
            nodes[name]["places"] += (place,)
        for name, lift in self.lifts.items():
            for stop in lift.stops:
                nodes[stop]["lifts"] += (name,)
        about = {"name": self.name, "units": self.units, "speed": self.speed(Base())}
        locked = frozenset(name for name, door in self.doors.items() if door.opens_for == () and not door.open)
        return as_networkx(about, nodes, self.ways, self._doors_on_lanes(), locked)

    def _doors_on_lanes(self) -> dict[frozenset[str], tuple[str, ...]]:
        found: dict[frozenset[str], tuple[str, ...]] = {}
        names, grid = [*self.doors], SegmentGrid([door.at for door in self.doors.values()])
        for lane in self.lanes if self.doors else ():
            crossed = grid.crossings(self.points[lane.from_], self.points[lane.to])
            if crossed:
                found[frozenset((lane.from_, lane.to))] = tuple(names[i] for i in crossed)
        return found

    def point(self, at: Point | str) -> Point:
        """Return the coordinates of a point or of a named waypoint, place or dock.

        Raises:
            KeyError: The name is unknown.
        """
        if not isinstance(at, str):
            return at
        if at in self.points:
            return self.points[at]
        return self.places[at].at if at in self.places else self.dock_point(at)

    def find(self, at: Point | str) -> Point | None:
        """Return the coordinates of a point or of a named waypoint, place or dock; None if the name is unknown."""
        try:
            return self.point(at)
        except KeyError:
            return None

    def dock_point(self, name: str) -> Point:
        """Return the coordinates of a dock.

        Raises:
            KeyError: The dock, or the waypoint or place where it is, does not exist.
        """
        at = self.docks[name].at
        if not isinstance(at, str):
            return at
        return self.points[at] if at in self.points else self.places[at].at

    def robot_type(self, robot: RobotSpec) -> RobotType:
        """Return the base and components of a robot: those of its type, with the robot's settings applied.

        Raises:
            KeyError: The robot's type is unknown.
        """
        kind = self.robot_types.get(robot.type) or BUILT_IN_TYPES[robot.type]
        if not (robot.base.model_fields_set or robot.components):
            return kind
        base = kind.base.model_copy(update=robot.base.model_dump(exclude_unset=True))
        components = {
            name: {**kind.components.get(name, {}), **(robot.components.get(name) or {})}
            for name in sorted({*kind.components, *robot.components})
            if robot.components.get(name, {}) is not None
        }
        return RobotType(base=base, components=components)

    def speed(self, base: Base) -> float:
        """Return the maximum speed of a base, in the world's unit per second."""
        return base.speed or (PIXEL_SPEED if self.units == "px" else 1.0)


T = TypeVar("T")


class Derived(Generic[T]):
    """A function of a world that computes its value once for each world, and drops it with the world.

    Worlds are compared by identity, because comparing their content takes as long as reading them.

    Args:
        function: Computes the value, which must not refer to the world, or else the world would never be freed.
        **parts: The fields of a world that determine the value; all by default. A copy with the same parts, such as
            one with other faults, has the value of the world that it was copied from.
    """

    def __init__(self, function: Callable[[World], T], *parts: str) -> None:
        self._function = function
        self._parts = parts
        self._known: dict[tuple[int, ...], T] = {}

    def __call__(self, world: World) -> T:
        """Return the value for a world."""
        key = tuple(map(id, map(partial(getattr, world), self._parts))) or (id(world),)
        try:
            return self._known[key]
        except KeyError:
            value = self._known[key] = self._function(world)
            # No other object has the identity of the world or of its parts while the world exists. Copies for single
            # runs end soon, and the next one has the same parts.
            owner = world.origin
            if not self._parts or any(getattr(owner, part) is not getattr(world, part) for part in self._parts):
                owner = world
            weakref.finalize(owner, self._known.pop, key, None).atexit = False
            return value


def _place_names(world: World) -> PlaceNames:
    places = {name: place.at for name, place in world.places.items()}
    docks = {name: dock.at for name, dock in world.docks.items() if not isinstance(dock.at, str)}
    return PlaceNames(world.points, places, docks)


_PLACE_NAMES = Derived(_place_names, "waypoints", "places", "docks")
