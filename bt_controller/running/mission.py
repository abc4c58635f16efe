"""A tree that runs for one robot, or for a fleet."""

from __future__ import annotations

import logging
import math
import threading
import traceback
from collections.abc import Callable, Iterable, Sequence
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Final

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_controller.core.blackboards import Board
from bt_controller.core.sim_time import simulated_time
from bt_controller.core.subtrees import action_leaves, behaviors
from bt_controller.running.schedule import POLL_SECONDS, Due, due
from bt_controller.running.snapshot import Snapshot, board_values, nodes_of
from hmrsim.errors import HmrsimError
from hmrsim.program.users_code import described
from hmrsim_zenoh.client.zenoh_connection import prepare_messages
from hmrsim_zenoh.errors import SimulatorGone, SimulatorNotFound

if TYPE_CHECKING:
    from bt_controller.coverage import TreeCoverage
    from bt_controller.loading.trees import Plan
    from hmrsim.actions import AnyAction
    from hmrsim_zenoh.client.client import Client

_log = logging.getLogger(__name__)

_MAX_AT_ONCE: Final = 10_000
"""Ticks at one instant: more than any tree needs."""

_NEVER: Final = Due(math.inf, [])

_OPEN_GOALS: Final = attrgetter("open_goals")
_WANTS_FEEDBACK: Final = attrgetter("wants_feedback")

_FLEET: Final = "fleet"
"""The name of all robots of one tree together."""


class TreeCrashed(HmrsimError):
    """A behavior raised an error; the text says which tree, which error and where."""


