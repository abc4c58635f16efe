"""``hmrsim demo``: a fleet at work in the hospital, simulator and controller as processes of their own."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.program.command_line import Later
from hmrsim.program.log_options import add_log_options
from hmrsim.settings.arguments import add_settings
from hmrsim.settings.run import DemoSettings, TraceSettings, WorldSettings
from hmrsim_zenoh.settings import RecordSettings, ViewSettings
from hmrsim_zenoh.wire.options import SessionOptions

_EXAMPLES: Final = """\
examples:
  hmrsim demo
  hmrsim demo --real-time-factor 2 --seed 3
  hmrsim demo --real-time-factor 1 --view
  hmrsim demo --set robots.*.base.speed=0.5
  hmrsim demo --clock lockstep --trace run.jsonl && hmrsim replay run.jsonl
  hmrsim demo --clock lockstep --record demo.mcap && hmrsim view demo.mcap
  hmrsim demo --log-level info 2>processes.log
  hmrsim demo --json | tail -n 1 | jq '.robots.eve.distance'"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim demo``."""
    parser.description = (
        "Run a mission of a fleet in a hospital: a simulator and a controller with behaviour trees, two processes\n"
        "that communicate over Zenoh. Prints events as they happen, and a summary at the end."
    )
    parser.epilog = _EXAMPLES
    add_settings(parser, DemoSettings, only=("seed", "clock", "real_time_factor"))
    add_settings(parser, TraceSettings)
    add_settings(parser, RecordSettings)
    add_settings(parser, WorldSettings, only=("overlay", "set"))
    add_settings(parser, ViewSettings)
    add_settings(parser, SessionOptions, only=("secure",))
    parser.add_argument(
        "--json", action="store_true", help="print each event, and the summary at the end, as one JSON object per line"
    )
    add_log_options(parser)
    parser.set_defaults(function=Later("hmrsim.cli.demo_processes", "demo"))
