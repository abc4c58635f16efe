"""A run as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim_gym.dispatching import Dispatching
    from hmrsim_gym.setting import Setting


def rendered(setting: Setting, run: Dispatching) -> str:
    """Return a line for the time, one for each robot and one for each order that nobody serves."""
    totals = run.demand.totals
    lines = [f"{run.now:9.3f} s: {totals.placed} orders, {totals.delivered} delivered, {totals.late} late"]
    for robot in setting.robots:
        order, (x, y) = run.serving.get(robot), run.truth.point(robot)
        what = f" {order.name}" if order else ""
        lines.append(f"  {robot} at ({x:.1f}, {y:.1f}) {run.doing(robot)}{what}")
    for order in run.free:
        due = "" if order.due is None else f", due at {order.due:.0f} s"
        lines.append(f"  {order.name} from {order.at} to {order.to}{due}")
    return "\n".join(lines)
