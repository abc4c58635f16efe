"""``hmrsim map plan``: the quickest route between two points, its legs and its travel time."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, UnknownName, WrongUse
from hmrsim.cli.output import columns, show_result
from hmrsim.cli.worlds import read_world
from hmrsim.diagnostics import instead
from hmrsim.errors import HmrsimError, NoRoute
from hmrsim.geometry import Pose, heading
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.navigation.motion import drive
from hmrsim.world.model import Base

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.route import Leg, Route
    from hmrsim.world import World


_NUMBER: Final = r"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?|nan|inf|infinity)"
_POINT: Final = re.compile(rf"(?P<x>{_NUMBER}),\s*(?P<y>{_NUMBER})", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True)
class Trip:
    """A route and how it is driven.

    Attributes:
        base: The robot's base; its speed is given.
        seconds: For each leg.
        turning: Seconds of all turns between them.
    """

    route: Route
    base: Base
    seconds: tuple[float, ...]
    turning: float

    @property
    def duration(self) -> float:
        """The travel time in seconds, including turns."""
        return sum(self.seconds) + self.turning


def plan(args: argparse.Namespace) -> int:
    """Print the quickest route between two points; return the exit code."""
    world = read_world(args).world
    driver = args.driver or (args.start if args.speed is None and args.start in world.robots else None)
    start, goal = _ends(world, (args.start, args.goal), driver)
    base = Base(speed=args.speed) if driver is None else world.robot_type(world.robots[driver]).base
    base = base.model_copy(update={"speed": world.speed(base)})
    yaw = world.robots[driver].yaw if driver is not None and driver == args.start else None
    graph = WaypointGraph(world)
    try:
        graph.check_start(start)
        trip = _trip(graph.plan(start, goal, world.speed(base)), base, yaw)
    except NoRoute as error:
        raise HmrsimError(f"{error} (error_code {error.code})") from None
    names = {point: name for name, point in world.points.items()}
    ends = {"from": {"name": args.start, "point": start}, "to": {"name": args.goal, "point": goal}}
    facts = {**ends, "robot": driver, "units": world.units, **_values(trip, names)}
    show_result(facts, _lines(trip, names, world.units), as_json=args.json)
    return ExitCode.DONE


def _trip(route: Route, base: Base, yaw: float | None) -> Trip:
    """Return the trip of a robot that starts with orientation *yaw*, or facing along the route if None."""
    if not route.legs:
        return Trip(route, base, (), 0.0)
    first = route.legs[0]
    driven = drive(
        Pose(*first.start, heading(first.start, first.end) if yaw is None else yaw),
        route.legs,
        None,
        speed=base.speed or 1.0,
        acceleration=base.acceleration,
        turning_rate=base.turning_rate,
    )
    pieces = [driven.piece(number) for number in range(len(driven.seconds))]
    seconds = tuple(piece.duration for piece in pieces if piece.leg is not None)
    return Trip(route, base, seconds, sum(piece.duration for piece in pieces if piece.leg is None))


def _ends(world: World, texts: Sequence[str], driver: str | None) -> list[Point]:
    points = [_point(world, text) for text in texts]
    named = [*world.places, *world.docks, *world.waypoints, *world.robots, *world.items]
    lines = [
        f"no point, place or thing {text!r}{instead(text, named)}"
        for text, point in zip(texts, points, strict=True)
        if point is None
    ]
    if driver is not None and driver not in world.robots:
        lines.append(f"no robot {driver!r}{instead(driver, world.robots)}")
    if lines:
        raise UnknownName("\n".join(lines))
    return [point for point in points if point is not None]


def _point(world: World, text: str) -> Point | None:
    if match := _POINT.fullmatch(text):
        point = float(match["x"]), float(match["y"])
        if not all(map(math.isfinite, point)):
            raise WrongUse(f"{text!r} is not a point; expected X,Y of finite numbers, such as 1.5,-2")
        return point
    thing = world.robots.get(text) or world.items.get(text)
    try:
        return world.point(text)
    except KeyError:
        return None if thing is None else world.point(thing.at)


def _values(trip: Trip, names: dict[Point, str]) -> dict[str, Any]:
    legs = [
        {
            "from": leg.start,
            "to": leg.end,
            "lane": leg.lane,
            "length": leg.length,
            "speed_limit": leg.speed_limit if leg.lane and leg.speed_limit < math.inf else None,
            "duration": seconds,
        }
        for leg, seconds in zip(trip.route.legs, trip.seconds, strict=True)
    ]
    return {
        "speed": trip.base.speed,
        "waypoints": _waypoints(trip.route, names),
        "legs": legs,
        "length": trip.route.length,
        "turning": trip.turning,
        "duration": trip.duration,
    }


def _waypoints(route: Route, names: dict[Point, str]) -> list[str]:
    points = [leg.start for leg in route.legs[:1]] + [leg.end for leg in route.legs]
    return [names[point] for point in points if point in names]


def _lines(trip: Trip, names: dict[Point, str], units: str) -> list[str]:
    legs = trip.route.legs
    rows = [(_label(legs[0].start, names), "", "", "start")] if legs else []
    rows += [
        (_label(leg.end, names), f"{_rounded(leg.length)} {units}", f"{seconds:.1f} s", _remark(leg, units))
        for leg, seconds in zip(legs, trip.seconds, strict=True)
    ]
    turning = f", of which {trip.turning:.1f} s are for turning" if trip.turning else ""
    total = f"{_rounded(trip.route.length)} {units} in {trip.duration:.1f} s at up to {trip.base.speed:g} {units}/s"
    return [*columns(rows, right=(1, 2)), f"{total}{turning}"]


def _rounded(length: float) -> str:
    return f"{round(length, 2):.10g}"


def _label(point: Point, names: dict[Point, str]) -> str:
    at = f"({point[0]:g}, {point[1]:g})"
    return f"{names[point]} {at}" if point in names else at


def _remark(leg: Leg, units: str) -> str:
    if leg.lane is None:
        return "off the lanes"
    if leg.ride:
        return "in a lift"
    return "" if leg.speed_limit == math.inf else f"at most {leg.speed_limit:g} {units}/s"
