"""``hmrsim map convert`` and ``hmrsim map render``: a world in another format, or as a picture."""

from __future__ import annotations

import argparse
import json
import math
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

from hmrsim.cli.options import ExitCode, WrongUse
from hmrsim.cli.output import check_target, show, show_result, warn, write_whole
from hmrsim.cli.worlds import read_world, show_warnings
from hmrsim.drawing import Drawing, Overlay, Weak
from hmrsim.program.files import STDOUT, check_outputs
from hmrsim.world import World
from hmrsim.world.formats import choose
from hmrsim.world.route_graph import to_geojson
from hmrsim.world.writing import to_json, to_yaml

if TYPE_CHECKING:
    from hmrsim.topology import Bottleneck, Bottlenecks, Concentration

_SCHEMA: Final = Path("schemas", "world.schema.json")
_IN_GEOJSON: Final = ("name", "units", "include", "waypoints", "lanes")
"""The keys of a world that a route graph contains, or that mean nothing without the others."""

_MAX_PIXELS: Final = 200e6


def convert(args: argparse.Namespace) -> int:
    """Write a world in another format; return the exit code."""
    to = args.to or _format(args.out)
    out = Path(args.out)
    if args.out == STDOUT and args.json:
        raise WrongUse("--json and OUT - both write to stdout; name a file")
    if args.out != STDOUT:
        check_target(out, force=args.force)
    loaded = read_world(args)
    check_outputs([("OUT", args.out)], loaded.files)
    show_warnings(loaded)
    text = _WRITERS[to](loaded.world, out)
    left = _left_out(loaded.world) if to == "geojson" else {}
    for kind, number in left.items():
        warn(f"{args.out}: GeoJSON holds no {kind.replace('_', ' ')}: {number} left out")
    if to == "geojson" and loaded.world.units == "px":
        warn(f"{args.out}: coordinates stay in pixels, y downwards; Nav2 reads them as meters, y upwards")
    if args.out == STDOUT:
        show(text.rstrip("\n"))
        return ExitCode.DONE
    write_whole(out, text.encode())
    facts = {"file": args.out, "format": to, "world": loaded.world.name, "hash": loaded.hash, "left_out": left}
    facts["warnings"] = [str(problem) for problem in loaded.warnings]
    show_result(facts, f"{args.out}: {loaded.world.name!r} as {to}", as_json=args.json)
    return ExitCode.DONE


def _format(out: str) -> str:
    suffix = Path(out).suffix.lower().removeprefix(".").replace("yml", "yaml")
    kind = choose(Path(out).name, "")
    if out == STDOUT:
        return "yaml"
    if suffix not in _WRITERS or (kind is not None and kind.name not in ("native", "geojson")):
        known = ", ".join(f".{name}" for name in _WRITERS)
        raise WrongUse(f"{out}: unknown output format; expected one of {known}, or --to")
    return suffix


def _left_out(world: World) -> dict[str, int]:
    """Return the number of entities of each kind that a route graph can't contain."""
    kept = {kind: getattr(world, kind) for kind in World.model_fields if kind not in _IN_GEOJSON}
    return {
        kind: 1 if kind == "bounds" or not isinstance(value, (dict, tuple)) else len(value)
        for kind, value in kept.items()
        if value != World.model_fields[kind].default
    }


def _as_yaml(world: World, out: Path) -> str:
    """Return YAML that refers to the schema if a parent folder has it."""
    folders = out.absolute().parents if str(out) != STDOUT else ()
    near = next((folder for folder in folders if (folder / _SCHEMA).is_file()), None)
    schema = None if near is None else os.path.relpath(near / _SCHEMA, folders[0])
    return to_yaml(world, schema=schema)


def _as_geojson(world: World, _out: Path) -> str:
    graph = to_geojson(world)
    features = ",\n".join(f"    {json.dumps(feature)}" for feature in graph.pop("features"))
    return f'{json.dumps(graph)[:-1]}, "features": [\n{features}\n]}}\n'