class Mission:
    """A tree with its blackboard, for one robot or for a fleet.

    Args:
        robot: The name of the robot, or of the fleet.
        fleet: The names of the robots of a fleet; None for a single robot.
        resume: The name under which a restarted controller finds the goals of this mission; None to start over.
        coverage: Counts the outcomes of the tree's nodes; None for no counting.

    Attributes:
        over: Whether the tree needs no further tick.
        due: When the running tree has to be ticked again, as of its last tick; never while time is unknown.

    Raises:
        TreeError: The tree can't be built.
    """

    def __init__(
        self,
        robot: str,
        plan: Plan,
        *,
        fleet: Sequence[str] | None = None,
        resume: str | None = None,
        coverage: TreeCoverage | None = None,
    ) -> None:
        self.robot = robot
        self._robots = (robot,) if fleet is None else tuple(fleet)
        self._resume = None if resume is None else f"{resume}/{robot}"
        self._board = Board()
        with self._board.in_use:
            self.root = plan.build(*self._robots)
        own = robot if fleet is None else None
        self._recorder = None if coverage is None else coverage.watch(plan.name, self.root, robot=own)
        self._successes_due = 2 if plan.confirmed else 1
        self._ticks = 0
        self._changes = 0
        self._instant: float | None = None
        self._ticks_at = 0
        self.over = False
        self.due = _NEVER
        self._stopped = False
        # A snapshot in another thread shows the tree between two ticks.
        self._ticking = threading.Lock()

    @property
    def status(self) -> Status:
        """The status of the tree's root."""
        return self.root.status

    @property
    def changed_entries(self) -> bool:
        """True if the last tick changed the blackboard, so that another tick may have another result."""
        return self._board.storage.changes != self._changes

    @property
    def open_goals(self) -> bool:
        """True if a goal of the tree has not ended."""
        return any(map(_OPEN_GOALS, action_leaves(self.root)))

    @property
    def wants_feedback(self) -> bool:
        """True if a node of the tree reads feedback that another node writes."""
        with self._board.in_use:
            return any(map(_WANTS_FEEDBACK, action_leaves(self.root)))

    @property
    def actions(self) -> dict[str, AnyAction]:
        """The actions whose messages the tree builds, by name, as far as they are known without the simulator."""
        leaves = (leaf for leaf in action_leaves(self.root) if not leaf.PLAIN)
        return {leaf.action.name: leaf.action for leaf in leaves if leaf.action is not None}

    def setup(self, client: Client, wake: Callable[[], None], **known: Any) -> None:
        """Set up all behaviors of the tree.

        Args:
            client: The connection to the simulator.
            wake: Called in any thread when the tree should be ticked.
            **known: The arguments that all trees share: *directory*, *topics*, *places*.

        Raises:
            NotServed: The simulator lacks the robot, an action or a topic.
            PortError: A port's value in the file is invalid.
        """
        for robot in self._robots:
            known["directory"].check_robot(robot)
        with self._board.in_use:
            for node in behaviors(self.root):
                node.setup(client=client, robot=self.robot, wake=wake, resume=self._resume, **known)

    def tick(self, now: float | None, period: float = POLL_SECONDS) -> None:
        """Tick the tree at a simulated time.

        Args:
            now: Simulated seconds; None while they are unknown.
            period: Simulated seconds between two polls of state that has no notification.

        Raises:
            TreeCrashed: A behavior raised an error.
            SimulatorNotFound, SimulatorGone: A behavior sent a request, and the simulator has gone.
        """
        self._ticks += 1
        self._count_at(now)
        self._changes = self._board.storage.changes
        try:
            with self._ticking, self._board.in_use, simulated_time(now):
                if self._recorder is None:
                    self.root.tick_once()
                else:
                    self._recorder.tick()
                running = self.root.status is Status.RUNNING
                # The blackboard may decide which events a node waits for.
                self.due = due(self.root, now, period) if running and now is not None else _NEVER
        except (SimulatorNotFound, SimulatorGone):
            raise
        except Exception as error:
            # The text of an HmrsimError names its subject.
            at = "" if isinstance(error, HmrsimError) else _ticked(error)
            where = f" at {at!r}" if at else ""
            raise TreeCrashed(f"the tree of {self.robot!r} broke{where}: {described_error(error)}") from error
        status = self.root.status
        if status is Status.SUCCESS:
            self._successes_due -= 1
            self.over = self._successes_due == 0
        else:
            self.over = status is not Status.RUNNING

    def _count_at(self, now: float | None) -> None:
        """Limit the ticks at one instant: a tree whose goals end at once would stop time forever."""
        if now is None or now != self._instant:
            self._instant, self._ticks_at = now, 0
        self._ticks_at += 1
        if self._ticks_at > _MAX_AT_ONCE:
            raise TreeCrashed(
                f"the tree of {self.robot!r} was ticked {_MAX_AT_ONCE} times at {now} s, so that time can't go on;"
                " it repeatedly sends goals that end at once"
            )

    def end_coverage(self) -> None:
        """Stop counting: from now on, behaviors end because the run does."""
        if self._recorder is not None:
            self._recorder.end()

    def interrupt(self, now: float | None = None) -> None:
        """Stop the tree and cancel its goals; the error of a behavior that breaks then is logged."""
        self.end_coverage()
        with self._ticking, self._board.in_use, simulated_time(now):
            self._stopped = True
            try:
                if not self.over:
                    self.root.stop(Status.INVALID)
            except Exception as error:  # noqa: BLE001 - whatever a behavior raises, the goals are canceled
                _log.error("the tree of %r broke while it was stopped: %s", self.robot, described_error(error))
            # A tree that broke may have goals that it does not track.
            self.cancel()

    def cancel(self) -> None:
        """Cancel the active goals and return at once; from any thread."""
        for leaf in action_leaves(self.root):
            leaf.cancel()

    def shutdown(self) -> None:
        """Shut down all behaviors of the tree."""
        with self._board.in_use:
            for node in behaviors(self.root):
                node.shutdown()

    def snapshot(self, sim_time: float | None, *, blackboard: bool = False) -> Snapshot:
        """Return the tree's state after its last tick; another thread waits for a tick in progress."""
        with self._ticking:
            known = board_values(self._board.storage) if blackboard else None
            return self._seen(sim_time, known)

    def glimpse(self, sim_time: float | None) -> Snapshot | None:
        """Return the tree's snapshot, or None during a tick: for callers that a behavior may call."""
        if not self._ticking.acquire(blocking=False):
            return None
        try:
            return self._seen(sim_time, None)
        finally:
            self._ticking.release()

    def _seen(self, sim_time: float | None, blackboard: dict[str, Any] | None) -> Snapshot:
        ended = self.over or self._stopped
        nodes = nodes_of(self.root, None if self._recorder is None else self._recorder.covered)
        return Snapshot(self.robot, sim_time, self._ticks, nodes, ended, blackboard)


def described_error(error: Exception) -> str:
    """Return an error as one line, with its place unless it is an `HmrsimError`."""
    return str(error) if isinstance(error, HmrsimError) else described(error)


def _ticked(error: Exception) -> str:
    """Return the name of the deepest behavior in the traceback of an error; empty if there is none."""
    name = ""
    for frame, _ in traceback.walk_tb(error.__traceback__):
        behavior = frame.f_locals.get("self")
        if isinstance(behavior, Behaviour):
            name = str(behavior.name)
    return name


def missions_for(
    robots: Sequence[str], plan: Plan, *, resume: str | None = None, coverage: TreeCoverage | None = None
) -> list[Mission]:
    """Return a mission for each robot, or one for all robots if the tree is for a fleet.

    Raises:
        TreeError: The tree can't be built.
    """
    if plan.takes_robots:
        return [Mission(_FLEET, plan, fleet=robots, resume=resume, coverage=coverage)]
    return [Mission(robot, plan, resume=resume, coverage=coverage) for robot in robots]


def prepare(missions: Iterable[Mission]) -> None:
    """Prepare the messages of the trees' actions before the run, so that no robot waits for that."""
    for action in {name: action for mission in missions for name, action in mission.actions.items()}.values():
        prepare_messages(action)
