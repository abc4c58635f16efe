"""The text of ``hmrsim map info``: the contents of a world, bottlenecks, gaps, trips and traffic."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from itertools import islice
from typing import Any, Final

from hmrsim.cli.output import columns, counted
from hmrsim.errors import printable

_MAX_LINES: Final = 10
"""Maximum number of lines of each kind."""
_MAX_NAMES: Final = 4


def lines(values: dict[str, Any], policy: str) -> Iterator[str]:
    """Yield the lines about a world; *policy* is the line about its traffic policy."""
    return map(printable, _lines(values, policy))


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
    """Return whether another table shows the same trips."""
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
    """Yield rows as indented lines of aligned columns."""
    return (f"  {line}" for line in columns(rows, right=right))
