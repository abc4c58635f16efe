"""A seeded generator of small random fleets, as new users draw them.

Five to twelve robots share single tracks, rings, dead ends and bays, with doors and sometimes a lift. Robots start
anywhere: on waypoints, at places and chargers off the lanes, in the middle of lanes. Some are never given an order.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.geometry import SAME_PLACE, Point, between, distance, foot, gap
from hmrsim.random_fleets.layout import MARGIN, Layout, random_layout
from hmrsim.world.model import World
from hmrsim.world.writing import to_yaml

if TYPE_CHECKING:
    from hmrsim.random_fleets.layout import Lane


ROOM = 1.0
"""Minimum meters between two such points, except for places deliberately close to a waypoint."""

_HALF_DOOR = 1.0
_RACK = 1.4
"""Meters from a lane to the rack beside it."""

_LEAST_RACK = 1.0
_SPOT_TRIES = 30


class Spot(NamedTuple):
    """A point where a robot can stand off the waypoints.

    Attributes:
        at: The point.
        near: The waypoint or lane that it belongs to.
        on_lane: Whether it is in the middle of a lane.
    """

    at: Point
    near: str
    on_lane: bool = False


@dataclass
class Site:
    """Lanes with the things beside them.

    Attributes:
        doors: The ends of each door.
        racks: The outlines of solid obstacles.
        spots: The points off the waypoints that are taken.
    """

    chance: random.Random
    layout: Layout
    doors: list[tuple[Point, Point]] = field(default_factory=list)
    racks: list[list[Point]] = field(default_factory=list)
    spots: list[Spot] = field(default_factory=list)

    def add_doors(self, count: int) -> list[Lane]:
        """Add doors in the middle of lanes, and return these lanes."""
        lanes = self.chance.sample(self.layout.lanes, min(count, len(self.layout.lanes)))
        lanes = [lane for lane in lanes if distance(*self.layout.segment(lane)) > 3.0]  # noqa: PLR2004 - not of a bay
        for lane in lanes:
            a, b = self.layout.segment(lane)
            length = distance(a, b)
            across = -(b[1] - a[1]) / length * _HALF_DOOR, (b[0] - a[0]) / length * _HALF_DOOR
            x, y = between(a, b, 0.5)
            self.doors.append((_rounded(x - across[0], y - across[1]), _rounded(x + across[0], y + across[1])))
        return lanes

    def add_racks(self, share: float) -> None:
        """Fill some of the rectangles between lanes with racks, if they are free."""
        for left, low, right, high in self.layout.faces:
            if self.chance.random() >= share:
                continue
            left_, low_, right_, high_ = left + _RACK, low + _RACK, right - _RACK, high - _RACK
            if right_ - left_ < _LEAST_RACK or high_ - low_ < _LEAST_RACK:
                continue
            outline = [(left_, low_), (right_, low_), (right_, high_), (left_, high_)]
            if not self._is_in_the_way(outline):
                self.racks.append(outline)

    def _is_in_the_way(self, outline: list[Point]) -> bool:
        sides = [*zip(outline, [*outline[1:], outline[0]], strict=True)]
        lines = [*map(self.layout.segment, self.layout.lanes), *self.doors]
        lines += [(spot.at, self._foot(spot)) for spot in self.spots]
        return any(gap(*line, *side) < ROOM / 2 or _is_inside(line[0], outline) for line in lines for side in sides)

    def _foot(self, spot: Spot) -> Point:
        """Return the nearest point of a lane."""
        feet = [foot(spot.at, *self.layout.segment(lane)) for lane in self.layout.lanes]
        return min(feet, key=lambda at: distance(spot.at, at))

    def beside_waypoint(self) -> Spot | None:
        """Add a point so close to a waypoint that two robots touch there."""
        for _ in range(_SPOT_TRIES):
            name = self.chance.choice([*self.layout.waypoints])
            x, y = self.layout.waypoints[name]
            dx, dy = self.chance.choice(((0.5, 0.0), (0.0, 0.5), (-0.5, 0.0), (0.0, -0.5)))
            at = _rounded(x + dx, y + dy)
            lanes = [lane for lane in self.layout.lanes if name in (lane.start, lane.end)]
            if any(distance(at, foot(at, *self.layout.segment(lane))) < 0.49 for lane in lanes):  # noqa: PLR2004
                # It would be on a lane of the waypoint.
                continue
            if self._is_free(at, except_for=name):
                return self._taken(Spot(at, name))
        return None

    def beside_lane(self) -> Spot | None:
        """Add a point 0.5 to 3 m beside a lane."""
        for _ in range(_SPOT_TRIES):
            lane = self.chance.choice(self.layout.lanes)
            a, b = self.layout.segment(lane)
            length, away = distance(a, b), self.chance.choice((0.5, 0.8, 1.0, 1.5, 2.0, 3.0))
            side = self.chance.choice((-1, 1))
            x, y = between(a, b, self.chance.choice((0.25, 0.3, 0.5, 0.5, 0.7, 0.75)))
            at = _rounded(x - side * away * (b[1] - a[1]) / length, y + side * away * (b[0] - a[0]) / length)
            others = [other for other in self.layout.lanes if other is not lane]
            nearest = min((distance(at, foot(at, *self.layout.segment(other))) for other in others), default=math.inf)
            if nearest > max(ROOM, away + 0.1) and self._is_free(at):
                return self._taken(Spot(at, f"{lane.start}-{lane.end}"))
        return None

    def on_lane(self) -> Spot | None:
        """Add a point in the middle of a lane."""
        for _ in range(_SPOT_TRIES):
            lane = self.chance.choice(self.layout.lanes)
            at = _rounded(*between(*self.layout.segment(lane), self.chance.choice((0.3, 0.4, 0.5, 0.6))))
            on_line = distance(at, foot(at, *self.layout.segment(lane))) < 1e-9  # noqa: PLR2004 - rounded all the same
            if on_line and self._is_free(at):
                return self._taken(Spot(at, f"{lane.start}-{lane.end}", on_lane=True))
        return None

    def _taken(self, spot: Spot) -> Spot:
        self.spots.append(spot)
        return spot

    def _is_free(self, at: Point, except_for: str = "") -> bool:
        points = [point for name, point in self.layout.waypoints.items() if name != except_for]
        points += [spot.at for spot in self.spots]
        if any(distance(at, point) < ROOM for point in points):
            return False
        return all(distance(at, foot(at, *door)) >= ROOM / 2 for door in self.doors)


def _is_inside(point: Point, outline: list[Point]) -> bool:
    (left, low), (right, high) = outline[0], outline[2]
    return left <= point[0] <= right and low <= point[1] <= high


def _rounded(x: float, y: float) -> Point:
    return round(x, 2), round(y, 2)


FEWEST: Final = 5
MOST: Final = 12
"""The numbers of robots of a fleet, unless one is given."""

_TRIES = 20


def random_fleet(seed: int, robots: int | None = None) -> dict[str, Any]:
    """Return a random world as plain values, as in a world file; equal arguments give equal worlds.

    Args:
        seed: Decides everything; it is the seed of the world, too.
        robots: How many robots there are; 5 to 12 by chance if None.
    """
    chance = random.Random(seed)
    count = chance.randint(FEWEST, MOST) if robots is None else robots
    return _Draft(chance, count).world(seed)


def header(seed: int, robots: int | None = None) -> str:
    """Return the command that generates a world."""
    return f"hmrsim map generate --seed {seed}" + ("" if robots is None else f" --robots {robots}")


def to_text(data: dict[str, Any], command: str, *, schema: str | None = None) -> str:
    """Return a world as readable YAML, with a comment that names the *command* that generates it.

    *schema* is where an editor finds the schema, seen from the file; None to leave it out.
    """
    text = to_yaml(World.model_validate(data), schema=schema)
    first, line_break, rest = text.partition("\n") if schema else ("", "", text)
    return f"{first}{line_break}# Generated by: {command}\n{rest}"


class _Draft:
    """A fleet that is being drawn.

    Args:
        count: How many robots it has.
    """

    def __init__(self, chance: random.Random, count: int) -> None:
        self._chance = chance
        self._layout = random_layout(chance, round(count * chance.uniform(1.4, 2.4)) + 3)
        self._site = Site(chance, self._layout)
        self._types = self._draw_types()
        self._doors = self._draw_doors()
        self._places = self._draw_places()
        spots = [self._site.beside_lane() for _ in range(chance.randint(0, 3))]
        self._docks = {f"charger_{i}": spot.at for i, spot in enumerate(filter(None, spots), 1)}
        self._starts: list[tuple[Point, float]] = []
        self._robots = self._draw_robots(count)
        self._demand = self._draw_demand()
        self._site.add_racks(chance.choice((0.0, 0.0, 0.5, 0.9)))

    def world(self, seed: int) -> dict[str, Any]:
        """Return the plain values of the world."""
        layout, used = self._layout, [name for each in self._demand for name in (*each["at"], *each["to"])]
        used += [robot["at"] for robot in self._robots.values() if isinstance(robot["at"], str)]
        x0, y0, x1, y1 = _bounds(layout)
        corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]
        walls: list[Any] = [corners] if self._chance.random() < 0.5 else []  # noqa: PLR2004 - a share
        data = {
            "name": f"fleet_{seed}",
            "bounds": [x0, y0, x1, y1],
            "seed": seed,
            "waypoints": self._draw_waypoints(),
            "lanes": [
                {"from": lane.start, "to": lane.end, "one_way": True} if lane.one_way else [lane.start, lane.end]
                for lane in layout.lanes
            ],
            "walls": [*walls, *({"solid": [[*corner] for corner in rack]} for rack in self._site.racks)],
            "places": {name: {"at": [*at]} for name, at in self._places.items() if name in used},
            "docks": {name: {"at": [*at], "type": "charger"} for name, at in self._docks.items()},
            "doors": self._doors,
            "lifts": {name: {"stops": [*stops]} for name, stops in layout.lifts.items()},
            "robot_types": self._types,
            "robots": self._robots,
            "traffic": {"policy": "priority"},
            "demand": self._demand,
        }
        return {key: value for key, value in data.items() if value or key == "seed"}

    def _draw_waypoints(self) -> dict[str, Any]:
        roomy = self._chance.random() < 0.3  # noqa: PLR2004 - a share
        degrees = self._layout.degrees
        return {
            name: {"at": [*at], "capacity": 2}
            if roomy and degrees[name] > 1 and self._chance.random() < 0.15  # noqa: PLR2004 - a share
            else [*at]
            for name, at in self._layout.waypoints.items()
        }

    def _draw_types(self) -> dict[str, Any]:
        """Return two or three robot types; not all of them can carry every item."""
        chance = self._chance
        base: dict[str, Any] = {
            "speed": chance.choice((0.8, 1.0, 1.2, 1.5)),
            "radius": chance.choice((0.25, 0.3, 0.35)),
        }
        if chance.random() < 0.2:  # noqa: PLR2004 - a share
            base["acceleration"] = 0.8
        if chance.random() < 0.2:  # noqa: PLR2004 - a share
            base["turning_rate"] = 1.5
        claw = {"max_weight": 5.0, "handling_time": float(chance.choice((0, 2, 5)))}
        types: dict[str, Any] = {"picker": {"base": base, "components": {"claw": claw}}}
        others = chance.choice((["hauler"], ["scout"], ["hauler", "scout"]))
        if "hauler" in others:
            types["hauler"] = {
                "base": {"speed": chance.choice((0.5, 0.8)), "radius": chance.choice((0.4, 0.45))},
                "components": {"claw": {"max_weight": 60.0, "handling_time": 4.0}},
            }
        if "scout" in others:
            types["scout"] = {"base": {"speed": chance.choice((1.2, 1.5, 1.8)), "radius": 0.2}}
        return types

    def _draw_doors(self) -> dict[str, Any]:
        chance = self._chance
        self._site.add_doors(chance.choice((0, 0, 1, 2, 3)))
        carriers = [name for name, kind in self._types.items() if "components" in kind]
        doors: dict[str, Any] = {}
        for number, (a, b) in enumerate(self._site.doors, 1):
            door: dict[str, Any] = {"at": [[*a], [*b]], "type": "sliding", "opening_time": float(chance.randint(1, 4))}
            if len(carriers) < len(self._types) and chance.random() < 0.15:  # noqa: PLR2004 - a share
                door["opens_for"] = carriers
            doors[f"door_{number}"] = door
        return doors

    def _draw_places(self) -> dict[str, Point]:
        """Return named places: on waypoints, near them, beside lanes and in the middle of lanes."""
        chance, site = self._chance, self._site
        places: dict[str, Point] = {}
        for _ in range(chance.randint(4, 8)):
            kind = chance.choices(("desk", "shelf", "bed", "stop"), (3, 2, 4, 1))[0]
            if kind == "desk":
                at = self._layout.waypoints[chance.choice([*self._layout.waypoints])]
            else:
                take = {"shelf": site.beside_waypoint, "bed": site.beside_lane, "stop": site.on_lane}[kind]
                spot = take()
                if spot is None:
                    continue
                at = spot.at
            if all(distance(at, other) > SAME_PLACE for other in places.values()):
                places[f"{kind}_{sum(name.startswith(kind) for name in places) + 1}"] = at
        return places

    def _draw_robots(self, count: int) -> dict[str, Any]:
        """Return the robots, with at least one hauler and two pickers if there is room."""
        kinds = ["picker", *(kind for kind in self._types if kind != "picker"), "picker"][:count]
        weights = [{"picker": 4, "hauler": 2, "scout": 3}[kind] for kind in self._types]
        kinds += self._chance.choices([*self._types], weights, k=count - len(kinds))
        robots: dict[str, Any] = {}
        for kind in sorted(kinds, key=[*self._types].index):
            number = sum(robot["type"] == kind for robot in robots.values()) + 1
            robots[f"{kind}_{number}"] = {"type": kind, "at": self._draw_start(self._types[kind]["base"]["radius"])}
        return robots

    def _draw_start(self, radius: float) -> Any:
        """Return the start of a robot: a name, or x and y."""
        chance, site, waypoints = self._chance, self._site, self._layout.waypoints
        for _ in range(_TRIES):
            kind = chance.choices(("waypoint", "place", "dock", "middle", "beside"), (8, 3, 1, 1, 1))[0]
            if kind in ("middle", "beside"):
                spot = site.on_lane() if kind == "middle" else site.beside_lane()
                if spot is not None and self._takes(spot.at, radius):
                    return [*spot.at]
                continue
            named = {"waypoint": waypoints, "place": self._places, "dock": self._docks}[kind]
            if named:
                name = chance.choice([*named])
                if self._takes(named[name], radius):
                    return name
        names = [*waypoints]
        chance.shuffle(names)
        return next(name for name in names if self._takes(waypoints[name], radius))

    def _takes(self, at: Point, radius: float) -> bool:
        """Reserve a start for a robot, if it touches no other robot and is alone on its lane."""
        if any(distance(at, other) < radius + taken for other, taken in self._starts):
            return False
        if at not in self._layout.waypoints.values():
            for lane in self._layout.lanes:
                a, b = self._layout.segment(lane)
                inside = (other for other, _ in self._starts if other not in (a, b))
                if _is_on(at, a, b) and any(_is_on(other, a, b) for other in inside):
                    return False
        self._starts.append((at, radius))
        return True

    def _draw_demand(self) -> list[dict[str, Any]]:
        """Return demands with 10 to 20 orders in all."""
        chance, total = self._chance, self._chance.randint(10, 20)
        heavy = chance.randint(2, 5) if "hauler" in self._types else 0
        ends = [name for name, degree in self._layout.degrees.items() if degree == 1]
        named = [*self._places, *chance.sample(ends, min(len(ends), 2))]
        named += [name for name in chance.sample([*self._layout.waypoints], 2) if name not in named]
        chance.shuffle(named)
        to = named[: chance.randint(1, 2)]
        at = named[len(to) :]
        demand = [self._order("parcel", at[:6], to, 2.0, total - heavy)]
        if heavy:
            demand.append(self._order("pallet", chance.sample(at, min(2, len(at))), to[:1], 40.0, heavy))
        return demand

    def _order(self, name: str, at: list[str], to: list[str], weight: float, count: int) -> dict[str, Any]:
        mean = float(self._chance.choice((15, 25, 40)))
        if name == "pallet":
            mean *= 3
        return {
            "name": name,
            "at": at,
            "to": to,
            "weight": weight,
            "arrives": {"exponential": {"mean": mean}},
            "within": 300.0,
            "count": count,
        }


def _is_on(at: Point, a: Point, b: Point) -> bool:
    return distance(at, foot(at, a, b)) <= SAME_PLACE


def _bounds(layout: Layout) -> tuple[float, float, float, float]:
    xs, ys = zip(*layout.waypoints.values(), strict=True)
    return 0.0, 0.0, round(max(xs) + MARGIN, 2), round(max(ys) + MARGIN, 2)
