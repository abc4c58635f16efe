"""``hmrsim experiment``: many runs of one world, with what is varied, measured and compared."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.program.command_line import Later, add_commands

if TYPE_CHECKING:
    from hmrsim.program.command_line import LazyParser

_COMMANDS: Final = {
    "check": "list everything that is wrong with an experiment, without running it",
    "run": "make the runs of an experiment; goes on where it stopped",
    "status": "show how far an experiment is",
    "show": "show the results of an experiment, or of one run",
    "report": "write the results as one page",
    "export": "write the table of runs as CSV, JSON or Parquet",
    "again": "repeat one run, with a trace or a report",
}
"""Each is a module ``experiment_…`` with a function *configure*, which adds arguments to the command's parser."""

_EXAMPLES: Final = """\
examples:
  hmrsim experiment check delivery.yaml
  hmrsim experiment run delivery.yaml -o results && hmrsim experiment report results -o results.html
  hmrsim experiment show results
  hmrsim experiment again results 17 --trace run_17.jsonl"""


def configure(parser: LazyParser) -> None:
    """Add the commands of ``hmrsim experiment``."""
    parser.description = "Run a world many times, with different settings and controllers, and say what came of it."
    parser.epilog = _EXAMPLES
    add_commands(parser, {name: (text, Later(f"{__name__}_{name}", "configure")) for name, text in _COMMANDS.items()})
