"""``hmrsim map convert``: the same world in another format."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.options import add_world_options
from hmrsim.cli.output import check_target, show, show_json, warn, write_whole
from hmrsim.cli.worlds import read_world, show_warnings
from hmrsim.program.command_line import ENVIRONMENT
from hmrsim.program.outputs import check_outputs
from hmrsim.world import World
from hmrsim.world.formats import choose
from hmrsim.world.route_graph import to_geojson
from hmrsim.world.writing import to_json, to_yaml

_EXAMPLES: Final = f"""\
OUT's suffix chooses the format: .yaml or .json is a native world, which holds everything; .geojson is the route graph
of Nav2's Route Server. What a world or OUT can't hold is reported on stderr. Files that IN
includes are merged in.

examples:
  hmrsim map convert drawing.drawio world.yaml
  hmrsim map convert office.building.yaml office.geojson
  hmrsim map convert arena.map arena.yaml --neighbours 4
  hmrsim map convert hospital hospital.geojson --force
  hmrsim map convert scenario1 - --to geojson | jq '.features | length'

{ENVIRONMENT}"""

_STDOUT: Final = "-"
_SCHEMA: Final = Path("schemas", "world.schema.json")
_IN_GEOJSON: Final = ("name", "units", "include", "waypoints", "lanes")
"""The keys of a world that a route graph holds, or that mean nothing without the rest."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map convert``."""
    parser.description = "Write a world in another format."
    parser.epilog = _EXAMPLES
    add_world_options(parser, argument="in")
    parser.add_argument("out", metavar="OUT", help="the file to write, or - for stdout")
    parser.add_argument("--to", choices=[*_WRITERS], help="the format (default: that of OUT's suffix; yaml for -)")
    parser.add_argument("--force", action="store_true", help="overwrite OUT")
    parser.add_argument("--json", action="store_true", help="print one JSON object about what was written")
    parser.set_defaults(function=_convert)


def _convert(args: argparse.Namespace) -> int:
    to = args.to or _format(args.out)
    out = Path(args.out)
    if args.out == _STDOUT and args.json:
        raise WrongUse("--json and OUT - both write to stdout; name a file")
    if args.out != _STDOUT:
        check_target(out, force=args.force)
    loaded = read_world(args, argument="in")
    check_outputs([("OUT", args.out)], loaded.files)
    show_warnings(loaded)
    text = _WRITERS[to](loaded.world, out)
    left = _left_out(loaded.world) if to == "geojson" else {}
    for kind, number in left.items():
        warn(f"{args.out}: GeoJSON holds no {kind.replace('_', ' ')}: {number} left out")
    if to == "geojson" and loaded.world.units == "px":
        warn(f"{args.out}: coordinates stay in pixels, y downwards; Nav2 reads them as metres, y upwards")
    if args.out == _STDOUT:
        show(text.rstrip("\n"))
        return ExitCode.DONE
    write_whole(out, text.encode())
    if args.json:
        told = {"file": args.out, "format": to, "world": loaded.world.name, "hash": loaded.hash, "left_out": left}
        show_json({**told, "warnings": [str(problem) for problem in loaded.warnings]})
    else:
        show(f"{args.out}: {loaded.world.name!r} as {to}")
    return ExitCode.DONE


def _format(out: str) -> str:
    """Return the format of a file, by its name."""
    suffix = Path(out).suffix.lower().removeprefix(".").replace("yml", "yaml")
    kind = choose(Path(out).name, "")
    if out == _STDOUT:
        return "yaml"
    if suffix not in _WRITERS or (kind is not None and kind.name not in ("native", "geojson")):
        known = ", ".join(f".{name}" for name in _WRITERS)
        raise WrongUse(f"{out}: unknown output format; expected one of {known}, or --to")
    return suffix


def _left_out(world: World) -> dict[str, int]:
    """Return the number of entities of each kind that a route graph can't hold."""
    kept = {kind: getattr(world, kind) for kind in World.model_fields if kind not in _IN_GEOJSON}
    return {
        kind: 1 if kind == "bounds" or not isinstance(value, (dict, tuple)) else len(value)
        for kind, value in kept.items()
        if value != World.model_fields[kind].default
    }


def _as_yaml(world: World, out: Path) -> str:
    """Return YAML that names its schema if that is in a folder nearby."""
    folders = out.absolute().parents if str(out) != _STDOUT else ()
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
