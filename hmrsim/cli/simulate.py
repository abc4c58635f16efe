"""``hmrsim simulate``: run the robots' own scripts in virtual time, without any network."""

from __future__ import annotations

import argparse
import logging
import time
from shlex import quote
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, add_json, add_world_options
from hmrsim.cli.output import show, show_json, show_table, warn
from hmrsim.program.files import check_outputs
from hmrsim.program.log_options import add_log_options, log_level, logging_to_stderr
from hmrsim.settings.arguments import add_settings, read_settings
from hmrsim.settings.run import SimulateSettings, TraceSettings

if TYPE_CHECKING:
    from hmrsim.simulation.scripts import Script

_MIN_WALL_TIME: Final = 1e-6
"""Minimum wall seconds, to avoid a division by zero."""
_COLORS: Final = {"done": "green", "running": "yellow", "failed": "red"}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim simulate``."""
    parser.description = (
        "Run the robots' own scripts in virtual time to their end, as fast as possible and without any network,\n"
        "and print the results."
    )
    parser.epilog = """\
exit codes: 0 every script was finished; 1 one failed, or was not finished by --duration; 2 the world can't be read;
130 Ctrl-C

examples:
  hmrsim simulate warehouse
  hmrsim simulate warehouse --log-level info 2>goals.log
  hmrsim simulate warehouse --seed 3 --trace run.jsonl && hmrsim replay run.jsonl
  hmrsim simulate my_map.drawio --duration 600 --json | jq .robots"""
    add_world_options(parser)
    add_settings(parser, SimulateSettings, only=("seed", "duration", "strict"))
    add_settings(parser, TraceSettings)
    add_json(parser, "print the summary as one JSON object")
    add_log_options(parser)
    parser.set_defaults(function=_simulate)


def _simulate(args: argparse.Namespace) -> int:
    from hmrsim import plugins
    from hmrsim.cli.event_log import EventLog, GoalCounter
    from hmrsim.cli.replay import TraceFile
    from hmrsim.cli.worlds import policy_line, read_world, show_warnings
    from hmrsim.program.memory import collect_rarely
    from hmrsim.simulation.scripts import ScriptState
    from hmrsim.simulation.simulator import Simulator

    loaded = read_world(args)
    show_warnings(loaded)
    settings = read_settings(args, SimulateSettings)
    path = read_settings(args, TraceSettings).trace
    check_outputs([("--trace", path)], loaded.files)
    trace = TraceFile(path, loaded.world, settings)
    counter = GoalCounter()
    logs = [EventLog()] if log_level(args) <= logging.INFO else []
    simulator = Simulator(loaded.world, settings, [counter, *logs, *trace.sinks])
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
        warn(
            f"{loaded.path}: no robot has a script, so nothing was done; give a robot a `script`, such as "
            f"[Go kitchen, Wait 5], or drive it yourself with `hmrsim run {quote(args.world)}`"
        )
    summary = {
        "seed": simulator.seed,
        "sim_time": simulator.now,
        "wall_time": wall_time,
        "goals": dict(sorted(counter.statuses.items())),
        "robots": [{**script.event().to_json(), "ended": script.ended} for script in scripts],
    }
    if args.json:
        show_json({"world": {"name": loaded.world.name, "hash": loaded.hash}, **summary})
    else:
        _show_summary(summary, list(scripts))
    return ExitCode.DONE if all(script.state is ScriptState.DONE for script in scripts) else ExitCode.FAILED


def _show_summary(summary: dict[str, Any], scripts: list[Script]) -> None:
    from rich.text import Text

    if scripts:
        rows = []
        for script in scripts:
            ended = "" if script.ended is None else f"{script.ended:.3f} s"
            state = Text(script.state.value, _COLORS[script.state.value])
            rows.append((script.robot, f"{script.done}/{len(script.orders)}", state, ended, _remark(script)))
        headings = ("robot", "orders", "state", "ended at", "why")
        show_table(headings, rows, left=headings)
    done = sum(script.state.value == "done" for script in scripts)
    goals = ", ".join(f"{number} {status}" for status, number in summary["goals"].items()) or "none"
    factor = summary["sim_time"] / max(summary["wall_time"], _MIN_WALL_TIME)
    show(f"{done} of {len(scripts)} scripts done; goals: {goals}")
    show(
        f"{summary['sim_time']:.3f} simulated seconds in {summary['wall_time']:.3f} wall seconds,"
        f" {factor:,.0f} times real time"
    )


def _remark(script: Script) -> str:
    from hmrsim.diagnostics import shown

    return f"at {shown(script.orders[script.done].text)}" if script.state.value == "running" else script.error
