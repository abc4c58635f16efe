"""``hmrsim map info``: the contents of a world, and the analysis of its lanes."""

from __future__ import annotations

import argparse
import math
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import asdict
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode
from hmrsim.cli.output import columns, counted, show_result
from hmrsim.cli.worlds import policy_line, read_world
from hmrsim.documents.document import read_text
from hmrsim.drawing import extent
from hmrsim.errors import printable
from hmrsim.geometry import distance
from hmrsim.topology import bottlenecks, concentration, parts, reach, seconds_at, speeds_of, trips
from hmrsim.topology.trips import MAX_STEPS, MIN_STARTS
from hmrsim.world.formats import choose

if TYPE_CHECKING:
    from hmrsim.topology import Trip, Trips
    from hmrsim.world import World
    from hmrsim.world_checks import LoadedWorld


_MAX_LINES: Final = 10
"""Maximum number of lines of each kind."""
_MAX_NAMES: Final = 4


def _lines(values: dict[str, Any], policy: str) -> Iterator[str]:
    units = values["units"]
    yield f"{values['name']} ({values['file']}, {values['format']})"
    box = values["bounds"] or values["extent"]
    if box:
        kind = "bounds" if values["bounds"] else "no bounds; all entities are within"
        yield f"{kind} ({box[0]:g}, {box[1]:g}) to ({box[2]:g}, {box[3]:g}) {units}"
    yield ", ".join(counted(number, key.replace("_", " ")) for key, number in values["counts"].items() if number)
    if values["counts"]["lanes"]:
        parts = f"in {len(values['parts'])} parts of {', '.join(map(str, values['parts'][:_MAX_LINES]))} waypoints"
        joined = "all connected" if len(values["parts"]) == 1 else parts
        yield f"lanes: {values['lane_length']:g} {units} in all, {values['one_way_lanes']} one-way, {joined}"
    if policy:
        yield policy
    yield from _listed("robots", (_robot_line(entry, units) for entry in values["robots"]))
    yield from _listed("items", (f"{entry['name']} {_at(entry)} {entry['weight']:g} kg" for entry in values["items"]))
    yield from _listed("places", (f"{entry['name']} {_at(entry)}" for entry in values["places"]))
    yield from _listed("docks", (f"{entry['name']} {_at(entry)} {entry['type']}" for entry in values["docks"]))
    yield from _listed("remap", (f"{alias} -> {target}" for alias, target in values["remap"].items()))
    yield from _bottleneck_lines(values["network"]["bottlenecks"])
    yield from _reach_lines(values["network"])
    yield from _trip_lines(values["network"], units)
    yield from _traffic_lines(values["network"], units)
    yield f"seed {values['seed']}, hash {values['hash']}"
    if values["warnings"]:
        yield f"{counted(values['warnings'], 'warnings')}; see `hmrsim map validate {values['file']}`"


def _listed(title: str, lines: Iterable[str]) -> Iterator[str]:
    rows = list(lines)
    if rows:
        yield f"{title}:"
    yield from (f"  {row}" for row in rows[:_MAX_LINES])
    if len(rows) > _MAX_LINES:
        yield f"  and {len(rows) - _MAX_LINES} more; --json has all"


def _robot_line(robot: dict[str, Any], units: str) -> str:
    parts = [f"{robot['name']} {_at(robot)} {robot['type']}, {robot['speed']:g} {units}/s", *robot["components"]]
    script = [f"a script of {counted(robot['script'], 'lines')}"] if robot["script"] else []
    return ", ".join([*parts, *script])


def _at(entry: dict[str, Any]) -> str:
    return f"({entry['at'][0]:g}, {entry['at'][1]:g})"


def _bottleneck_lines(values: dict[str, Any]) -> Iterator[str]:
    counts = [counted(values[kind], kind) for kind in ("waypoints", "lanes", "lifts") if values[kind]]
    if not counts:
        return
    yield f"bottlenecks: {', '.join(counts)}; each is the only way between its sides, the worst first"
    yield from _table([_bottleneck(entry) for entry in values["worst"][:_MAX_LINES]])
    if sum(values[kind] for kind in ("waypoints", "lanes", "lifts")) > _MAX_LINES:
        yield f"  and more; --json has {len(values['worst'])}, `hmrsim map render --bottlenecks` draws them"


def _bottleneck(entry: dict[str, Any]) -> tuple[str, ...]:
    largest, *others = entry["sides"]
    cut = sum(side["waypoints"] for side in others)
    total = cut + largest["waypoints"] + (entry["kind"] == "waypoint")
    places = [place for side in others for place in side["places"]]
    name = " - ".join(entry["name"]) + (f" (door {', '.join(entry['doors'])})" if entry["doors"] else "")
    apart = f" in {len(others)} parts" if len(others) > 1 else ""
    return entry["kind"], name, f"cuts off {cut} of {counted(total, 'waypoints')}{apart}", _places(places)


def _places(names: Sequence[str]) -> str:
    if not names:
        return ""
    more = ", …" if len(names) > _MAX_NAMES else ""
    return f"{counted(len(names), 'places')}: {', '.join(names[:_MAX_NAMES])}{more}"


