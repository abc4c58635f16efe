"""``hmrsim map``: the commands for world files, each loaded when it is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.program.command_line import Later, add_commands

if TYPE_CHECKING:
    from hmrsim.program.command_line import LazyParser

_COMMANDS: Final = {
    "validate": "list everything that is wrong with a world file",
    "info": "show the contents of a world file",
    "plan": "print the route between two points, and its travel time",
    "convert": "write a world in another format",
    "render": "draw a world as SVG or PNG",
}
"""Each is a module ``map_…`` with a function *configure*, which adds arguments to the command's parser."""

_EXAMPLES: Final = """\
examples:
  hmrsim map validate my_world.yaml && hmrsim run my_world.yaml
  hmrsim map info hospital
  hmrsim map plan hospital wall_e pharmacy
  hmrsim map convert drawing.drawio my_world.yaml
  hmrsim map render hospital -o hospital.svg"""


def configure(parser: LazyParser) -> None:
    """Add the commands of ``hmrsim map``."""
    parser.description = "Check, inspect, convert and draw world files; plan routes on them."
    parser.epilog = _EXAMPLES
    add_commands(parser, {name: (text, Later(f"{__name__}_{name}", "configure")) for name, text in _COMMANDS.items()})
