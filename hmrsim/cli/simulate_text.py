"""The results of scripts, for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hmrsim.cli.output import show
from hmrsim.diagnostics import shown
from hmrsim.simulation.scripts import ScriptState

if TYPE_CHECKING:
    from hmrsim.simulation.scripts import Script

_MIN_WALL_TIME: Final = 1e-6
"""Minimum wall seconds that are assumed, to avoid a division by zero."""
_COLOURS: Final = {ScriptState.DONE: "green", ScriptState.RUNNING: "yellow", ScriptState.FAILED: "red"}


def show_summary(summary: dict[str, Any], scripts: list[Script]) -> None:
    """Print the summary as text: one line per robot, then the totals."""
    if scripts:
        table = Table("robot", "orders", "state", "ended at", "why", box=None, pad_edge=False)
        for script in scripts:
            ended = "" if script.ended is None else f"{script.ended:.3f} s"
            state = Text(script.state.value, _COLOURS[script.state])
            table.add_row(script.robot, f"{script.done}/{len(script.orders)}", state, ended, Text(_remark(script)))
        Console(width=None if Console().is_terminal else 200).print(table)
    done = sum(script.state is ScriptState.DONE for script in scripts)
    goals = ", ".join(f"{number} {status}" for status, number in summary["goals"].items()) or "none"
    factor = summary["sim_time"] / max(summary["wall_time"], _MIN_WALL_TIME)
    show(f"{done} of {len(scripts)} scripts done; goals: {goals}")
    show(
        f"{summary['sim_time']:.3f} simulated seconds in {summary['wall_time']:.3f} wall seconds,"
        f" {factor:,.0f} times real time"
    )


def _remark(script: Script) -> str:
    return f"at {shown(script.orders[script.done].text)}" if script.state is ScriptState.RUNNING else script.error
