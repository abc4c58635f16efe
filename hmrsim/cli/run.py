"""``hmrsim run``: serve a world until Ctrl-C, SIGTERM or the end of its time."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.cli.options import add_world_argument
from hmrsim.program.command_line import Later
from hmrsim.settings.arguments import add_settings
from hmrsim_zenoh.settings import SERVED
from hmrsim_zenoh.wire.options import ENVIRONMENT

_EXAMPLES: Final = f"""\
examples:
  hmrsim run scenario1
  hmrsim run hospital --real-time-factor 10 --seed 3
  hmrsim run hospital --clock lockstep --participants nurses,porters --trace run.jsonl
  hmrsim run hospital --settings lockstep.yaml --seed 3
  hmrsim run my_map.yaml --robot wall_e@3,4:fetcher --item medicine@9,2.3:0.2
  hmrsim run hospital --secure keys --listen tls/0.0.0.0:7447
  hmrsim run hospital --listen tcp/127.0.0.1:7450 --duration 600 --json
  hmrsim run scenario1 --view
  hmrsim run hospital --monitor properties.yaml
  hmrsim run scenario1 --ros2
  hmrsim run hospital --ros2 --ros-domain-id 7 --ros-distro jazzy --ros-distro kilted

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim run``."""
    parser.description = (
        "Serve a world over Zenoh until Ctrl-C. Prints `ready ENDPOINT …` once clients can connect; a table of the\n"
        "robots (on a terminal) or a log goes to stderr."
    )
    parser.epilog = _EXAMPLES
    add_world_argument(parser)
    for model in SERVED:
        add_settings(parser, model)
    parser.add_argument(
        "--settings",
        type=Path,
        metavar="FILE",
        help="a settings file, YAML or JSON; options and environment variables override it",
    )
    parser.add_argument("--json", action="store_true", help="print that it is ready as one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.run_world", "run"))
