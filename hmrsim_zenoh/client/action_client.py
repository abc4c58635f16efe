"""The client of one action of one robot."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Generic, Protocol

from hmrsim.actions import F, G, R
from hmrsim.diagnostics import shown
from hmrsim.errors import HmrsimError
from hmrsim.interfaces.message import Message
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.protocol.goal import parse_goal_id
from hmrsim_zenoh.client.connection import PATIENCE, Answer, message_of
from hmrsim_zenoh.client.goal_handle import GoalHandle
from hmrsim_zenoh.client.places import with_poses
from hmrsim_zenoh.errors import RequestError, RequestTimeout
from hmrsim_zenoh.wire.envelopes import UnreadableError

if TYPE_CHECKING:
    from hmrsim.actions import Action
    from hmrsim.interfaces.geometry_msgs import PoseStamped
    from hmrsim_zenoh.client.link import Link
    from hmrsim_zenoh.client.lockstep import Lockstep
    from hmrsim_zenoh.client.places import NamedPlaces

_log = logging.getLogger(__name__)


class Participating(Protocol):
    """The part of a `Client` that its action clients use."""

    @property
    def lockstep(self) -> Lockstep | None:
        """The client's participation in lockstep; None where simulated time moves by itself."""

    @property
    def places(self) -> NamedPlaces:
        """The waypoints, places and docks of the world by name, as of the first lookup."""


