"""One tree that is run for one robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from py_trees.common import Status

from bt_controller.action_leaf import ActionLeaf
from bt_controller.blackboards import Board
from bt_controller.snapshot import Snapshot, nodes_of
from bt_controller.tree_time import simulated_time
from bt_controller.trees import described
from hmrsim.errors import HmrsimError
from hmrsim_zenoh.preparation import for_client

if TYPE_CHECKING:
    from collections.abc import Callable

    from bt_controller.trees import Plan
    from hmrsim_zenoh.client import Client


class TreeCrashed(HmrsimError):
    """A behaviour raised an error; the text says which tree, which error and where."""


class Mission:
    """A robot, its tree and its blackboard.

    Args:
        robot: The robot's name.
        plan: How its tree is built.

    Raises:
        TreeError: The tree can't be built.
    """

    def __init__(self, robot: str, plan: Plan) -> None:
        self.robot = robot
        self._board = Board()
        with self._board.in_use():
            self.root = plan.build(robot)
        self._successes_due = 2 if plan.confirmed else 1
        self._ticks = 0
        self._over = False

    @property
    def over(self) -> bool:
        """Whether the tree needs no further tick."""
        return self._over

    @property
    def status(self) -> Status:
        """The root's status."""
        return self.root.status

    @property
    def open_goals(self) -> bool:
        """Whether a goal of the tree is still under way."""
        return any(leaf.open_goals for leaf in self._leaves())

    def prepare(self) -> None:
        """Be ready for the actions of the tree, before anybody waits for it."""
        for action in {leaf.action.name: leaf.action for leaf in self._leaves() if leaf.action is not None}.values():
            for_client(action)

    def setup(self, client: Client, wake: Callable[[], None], **known: Any) -> None:
        """Set up all behaviours.

        Args:
            client: The connection to the simulator.
            wake: Called in any thread when the tree should be ticked.
            **known: What all trees share: *directory*, *topics*, *places*.

        Raises:
            NotServed: The simulator lacks the robot, an action or a topic.
            PortError: What the file says is not what a port takes.
        """
        known["directory"].check_robot(self.robot)
        with self._board.in_use():
            for node in self.root.iterate():
                node.setup(client=client, robot=self.robot, wake=wake, **known)

    def tick(self, now: float | None) -> None:
        """Tick the tree at a simulated time.

        Raises:
            TreeCrashed: A behaviour raised an error.
        """
        self._ticks += 1
        try:
            with self._board.in_use(), simulated_time(now):
                self.root.tick_once()
        except HmrsimError as error:
            raise TreeCrashed(f"the tree of {self.robot!r} broke: {error}") from error
        except Exception as error:
            raise TreeCrashed(f"the tree of {self.robot!r} broke: {described(error)}") from error
        if self.status is Status.SUCCESS:
            self._successes_due -= 1
            self._over = self._successes_due == 0
        else:
            self._over = self.status is not Status.RUNNING

    def interrupt(self) -> None:
        """Stop the tree where it is, and cancel its goals."""
        with self._board.in_use():
            if not self._over:
                self.root.stop(Status.INVALID)
            # A tree that broke within a tick does not know of all that it has begun.
            self.cancel()

    def cancel(self) -> None:
        """Cancel the goals that are under way; from any thread, returns at once."""
        for leaf in self._leaves():
            leaf.cancel()

    def shutdown(self) -> None:
        """Let the behaviours put away what they set up."""
        with self._board.in_use():
            for node in self.root.iterate():
                node.shutdown()

    def snapshot(self, sim_time: float | None) -> Snapshot:
        """Return what the tree looks like now."""
        return Snapshot(self.robot, sim_time, self._ticks, nodes_of(self.root))

    def _leaves(self) -> list[ActionLeaf[Any, Any, Any]]:
        return [node for node in self.root.iterate() if isinstance(node, ActionLeaf)]
