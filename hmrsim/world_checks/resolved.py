"""A world with its defaults applied and its names resolved, as plain values for programs that show it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim.actions import registry as actions
from hmrsim.distributions import mean
from hmrsim.events import texts
from hmrsim.faults import registry as faults
from hmrsim.geometry import distance
from hmrsim.traffic.policies import registry as policies
from hmrsim.traffic.policies import settings_of
from hmrsim.world.model import BUILT_IN_TYPES, Solid, Waypoint
from hmrsim.world.segments import SegmentGrid

if TYPE_CHECKING:
    from hmrsim.world.model import Door, RobotSpec, World


def shown(world: World) -> dict[str, Any]:
    """Return the constant data for showing a simulation of a world.

    It consists of the world itself, `resolved`, the JSON Schemas of the forms for each action and each fault, by name,
    and the templates of events by kind, `hmrsim.events.texts`.
    """
    return {
        "world": resolved(world),
        "actions": {name: action.form() for name, action in actions().items()},
        "faults": {name: fault.form() for name, fault in faults().items()},
        "events": texts(),
    }


def resolved(world: World) -> dict[str, Any]:
    """Return the world for a picture: lists in the order of the file, points as coordinates.

    Lengths and speeds are in the world's unit; a capacity of None is any number.
    """
    waypoint_capacity, lane_capacity = _capacities(world)
    lanes = world.lanes if world.doors else ()
    grid = SegmentGrid([(world.points[lane.from_], world.points[lane.to]) for lane in lanes])
    return {
        "name": world.name,
        "units": world.units,
        "policy": world.policy,
        "bounds": world.bounds,
        "walls": [
            {"points": wall.solid, "solid": True} if isinstance(wall, Solid) else {"points": wall, "solid": False}
            for wall in world.walls
        ],
        "waypoints": [
            {
                "name": name,
                "at": world.points[name],
                "capacity": (waypoint.capacity if isinstance(waypoint, Waypoint) else None) or waypoint_capacity,
            }
            for name, waypoint in world.waypoints.items()
        ],
        "lanes": [
            {
                "from": lane.from_,
                "to": lane.to,
                "one_way": lane.one_way,
                "length": distance(world.points[lane.from_], world.points[lane.to]),
                "speed_limit": lane.speed_limit,
                "capacity": lane.capacity or lane_capacity,
            }
            for lane in world.lanes
        ],
        "places": [{"name": name, "at": place.at} for name, place in world.places.items()],
        "docks": [
            {
                "name": name,
                "at": world.dock_point(name),
                "type": dock.type,
                "capacity": dock.capacity,
                "yaw": dock.yaw,
                "charges": dock.charges,
                "staging": dock.staging,
                "reserved_for": dock.reserved_for,
            }
            for name, dock in world.docks.items()
        ],
        "doors": [
            {
                "name": name,
                **door.model_dump(mode="json"),
                "opening_time": mean(door.opening_time),
                "lanes": _lanes_through(world, grid, door),
            }
            for name, door in world.doors.items()
        ],
        "lifts": [
            {
                "name": name,
                **lift.model_dump(mode="json"),
                "travel_time": mean(lift.travel_time),
                "door_time": mean(lift.door_time),
                "at": lift.at or lift.stops[0],
                "points": [world.points[stop] for stop in lift.stops],
            }
            for name, lift in world.lifts.items()
        ],
        "items": [
            {"name": name, "at": world.point(item.at), "weight": item.weight, "blocks": item.blocks}
            for name, item in world.items.items()
        ],
        "robot_types": [{"name": name, **_base(world, kind.base)} for name, kind in _types(world).items()],
        "robots": [_robot(world, name, robot) for name, robot in world.robots.items()],
        "demand": [demand.name for demand in world.demand],
    }


def type_order(world: World) -> list[str]:
    """Return all types of robots, first those that the world's robots have.

    A type has the same number in every picture of a world, and so the same color and shape.
    """
    used = (robot.type for robot in world.robots.values())
    return [*dict.fromkeys([*used, *world.robot_types, *BUILT_IN_TYPES])]


def _types(world: World) -> dict[str, Any]:
    return {name: world.robot_types.get(name) or BUILT_IN_TYPES[name] for name in type_order(world)}


def _robot(world: World, name: str, robot: RobotSpec) -> dict[str, Any]:
    at = {"name": name, "type": robot.type, "at": world.point(robot.at), "yaw": robot.yaw}
    return {**at, **_base(world, world.robot_type(robot).base)}


def _base(world: World, base: Any) -> dict[str, Any]:
    return {"radius": base.radius, "flies": base.flies, "speed": world.speed(base)}


def _capacities(world: World) -> tuple[int | None, int | None]:
    """Return the default capacities of waypoints and lanes."""
    policy = policies().get(world.policy)
    if policy is None or policy.rule is None:
        return None, None
    settings = settings_of(world)
    return getattr(settings, "waypoint_capacity", None), getattr(settings, "lane_capacity", None)


def _lanes_through(world: World, grid: SegmentGrid, door: Door) -> list[tuple[str, str]]:
    lanes = (world.lanes[i] for i in grid.crossings(*door.at))
    return [(lane.from_, lane.to) for lane in lanes]
