"""Bottlenecks, gaps, trips and traffic as text in aligned columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any, Final

_MAX_ROWS: Final = 10
_MAX_NAMES: Final = 4


def lines(values: dict[str, Any], units: str) -> Iterator[str]:
    """Return the analysis of a map as lines of text."""
    yield from _bottleneck_lines(values["bottlenecks"])
    yield from _reach_lines(values)
    yield from _trip_lines(values, units)
    yield from _traffic_lines(values, units)


def _bottleneck_lines(values: dict[str, Any]) -> Iterator[str]:
    found = [counted(values[kind], kind) for kind in ("waypoints", "lanes", "lifts") if values[kind]]
    if not found:
        return
    yield f"bottlenecks: {', '.join(found)}; each is the only way between its sides, the worst first"
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
    return one["kind"], name, f"cuts off {cut} of {counted(total, 'waypoints')}{apart}", _places(places)


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
        yield f"traffic: not computed: more than {values['max_lanes_of_traffic']} lanes, counting each direction"
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
    """Return rows as lines of aligned columns; those from *right* on are right-aligned."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)] if rows else []
    for row in rows:
        cells = [
            cell.rjust(width) if i >= right else cell.ljust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield f"  {'  '.join(cells)}".rstrip()


def counted(number: int, nouns: str) -> str:
    """Return a number with its noun, which is given in the plural."""
    return f"{number} {nouns.removesuffix('s') if number == 1 else nouns}"
