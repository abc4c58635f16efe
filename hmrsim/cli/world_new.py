"""``hmrsim world new``: a commented world to begin with."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show
from hmrsim.cli.targets import check_target, write_whole
from hmrsim.world.files import folder

_SUFFIXES: Final = (".yaml", ".yml")
SCHEMA: Final = "world.schema.json"
"""The schema's file beside a world."""

_START: Final = Path(__file__).with_name("world_new.yaml")

_EXAMPLES: Final = """\
examples:
  hmrsim world new my_world.yaml
  hmrsim map validate my_world.yaml && hmrsim run my_world.yaml --view"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim world new``."""
    parser.description = (
        "Write a world to begin with: two rooms, a robot that carries things, and a comment on each part. The schema "
        f"is written beside it, as {SCHEMA}, so that editors complete keys and mark mistakes."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("file", metavar="FILE", type=world_file, help="the file to write")
    parser.add_argument("--force", action="store_true", help="overwrite FILE")
    parser.set_defaults(function=_new)


def world_file(text: str) -> Path:
    """Return the path of a world to write, for an argument."""
    path = Path(text)
    if path.suffix not in _SUFFIXES:
        raise argparse.ArgumentTypeError(f"{text}: a world is YAML; expected a name that ends in .yaml")
    return path


def _new(args: argparse.Namespace) -> int:
    check_target(args.file, force=args.force)
    write_whole(args.file, _START.read_bytes().replace(b"NAME", args.file.stem.encode()))
    write_schema(args.file)
    show(f"{args.file}: a world to begin with; `hmrsim run {args.file} --view` shows it")
    return ExitCode.DONE


def write_schema(file: Path) -> None:
    """Write the schema beside a world, unless there is one."""
    schema = file.with_name(SCHEMA)
    if not schema.exists():
        write_whole(schema, (folder("schemas") / SCHEMA).read_bytes())
