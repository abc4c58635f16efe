"""What ``hmrsim map info`` tells of the lanes: bottlenecks, what can't be reached, trips, and traffic."""

from __future__ import annotations

import math
from dataclasses import asdict
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

from hmrsim.topology import bottlenecks, concentration, reach, seconds_at, speeds_of, trips
from hmrsim.topology.concentration import MAX_STEPS, MIN_STARTS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from hmrsim.topology import Trip, Trips
    from hmrsim.world import World

MAX_LISTED: Final = 1_000
"""Entries of a list in the JSON."""
_MAX_TRIPS: Final = 5
"""Trips of each kind."""
_MAX_ROWS: Final = 10
_MAX_NAMES: Final = 4


def facts(world: World) -> dict[str, Any]:
    """Return what planners ask of a map, as plain values; no list is longer than `MAX_LISTED`."""
    graph, speeds = world.graph, speeds_of(world)
    speed = next(iter(speeds))
    found, reached, traffic = bottlenecks(graph), reach(graph), concentration(graph, speed)
    driven = trips(world, speed)
    gaps = [(start, goal, "no lane leads there") for start, goals in reached.gaps.items() for goal in goals]
    gaps += [(*ends, why) for ends, why in driven.failed.items() if ends[1] not in reached.gaps.get(ends[0], ())]
    return {
        "speeds": [{"speed": one, "types": types} for one, types in speeds.items()],
        "strong_parts": reached.strong[:MAX_LISTED],
        "unreachable": {
            "pairs": len(gaps),
            "listed": [{"from": start, "to": goal, "why": why} for start, goal, why in gaps[:MAX_LISTED]],
        },
        "bottlenecks": {
            "waypoints": found.waypoints,
            "lanes": found.lanes,
            "lifts": found.lifts,
            "worst": [
                {**asdict(one), "doors": _doors(world, one.name) if one.kind == "lane" else ()} for one in found.worst
            ],
        },
        "trips": _trips(world, driven, _told_speeds(speeds)),
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


def _told_speeds(speeds: Iterable[float]) -> list[float]:
    """Return the speed of most robots, the least and the greatest."""
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
    listed = {kind: list(islice(_one_way_each(ranked, both), _MAX_TRIPS)) for kind, ranked in kinds.items()}
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


def _one_way_each(ranked: Iterable[Trip], both: dict[tuple[str, str], Trip]) -> Iterator[tuple[Trip, bool]]:
    """Yield trips and whether the way back is as long; such a one comes once."""
    for trip in ranked:
        back = both.get((trip.goal, trip.start))
        same = (
            back is not None
            and math.isclose(back.seconds, trip.seconds, abs_tol=1e-6)
            and math.isclose(back.length, trip.length, abs_tol=1e-6)
        )
        if not same or trip.start < trip.goal:
            yield trip, same


def lines(values: dict[str, Any], units: str) -> Iterator[str]:
    """Return the same in lines for people."""
    yield from _bottleneck_lines(values["bottlenecks"])
    yield from _reach_lines(values)
    yield from _trip_lines(values, units)
    yield from _traffic_lines(values, units)


def _bottleneck_lines(values: dict[str, Any]) -> Iterator[str]:
    counted = [_counted(values[kind], kind) for kind in ("waypoints", "lanes", "lifts") if values[kind]]
    if not counted:
        return
    yield f"bottlenecks: {', '.join(counted)}; each is the only way between its sides, the worst first"
    yield from _table([_bottleneck(one) for one in values["worst"][:_MAX_ROWS]])
    if sum(values[kind] for kind in ("waypoints", "lanes", "lifts")) > _MAX_ROWS:
        yield f"  and more; --json has {len(values['worst'])}, `hmrsim map render --bottlenecks` draws them"


def _bottleneck(one: dict[str, Any]) -> tuple[str, ...]:
    largest, *others = one["sides"]
    cut = sum(side["waypoints"] for side in others)
    total = cut + largest["waypoints"] + (one["kind"] == "waypoint")
    places = [place for side in others for place in side["places"]]
    name = " - ".join(one["name"]) + (f" (door {', '.join(one['doors'])})" if one["doors"] else "")
    apart = f" in {len(others)} parts" if len(others) > 1 else ""
    return one["kind"], name, f"cuts off {cut} of {_counted(total, 'waypoints')}{apart}", _places(places)


def _places(names: Sequence[str]) -> str:
    if not names:
        return ""
    more = ", …" if len(names) > _MAX_NAMES else ""
    return f"{_counted(len(names), 'places')}: {', '.join(names[:_MAX_NAMES])}{more}"


def _reach_lines(values: dict[str, Any]) -> Iterator[str]:
    strong, missed = values["strong_parts"], values["unreachable"]
    if missed["pairs"]:
        yield f"unreachable: {_counted(missed['pairs'], 'pairs')} of places and docks"
        rows: dict[tuple[str, str], list[str]] = {}
        for one in missed["listed"]:
            rows.setdefault((one["from"], one["why"]), []).append(one["to"])
        yield from _table(
            [(start, f"to {_named(goals)}", why) for (start, why), goals in islice(rows.items(), _MAX_ROWS)]
        )
        if len(rows) > _MAX_ROWS:
            yield f"  and from {len(rows) - _MAX_ROWS} more; --json has {len(missed['listed'])} pairs"
    elif len(strong) > 1:
        sizes = ", ".join(map(str, strong[:_MAX_ROWS])) + (", …" if len(strong) > _MAX_ROWS else "")
        yield f"unreachable: no way leads back and forth between parts of {sizes} waypoints, none of places"


def _named(names: Sequence[str]) -> str:
    more = f" and {len(names) - _MAX_NAMES} more" if len(names) > _MAX_NAMES else ""
    return ", ".join(names[:_MAX_NAMES]) + more


def _trip_lines(values: dict[str, Any], units: str) -> Iterator[str]:
    told = values["trips"]
    if not told["longest_by_time"]:
        if told["of"] > 1 and not told["places"]:
            yield f"trips: not computed between {told['of']} places and docks: there are too many lanes"
        return
    types = {one["speed"]: one["types"] for one in values["speeds"]}
    sample = f"a sample of {told['places']} of " if told["places"] < told["of"] else ""
    yield f"trips between {sample}{told['of']} places and docks, without turning and acceleration:"
    speeds = [one["speed"] for one in told["longest_by_time"][0]["seconds"]]
    head = ("", "", "length", *(f"{speed:g} {units}/s" for speed in speeds))
    whose = ("", "", "", *(_named(types[speed]) or "(default)" for speed in speeds))
    rows = [head, whose]
    for kind in ("longest_by_time", "longest_by_length", "shortest_by_time", "shortest_by_length"):
        if _is_told(told, kind):
            continue
        for number, trip in enumerate(told[kind]):
            arrow = "<->" if trip["both_ways"] else "->"
            seconds = (f"{one['seconds']:.1f} s" for one in trip["seconds"])
            name = f"{trip['from']} {arrow} {trip['to']}"
            rows.append(("" if number else kind.replace("_", " "), name, f"{trip['length']:.1f} {units}", *seconds))
    yield from _table(rows, right=2)


def _is_told(told: dict[str, Any], kind: str) -> bool:
    """Return whether another table has the same trips in the same order, or all of them."""
    if kind.endswith("length") and told[kind] == told[kind.replace("length", "time")]:
        return True
    return kind.startswith("shortest") and told[kind] == told[kind.replace("shortest", "longest")][::-1]


def _traffic_lines(values: dict[str, Any], units: str) -> Iterator[str]:
    traffic = values["traffic"]
    if traffic is None:
        yield f"traffic: not computed: more than {MAX_STEPS // MIN_STARTS} lanes, counting each direction"
        return
    if not traffic["shares"]:
        return
    sample = f"a sample of {traffic['starts']} of " if traffic["starts"] < traffic["of"] else ""
    ends = f"{traffic['of']} waypoints{' with places or docks' if traffic['between'] == 'places' else ''}"
    between = f"from {sample}{ends} to all of them" if sample else f"between {ends}"
    yield f"traffic: share of the quickest trips {between} at {traffic['speed']:g} {units}/s"
    yield from _table(
        [(" - ".join(one["lane"]), f"{one['share']:.1%}") for one in traffic["shares"][:_MAX_ROWS]], right=1
    )


def _table(rows: Sequence[tuple[str, ...]], *, right: int = 99) -> Iterator[str]:
    """Return rows as lines of aligned columns; those from *right* on are numbers."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)] if rows else []
    for row in rows:
        cells = [
            cell.rjust(width) if i >= right else cell.ljust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield f"  {'  '.join(cells)}".rstrip()


def _counted(number: int, nouns: str) -> str:
    return f"{number} {nouns.removesuffix('s') if number == 1 else nouns}"