_WRITERS: Final[Mapping[str, Callable[[World, Path], str]]] = {
    "yaml": _as_yaml,
    "json": lambda world, _out: to_json(world),
    "geojson": _as_geojson,
}


def render(args: argparse.Namespace) -> int:
    """Draw a world; return the exit code."""
    out, to = Path(args.output), _picture_format(args.output)
    if args.output != STDOUT:
        check_target(out, force=True)
    loaded = read_world(args)
    check_outputs([("-o", args.output)], loaded.files)
    show_warnings(loaded)
    overlay = _overlay_of(loaded.world, args.theme) if args.bottlenecks else None
    drawing = Drawing(
        loaded.world,
        args.theme,
        width=args.width,
        names=not args.no_names,
        legend=not args.no_legend,
        details=args.details,
        overlay=overlay,
    )
    svg = drawing.svg()
    if args.output == STDOUT:
        show(svg)
        return ExitCode.DONE
    write_whole(out, _png(svg, drawing, args.scale) if to == "png" else f"{svg}\n".encode())
    return ExitCode.DONE


def _picture_format(out: str) -> str:
    suffix = Path(out).suffix.lower()
    if out != STDOUT and suffix not in (".svg", ".png"):
        raise WrongUse(f"{out}: unknown picture format; expected one of .svg, .png")
    return suffix.removeprefix(".")


def _png(svg: str, drawing: Drawing, scale: float) -> bytes:
    width, height = drawing.size
    if width * height * scale * scale > _MAX_PIXELS:
        raise WrongUse(
            f"a PNG of {width * scale:.0f} x {height * scale:.0f} pixels is too large; give less --width or --scale"
        )
    try:
        from resvg_py import svg_to_bytes
    except ImportError:
        raise WrongUse("a PNG needs a package that is not installed; pip install 'hmrsim[png]', or draw .svg") from None
    return bytes(svg_to_bytes(svg_string=svg, zoom=scale))


def _overlay_of(world: World, theme: Literal["light", "dark"]) -> Overlay:
    """Return the traffic and bottlenecks of a world to draw, and warn if some are omitted because the map is large."""
    # Loads networkx, which takes longer than drawing most worlds.
    from hmrsim.topology import bottlenecks, concentration, speeds_of

    traffic = concentration(world.graph, next(iter(speeds_of(world))))
    weak = bottlenecks(world.graph)
    if note := _limits(traffic, weak):
        warn(f"hmrsim: {note}")
    drawn = tuple(_weak(world, bottleneck) for bottleneck in weak.worst)
    return Overlay(traffic.shares if traffic else {}, drawn, theme)


def _limits(traffic: Concentration | None, weak: Bottlenecks) -> str:
    """Return a note about what is omitted or inexact because the map is large."""
    notes = []
    if traffic is None:
        notes.append("traffic is not drawn: there are too many lanes")
    elif traffic.starts < traffic.of:
        notes.append(f"traffic is counted from a sample of {traffic.starts} of {traffic.of} waypoints")
    total = weak.waypoints + weak.lanes + weak.lifts
    if len(weak.worst) < total:
        notes.append(f"the worst {len(weak.worst)} of {total} bottlenecks are drawn")
    return "; ".join(notes)


def _weak(world: World, bottleneck: Bottleneck) -> Weak:
    sizes = [side.waypoints for side in bottleneck.sides]
    names = world.lifts[bottleneck.name[0]].stops if bottleneck.kind == "lift" else bottleneck.name
    apart = " | ".join(f"{side.waypoints} waypoints, {len(side.places)} places" for side in bottleneck.sides)
    weight = math.sqrt(min(1.0, 2 * (sum(sizes) - sizes[0]) / sum(sizes)))
    return Weak(names, bottleneck.kind, weight, f"{' - '.join(bottleneck.name)} is the only way between {apart}")
