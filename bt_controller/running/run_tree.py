"""A tree that is run for some robots by a client, to its end: what a program needs that makes its own client."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from bt_controller.running.clocks import clock_for
from bt_controller.running.mailbox import Mailbox
from bt_controller.running.mission import missions_for
from bt_controller.running.runner import Runner

if TYPE_CHECKING:
    from bt_controller.coverage import TreeCoverage
    from bt_controller.loading.trees import Plan
    from bt_controller.running.mission import Mission
    from bt_controller.running.runner import Outcome
    from hmrsim_zenoh.client.client import Client

_GRACE = 3.0
"""Wall seconds for which the simulator may be out of reach, and within which canceled goals have to end."""


def run_tree(
    client: Client,
    plan: Plan,
    robots: Sequence[str],
    *,
    period: float | None = None,
    show: Callable[[Mission, float | None], None] | None = None,
    coverage: TreeCoverage | None = None,
) -> Outcome:
    """Run a tree for each of some robots, or for all of them if it is one for all; return how that ended.

    Args:
        client: The connection to the simulator; stays open.
        plan: The tree, as `bt_controller.loading.trees.load` finds it.
        robots: The names of the robots.
        period: Simulated seconds between ticks of every tree; None to tick where it is needed only.
        show: Called after each tick of a tree with its mission and the simulated time, or None.
        coverage: Where to count what happens to the nodes of the trees, if anywhere.

    Raises:
        TreeError: The tree can't be built.
        NotServed: The simulator lacks a robot or an action.
        SimulatorNotFound, SimulatorGone, Unreachable: No simulator answers.
        TreeCrashed: A behavior raised an error.
        Idle: A tree waits for what can't happen.
        Dropped: The simulator goes on without this client.
    """
    missions = missions_for(robots, plan, coverage=coverage)
    feedback = period is not None or any(mission.wants_feedback for mission in missions)
    mailbox = Mailbox()
    clock = clock_for(client, mailbox, feedback=feedback, grace=_GRACE)
    return Runner(client, missions, clock, mailbox, show=show, period=period, grace=_GRACE).run()
