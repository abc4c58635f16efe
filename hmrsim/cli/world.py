"""``hmrsim world``: the worlds that are shipped, and new ones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.program.command_line import Later, add_commands

if TYPE_CHECKING:
    from hmrsim.program.command_line import LazyParser

_COMMANDS: Final = {
    "list": "list the worlds that are shipped",
    "new": "write a commented world to begin with",
    "generate": "write a small random fleet with orders",
    "schema": "print the schema of world files, for editors",
}
"""Each is a module ``world_…`` with a function *configure*, which adds arguments to the command's parser."""

_EXAMPLES: Final = """\
examples:
  hmrsim world list
  hmrsim world new my_world.yaml && hmrsim run my_world.yaml
  hmrsim world generate fleet.yaml --seed 7
  hmrsim world schema > world.schema.json"""


def configure(parser: LazyParser) -> None:
    """Add the commands of ``hmrsim world``."""
    parser.description = "List the worlds that are shipped, write new ones, and print the schema of world files."
    parser.epilog = _EXAMPLES
    add_commands(parser, {name: (text, Later(f"{__name__}_{name}", "configure")) for name, text in _COMMANDS.items()})
