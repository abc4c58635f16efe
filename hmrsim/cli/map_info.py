"""``hmrsim map info``: the contents of a world, and the analysis of its lanes."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.map_info_text import lines
from hmrsim.cli.output import show_result
from hmrsim.cli.worlds import policy_line, read_world
from hmrsim.documents.document import read_text
from hmrsim.drawing import extent
from hmrsim.geometry import distance
from hmrsim.topology import bottlenecks, concentration, parts, reach, seconds_at, speeds_of, trips
from hmrsim.topology.concentration import MAX_STEPS, MIN_STARTS
from hmrsim.world.formats import choose

if TYPE_CHECKING:
    from hmrsim.topology import Trip, Trips
    from hmrsim.world import World
    from hmrsim.world_checks import LoadedWorld

_COUNTED: Final = (
    "waypoints",
    "lanes",
    "walls",
    "places",
    "docks",
    "doors",
    "lifts",
    "items",
    "robot_types",
    "robots",
    "faults",
)
MAX_LISTED: Final = 1_000
"""Entries of a list in the JSON."""
_MAX_TRIPS: Final = 5
"""Trips of each kind."""


def info(args: argparse.Namespace) -> int:
    """Print the contents of a world file; return the exit code."""
    loaded = read_world(args, argument="file")
    values = facts(loaded)
    show_result(values, lines(values, policy_line(loaded.world)), as_json=args.json)
    return ExitCode.DONE


def facts(loaded: LoadedWorld) -> dict[str, Any]:
    """Return the contents and statistics of a world, as plain values."""
    world = loaded.world
    network = _lane_facts(world)
    kind = choose(loaded.path.name, read_text(loaded.path, str(loaded.path)))
    return {
        "name": world.name,
        "file": str(loaded.path),
        "format": kind.name if kind else None,
        "units": world.units,
        "bounds": world.bounds,
        "extent": extent(world),
        "seed": world.seed,
        "hash": loaded.hash,
        "warnings": len(loaded.warnings),
        "traffic": {"policy": world.policy, "by_default": world.traffic.policy is None},
        "counts": {key: len(getattr(world, key)) for key in _COUNTED},
        "one_way_lanes": sum(lane.one_way for lane in world.lanes),
        "lane_length": math.fsum(distance(world.points[lane.from_], world.points[lane.to]) for lane in world.lanes),
        "parts": network.pop("parts"),
        "network": network,
        "robots": [_robot(world, name) for name in world.robots],
        "items": [
            {"name": name, "at": world.point(entry.at), "weight": entry.weight} for name, entry in world.items.items()
        ],
        "places": [{"name": name, "at": entry.at} for name, entry in world.places.items()],
        "docks": [
            {"name": name, **entry.model_dump(), "at": world.dock_point(name)} for name, entry in world.docks.items()
        ],
        "remap": world.remap,
    }


def _robot(world: World, name: str) -> dict[str, Any]:
    robot = world.robots[name]
    kind = world.robot_type(robot)
    return {
        "name": name,
        "type": robot.type,
        "components": list(kind.components),
        "speed": world.speed(kind.base),
        "at": world.point(robot.at),
        "yaw": robot.yaw,
        "script": len(robot.script),
    }


def _lane_facts(world: World) -> dict[str, Any]:
    """Return the analysis of a map's lanes as plain values, with lists of at most `MAX_LISTED` entries."""
    graph, speeds = world.graph, speeds_of(world)
    speed = next(iter(speeds))
    weak, reached, traffic = bottlenecks(graph), reach(graph), concentration(graph, speed)
    driven = trips(world, speed)
    gaps = [(start, goal, "no lane leads there") for start, goals in reached.gaps.items() for goal in goals]
    gaps += [(*ends, why) for ends, why in driven.failed.items() if ends[1] not in reached.gaps.get(ends[0], ())]
    return {
        "speeds": [{"speed": speed, "types": types} for speed, types in speeds.items()],
        "parts": parts(graph),
        "strong_parts": reached.strong[:MAX_LISTED],
        "unreachable": {
            "pairs": len(gaps),
            "listed": [{"from": start, "to": goal, "why": why} for start, goal, why in gaps[:MAX_LISTED]],
        },
        "bottlenecks": {
            "waypoints": weak.waypoints,
            "lanes": weak.lanes,
            "lifts": weak.lifts,
            "worst": [
                {**asdict(entry), "doors": _doors(world, entry.name) if entry.kind == "lane" else ()}
                for entry in weak.worst
            ],
        },
        "trips": _trips(world, driven, _shown_speeds(speeds)),
        "max_lanes_of_traffic": MAX_STEPS // MIN_STARTS,
        "traffic": traffic
        and {
            "between": traffic.between,
            "starts": traffic.starts,
            "of": traffic.of,
            "speed": speed,
            "shares": [{"lane": lane, "share": share} for lane, share in islice(traffic.shares.items(), MAX_LISTED)],
        },
    }


def _doors(world: World, ends: tuple[str, ...]) -> tuple[str, ...]:
    a, b = ends
    lane = world.graph.get_edge_data(a, b) or world.graph.edges[b, a]
    doors: tuple[str, ...] = lane["doors"]
    return doors


def _shown_speeds(speeds: Iterable[float]) -> list[float]:
    """Return the speed of most robots, the lowest and the highest."""
    most, *others = speeds
    return list(dict.fromkeys([most, *sorted([most, *others])[:1], max([most, *others])]))


def _trips(world: World, driven: Trips, speeds: Sequence[float]) -> dict[str, Any]:
    by_time = sorted(driven.found, key=lambda trip: (round(trip.seconds, 6), trip.start, trip.goal))
    by_length = sorted(driven.found, key=lambda trip: (round(trip.length, 6), trip.start, trip.goal))
    both = {(trip.start, trip.goal): trip for trip in driven.found}
    kinds = {
        "shortest_by_time": by_time,
        "longest_by_time": sorted(by_time, key=lambda trip: -round(trip.seconds, 6)),
        "shortest_by_length": by_length,
        "longest_by_length": sorted(by_length, key=lambda trip: -round(trip.length, 6)),
    }
    listed = {kind: list(islice(_without_returns(ranked, both), _MAX_TRIPS)) for kind, ranked in kinds.items()}
    shown = list(dict.fromkeys(trip for ranked in listed.values() for trip, _ in ranked))
    others = {speed: seconds_at(world, shown, speed) for speed in speeds[1:]} if shown else {}
    return {
        "places": driven.places,
        "of": driven.of,
        **{
            kind: [
                {
                    "from": trip.start,
                    "to": trip.goal,
                    "both_ways": both_ways,
                    "length": trip.length,
                    "seconds": [
                        {"speed": driven.speed, "seconds": trip.seconds},
                        *({"speed": speed, "seconds": at[trip.start, trip.goal]} for speed, at in others.items()),
                    ],
                }
                for trip, both_ways in ranked
            ]
            for kind, ranked in listed.items()
        },
    }


def _without_returns(ranked: Iterable[Trip], both: dict[tuple[str, str], Trip]) -> Iterator[tuple[Trip, bool]]:
    """Yield trips, and whether the trip back takes as long; of such a pair only one is yielded."""
    for trip in ranked:
        back = both.get((trip.goal, trip.start))
        same = (
            back is not None
            and math.isclose(back.seconds, trip.seconds, abs_tol=1e-6)
            and math.isclose(back.length, trip.length, abs_tol=1e-6)
        )
        if not same or trip.start < trip.goal:
            yield trip, same
