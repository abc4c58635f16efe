"""``hmrsim simulate``: the robots' own scripts in virtual time, without any network."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.cli.world_options import add_world_options
from hmrsim.program.command_line import Later
from hmrsim.program.log_options import add_log_options
from hmrsim.settings.arguments import add_settings
from hmrsim.settings.run import SimulateSettings, TraceSettings

_EXAMPLES: Final = """\
exit codes: 0 every script was finished; 1 one failed, or was not finished by --duration; 2 the world can't be read;
130 Ctrl-C

examples:
  hmrsim simulate warehouse
  hmrsim simulate warehouse --log-level info 2>goals.log
  hmrsim simulate warehouse --seed 3 --trace run.jsonl && hmrsim replay run.jsonl
  hmrsim simulate my_map.drawio --duration 600 --json | jq .robots"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim simulate``."""
    parser.description = (
        "Run the robots' own scripts in virtual time to their end, as fast as possible and without any network,\n"
        "and print the results."
    )
    parser.epilog = _EXAMPLES
    add_world_options(parser)
    add_settings(parser, SimulateSettings, only=("seed", "duration", "strict"))
    add_settings(parser, TraceSettings)
    parser.add_argument("--json", action="store_true", help="print the summary as one JSON object")
    add_log_options(parser)
    parser.set_defaults(function=Later("hmrsim.cli.simulate_scripts", "simulate"))