def _reach_lines(values: dict[str, Any]) -> Iterator[str]:
    strong, missed = values["strong_parts"], values["unreachable"]
    if missed["pairs"]:
        yield f"unreachable: {counted(missed['pairs'], 'pairs')} of places and docks"
        rows: dict[tuple[str, str], list[str]] = {}
        for entry in missed["listed"]:
            rows.setdefault((entry["from"], entry["why"]), []).append(entry["to"])
        yield from _table(
            [(start, f"to {_named(goals)}", why) for (start, why), goals in islice(rows.items(), _MAX_LINES)]
        )
        if len(rows) > _MAX_LINES:
            yield f"  and from {len(rows) - _MAX_LINES} more; --json has {len(missed['listed'])} pairs"
    elif len(strong) > 1:
        sizes = ", ".join(map(str, strong[:_MAX_LINES])) + (", …" if len(strong) > _MAX_LINES else "")
        yield f"unreachable: no way leads back and forth between parts of {sizes} waypoints, none of places"


def _named(names: Sequence[str]) -> str:
    more = f" and {len(names) - _MAX_NAMES} more" if len(names) > _MAX_NAMES else ""
    return ", ".join(names[:_MAX_NAMES]) + more


def _trip_lines(values: dict[str, Any], units: str) -> Iterator[str]:
    trips = values["trips"]
    if not trips["longest_by_time"]:
        if trips["of"] > 1 and not trips["places"]:
            yield f"trips: not computed between {trips['of']} places and docks: there are too many lanes"
        return
    types = {entry["speed"]: entry["types"] for entry in values["speeds"]}
    sample = f"a sample of {trips['places']} of " if trips["places"] < trips["of"] else ""
    yield f"trips between {sample}{trips['of']} places and docks, without turning and acceleration:"
    speeds = [entry["speed"] for entry in trips["longest_by_time"][0]["seconds"]]
    head = ("", "", "length", *(f"{speed:g} {units}/s" for speed in speeds))
    whose = ("", "", "", *(_named(types[speed]) or "(default)" for speed in speeds))
    rows = [head, whose]
    for kind in ("longest_by_time", "longest_by_length", "shortest_by_time", "shortest_by_length"):
        if _is_redundant(trips, kind):
            continue
        for number, trip in enumerate(trips[kind]):
            arrow = "<->" if trip["both_ways"] else "->"
            seconds = (f"{entry['seconds']:.1f} s" for entry in trip["seconds"])
            name = f"{trip['from']} {arrow} {trip['to']}"
            rows.append(("" if number else kind.replace("_", " "), name, f"{trip['length']:.1f} {units}", *seconds))
    yield from _table(rows, right=range(2, len(head)))


def _is_redundant(trips: dict[str, Any], kind: str) -> bool:
    if kind.endswith("length") and trips[kind] == trips[kind.replace("length", "time")]:
        return True
    return kind.startswith("shortest") and trips[kind] == trips[kind.replace("shortest", "longest")][::-1]


def _traffic_lines(values: dict[str, Any], units: str) -> Iterator[str]:
    traffic = values["traffic"]
    if traffic is None:
        yield f"traffic: not computed: more than {values['max_lanes_of_traffic']} lanes, counting each direction"
        return
    if not traffic["shares"]:
        return
    sample = f"a sample of {traffic['starts']} of " if traffic["starts"] < traffic["of"] else ""
    ends = f"{traffic['of']} waypoints{' with places or docks' if traffic['between'] == 'places' else ''}"
    between = f"from {sample}{ends} to all of them" if sample else f"between {ends}"
    yield f"traffic: share of the quickest trips {between} at {traffic['speed']:g} {units}/s"
    yield from _table(
        [(" - ".join(entry["lane"]), f"{entry['share']:.1%}") for entry in traffic["shares"][:_MAX_LINES]], right=(1,)
    )


def _table(rows: Sequence[tuple[str, ...]], *, right: Container[int] = ()) -> Iterator[str]:
    return (f"  {line}" for line in columns(rows, right=right))


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
_MAX_LISTED: Final = 1_000
"""Entries of a list in the JSON."""
_MAX_TRIPS: Final = 5
"""Trips of each kind."""


def info(args: argparse.Namespace) -> int:
    """Print the contents of a world file; return the exit code."""
    loaded = read_world(args)
    values = _facts(loaded)
    show_result(values, map(printable, _lines(values, policy_line(loaded.world))), as_json=args.json)
    return ExitCode.DONE


def _facts(loaded: LoadedWorld) -> dict[str, Any]:
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
    """Return the analysis of a map's lanes as plain values, with lists of at most `_MAX_LISTED` entries."""
    graph, speeds = world.graph, speeds_of(world)
    speed = next(iter(speeds))
    weak, reached, traffic = bottlenecks(graph), reach(graph), concentration(graph, speed)
    driven = trips(world, speed)
    gaps = [(start, goal, "no lane leads there") for start, goals in reached.gaps.items() for goal in goals]
    gaps += [(*ends, why) for ends, why in driven.failed.items() if ends[1] not in reached.gaps.get(ends[0], ())]
    return {
        "speeds": [{"speed": speed, "types": types} for speed, types in speeds.items()],
        "parts": parts(graph),
        "strong_parts": reached.strong[:_MAX_LISTED],
        "unreachable": {
            "pairs": len(gaps),
            "listed": [{"from": start, "to": goal, "why": why} for start, goal, why in gaps[:_MAX_LISTED]],
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
            "shares": [{"lane": lane, "share": share} for lane, share in islice(traffic.shares.items(), _MAX_LISTED)],
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
