"""What ``hmrsim simulate`` does: it runs the robots' own scripts to their end."""

from __future__ import annotations

import argparse
import logging
import time
from collections import Counter
from typing import TYPE_CHECKING

from hmrsim import plugins
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show_json, warn
from hmrsim.cli.run_log import EventLog
from hmrsim.cli.tracing import TraceFile
from hmrsim.cli.worlds import policy_line, read_world, show_warnings
from hmrsim.program.garbage import collect_rarely
from hmrsim.program.log_options import log_level, logging_to_stderr
from hmrsim.program.outputs import check_outputs
from hmrsim.protocol.outputs import GoalChanged
from hmrsim.settings.arguments import read_settings
from hmrsim.settings.run import SimulateSettings, TraceSettings
from hmrsim.simulation.scripts import ScriptState
from hmrsim.simulation.simulator import Simulator

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Topic


class _Tally:
    """A sink that counts how goals ended."""

    def __init__(self) -> None:
        self.statuses: Counter[str] = Counter()

    def wants(self, _topic: Topic) -> bool:
        """Return False: ends of goals are delivered without it."""
        return False

    def emit(self, output: Output) -> None:
        """Count a goal that has ended."""
        if isinstance(output, GoalChanged) and output.status.terminal:
            self.statuses[output.status.name] += 1


def simulate(args: argparse.Namespace) -> int:
    """Run the scripts and print how they went; return the exit code."""
    loaded = read_world(args)
    show_warnings(loaded)
    settings = read_settings(args, SimulateSettings)
    path = read_settings(args, TraceSettings).trace
    check_outputs([("--trace", path)], loaded.files)
    trace = TraceFile(path, loaded.world, settings)
    tally = _Tally()
    logs = [EventLog()] if log_level(args) <= logging.INFO else []
    simulator = Simulator(loaded.world, settings, [tally, *logs, *trace.sinks])
    if settings.strict:
        plugins.check()
    if policy := policy_line(loaded.world):
        warn(policy)
    collect_rarely()
    began = time.perf_counter()
    with logging_to_stderr(args), trace.opened(simulator):
        simulator.run_scripts(settings.duration)
    wall_time = time.perf_counter() - began
    scripts = simulator.scripts.all.values()
    if not scripts:
        warn(f"{loaded.path}: no robot has a script, so nothing was done; see `script` in a world file")
    summary = {
        "seed": simulator.seed,
        "sim_time": simulator.now,
        "wall_time": wall_time,
        "goals": dict(sorted(tally.statuses.items())),
        "robots": [{**script.event().to_json(), "ended": script.ended} for script in scripts],
    }
    if args.json:
        show_json({"world": {"name": loaded.world.name, "hash": loaded.hash}, **summary})
    else:
        # Loads rich, which takes 60 ms and is needed for text output only.
        from hmrsim.cli.simulate_text import show_summary  # noqa: PLC0415

        show_summary(summary, list(scripts))
    return ExitCode.DONE if all(script.state is ScriptState.DONE for script in scripts) else ExitCode.FAILED
