"""The episodes of an environment: a run at a time, the costs of its orders, and the run as text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.program.memory import collect_run
from hmrsim_gym.dispatching import Dispatching
from hmrsim_gym.observations import Observer

if TYPE_CHECKING:
    from hmrsim.simulation.demand import Demand, Order
    from hmrsim_gym.setting import Setting

LATE: Final = 4.0
"""The additional cost of a minute in which an order is late."""

_MINUTE: Final = 60.0


class Episodes:
    """Runs the episodes of an environment, one at a time.

    Args:
        render_mode: ``ansi`` for a text, or None.

    Attributes:
        run: The run of the current episode; None before the first episode and after `end`.
        observer: Makes observations of runs.

    Raises:
        ValueError: The render mode is not supported.
    """

    def __init__(self, setting: Setting, render_mode: str | None) -> None:
        if render_mode not in {None, "ansi"}:
            raise ValueError(f"render_mode must be None or 'ansi', got {render_mode!r}")
        self.run: Dispatching | None = None
        self.observer = Observer(setting)
        self._setting = setting
        self._rewarded = 0.0
        self._renders = render_mode is not None

    def begin(self, seed: int) -> Dispatching:
        """End the current episode; return the run of a new one at its first decision."""
        self.end()
        run = self.run = Dispatching(self._setting, seed)
        self._rewarded = 0.0
        self.run_on(run)
        return run

    def run_on(self, run: Dispatching) -> float:
        """Advance time to the next decision, and return the reward for that time."""
        run.run_on()
        since, self._rewarded = self._rewarded, run.now
        return -cost(run.demand, since, run.now)

    def render(self) -> str | None:
        """Return the time, the state of each robot and the orders that are free; None without a render mode."""
        return rendered(self._setting, self.run) if self._renders and self.run is not None else None

    def end(self) -> None:
        """End the current episode, if there is one."""
        if self.run is not None:
            self.run.close()
            self.run = None
            collect_run()


def cost(demand: Demand, since: float, now: float) -> float:
    """Return the cost of orders between a time and now, in simulated seconds.

    An open order costs its weight for each minute, plus `LATE` times its weight for each minute that it is late. Its
    weight is 1 plus its priority, if that is positive.
    """
    if now <= since:
        return 0.0
    costs = [_cost(order, since, now) for order in demand.open.values()]
    for order in reversed(demand.closed):
        if order.ended is None or order.ended <= since:
            break
        costs.append(_cost(order, since, order.ended))
    return sum(costs)


def _cost(order: Order, since: float, until: float) -> float:
    """Return the cost of an order between two times, at the end of which it is still open."""
    seconds = until - max(since, order.placed)
    if order.due is not None:
        seconds += LATE * max(0.0, until - max(since, order.due))
    return (1.0 + max(order.priority, 0)) * seconds / _MINUTE


def rendered(setting: Setting, run: Dispatching) -> str:
    """Return a line for the time, one for each robot and one for each free order."""
    totals = run.demand.totals
    lines = [f"{run.now:9.3f} s: {totals.placed} orders, {totals.delivered} delivered, {totals.late} late"]
    for robot in setting.robots:
        order, (x, y) = run.serving.get(robot), run.truth.point(robot)
        served = f" {order.name}" if order else ""
        lines.append(f"  {robot} at ({x:.1f}, {y:.1f}) {run.doing(robot)}{served}")
    for order in run.free:
        due = "" if order.due is None else f", due at {order.due:.0f} s"
        lines.append(f"  {order.name} from {order.at} to {order.to}{due}")
    return "\n".join(lines)