class ActionClient(Generic[G, R, F]):
    """Sends one robot goals of one action; `Client.action_client` makes it.

    Attributes:
        robot: The name of the robot.
        action: The action.
        name: The name of the action in ROS, such as ``/mocha/dock_robot``.
    """

    def __init__(self, client: Participating, link: Link, robot: str, action: Action[G, R, F]) -> None:
        self.robot = robot
        self.action = action
        self.name = f"/{robot}/{action.name}"
        self._client = client
        self._link = link
        self._lock = threading.Lock()
        self._listening: dict[str, GoalHandle[R, F]] = {}
        self._listens = False
        self._places: NamedPlaces | None = None

    def send_goal(
        self,
        goal: G | Mapping[str, Any],
        *,
        goal_id: str | None = None,
        adopt: bool = False,
        read_result: bool = True,
        on_feedback: Callable[[F], object] | None = None,
        on_change: Callable[[GoalHandle[R, F]], None] | None = None,
    ) -> GoalHandle[R, F]:
        """Send a goal and return its handle; only the client's first goal waits, for the simulator's clock mode.

        Args:
            goal: The goal as a message, or as plain values, which the simulator checks; there, a pose may be the name
                of a waypoint, place or dock, which is looked up first, or a list or tuple of x, y and optionally yaw.
            goal_id: 32 hex digits, hyphens optional; generated if not given.
            adopt: Whether to follow the existing goal of this id, if there is one, instead of failing: a client
                that was killed and restarted finds its goal. The handle is *adopted* then; its *error* is
                a `ResultExpired` if the goal ended so long ago that its result is no longer kept.
            read_result: Whether to read the result of a goal that succeeds; if not, its *result_message* is None.
            on_feedback: Called for each feedback, never after the goal is done.
            on_change: Called whenever *accepted*, *status*, *error* or *done* has changed.

        Callbacks may run before this returns, mostly in Zenoh's thread, and must not block. In lockstep the goal
        is sent with the next advance, and the thread that waits for the grant runs the callbacks.

        Raises:
            ClientClosed: The client was closed.
            Dropped: The simulator goes on without this client.
            RequestError: The simulator refuses this participant.
            ValueError: *goal_id* is not a valid goal id, or a place does not exist.
            SimulatorNotFound, SimulatorGone, Unreachable, RequestTimeout: The lookup of a place has no answer.
            TypeError: *goal* is of another action.
        """
        handle = self._handle(self._client.lockstep, goal, goal_id, on_feedback, on_change)
        handle.start(adopt=adopt, read_result=read_result)
        return handle

    def execute(
        self,
        goal: G | Mapping[str, Any],
        *,
        goal_id: str | None = None,
        read_result: bool = True,
        on_feedback: Callable[[F], object] | None = None,
        on_change: Callable[[GoalHandle[R, F]], None] | None = None,
    ) -> GoalHandle[R, F]:
        """Send a goal as `send_goal` does, in one query instead of two, and return its handle.

        For a goal that ends at once, that takes three quarters of the time. If a robot's own server does not support
        `execute`, the goal is sent as by `send_goal`. In lockstep there is no difference.

        Raises:
            ClientClosed, Dropped, RequestError, ValueError, TypeError: As `send_goal`.
        """
        lockstep = self._client.lockstep
        handle = self._handle(lockstep, goal, goal_id, on_feedback, on_change)
        handle.start(read_result=read_result, execute=lockstep is None)
        return handle

    def _handle(
        self,
        lockstep: Lockstep | None,
        goal: G | Mapping[str, Any],
        goal_id: str | None,
        on_feedback: Callable[[F], object] | None,
        on_change: Callable[[GoalHandle[R, F]], None] | None,
    ) -> GoalHandle[R, F]:
        """Return a goal's handle, which is to be started."""
        # Plain values become a message where they enter the simulator.
        sent: Any = goal
        if not isinstance(goal, self.action.goal):
            if not isinstance(goal, Mapping):
                # A message is long.
                got = goal.ros_type if isinstance(goal, Message) else shown(goal)
                raise TypeError(f"{self.action.name} takes {self.action.goal.ros_type}, got {got}")
            sent = with_poses(goal, self.action.goal, self._pose_of)
        wanted_id = None if goal_id is None else parse_goal_id(goal_id)
        next_id = (lockstep or self._link).next_goal_id()
        handle: GoalHandle[R, F] = GoalHandle(
            self._link,
            lockstep,
            self,
            SendGoal(self.robot, self.action.name, sent, wanted_id or next_id),
            on_feedback=on_feedback,
            on_change=on_change,
            on_done=self._forget,
        )
        self._link.enter(handle.fail)
        if on_feedback is not None:
            self._listen(handle, lockstep)
        return handle

    def _pose_of(self, place: str) -> PoseStamped:
        if self._places is None:
            self._places = self._client.places
        return self._places.pose(place)

    def cancel_all(self) -> None:
        """Cancel all goals of the action, also those of other clients, and wait for the answer.

        In lockstep it returns at once; the request goes with the next advance, after goals that were sent before.

        Raises:
            ClientClosed: The client was closed.
            SimulatorNotFound, SimulatorGone: No simulator is there.
            Dropped: The simulator goes on without this client.
            RequestError: The simulator answers with an error, or refuses this participant.
            RequestTimeout: The simulator does not answer.
        """
        self._link.check_open()
        lockstep = self._client.lockstep
        all_goals = CancelGoal(self.robot, self.action.name)
        if lockstep is not None:
            lockstep.send(self, all_goals, self._on_cancel_answer, timeout=PATIENCE)
            return
        self._link.follow()
        answers = SimpleQueue[Answer]()
        self._link.connection.send(self, all_goals, answers.put, timeout=PATIENCE)
        try:
            answer = answers.get(timeout=PATIENCE)
        except Empty:
            answer = None
        if isinstance(answer, HmrsimError):
            raise answer
        if answer is None:
            raise self._link.absence() or RequestTimeout(f"{self.name}: no answer to a cancel")

    def _on_cancel_answer(self, answer: Answer) -> None:
        if isinstance(answer, RequestError):
            _log.warning("%s: goals can't be canceled: %s", self.name, answer)

    def _forget(self, handle: GoalHandle[R, F]) -> None:
        self._link.leave(handle.fail)
        if self._listening:
            self._listening.pop(handle.goal_id, None)

    def _listen(self, handle: GoalHandle[R, F], lockstep: Lockstep | None) -> None:
        self._listening[handle.goal_id] = handle
        with self._lock:
            if not self._listens:
                (lockstep or self._link.connection).listen(self)
                self._listens = True

    @property
    def wanted(self) -> bool:
        """Return whether there is a goal whose feedback matters."""
        return bool(self._listening)

    def take(self, goal_id: str, feedback: Message | Mapping[str, Any]) -> None:
        """Take a sample of feedback."""
        if handle := self._listening.get(goal_id):
            try:
                handle.take_feedback(message_of(self.action.feedback, feedback))
            except UnreadableError as error:
                _log.warning("%s: feedback that can't be read: %s", self.name, error)
