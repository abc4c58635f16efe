"""A leaf for any action, with the lifecycle that py_trees documents.

::

    setup        looks up the action once: a robot that lacks it is an error before the first tick
    initialise   sends the goal without waiting
    update       RUNNING until the goal is done; SUCCEEDED → SUCCESS, any other end → FAILURE with a message
    terminate    INVALID cancels the goal, also before its acceptance is known
    suspend      cancels the goal; the next tick sends it again unless it was done nevertheless
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeAlias, TypeVar

from py_trees.common import Access, Status
from pydantic import ValidationError
from pydantic_core import to_json

from bt_controller.core.node import QuietBehaviour
from bt_controller.core.resume import Resumption, place_of
from bt_controller.core.robots import Directory, NotServed
from bt_controller.errors import TreeError
from hmrsim.actions import Action, F, G, R, error_of, registry
from hmrsim.diagnostics import known_name
from hmrsim.errors import GoalRejected, HmrsimError
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.program.users_code import field_errors
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.places import with_poses
from hmrsim_zenoh.errors import ResultExpired

if TYPE_CHECKING:
    from hmrsim.interfaces.geometry_msgs import PoseStamped
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.action_client import ActionClient
    from hmrsim_zenoh.client.goal_handle import GoalHandle

T = TypeVar("T")

GoalSource: TypeAlias = T | Callable[[], T | None] | str
"""A goal, a function that returns a goal or None, or the goal's blackboard key."""


class ActionLeaf(QuietBehaviour, Generic[G, R, F]):
    """Sends one goal and follows it.

    Args:
        action: The action, its name, its full name ``robot/action`` or an alias of that, as the world has it.
        goal: The goal, evaluated upon each initialise. A leaf without a goal fails. In plain values a pose may be the
            name of a place: ``{"pose": "kitchen"}``.
        robot: The robot that serves the action; None for the one that the tree is run for.
        describe: Formats feedback as the feedback message; None for its plain fields.
        on_success: Values to write on the blackboard when the goal has succeeded, by key.

    Attributes:
        verdicts: The number of goals whose end counted.

    Raises:
        ValueError: There is no action of this name.
    """

    PLAIN: ClassVar[bool] = False
    """Whether goals are given in plain values, and the results of those that succeed are not read.

    For large messages, which need not be built then.
    """

    def __init__(
        self,
        name: str,
        action: Action[G, R, F] | str,
        goal: GoalSource[G],
        *,
        robot: str | None = None,
        describe: Callable[[F], str] | None = None,
        on_success: Mapping[str, object] | None = None,
    ) -> None:
        super().__init__(name)
        self._action = _named(action) if isinstance(action, str) and "/" not in action else action
        self._goal = goal
        self._robot = robot
        self._describe = describe or _plain_fields
        self._on_success = dict(on_success or {})
        self._client: ActionClient[G, R, F] | None = None
        self._place_pose: Callable[[str], PoseStamped] | None = None
        self._handle: GoalHandle[R, F] | None = None
        self._open: list[GoalHandle[R, F]] = []
        self._sent: G | None = None
        self._suspended = False
        self.verdicts = 0
        self._resumption: Resumption | None = None
        self._wake: Callable[[], None] = _do_nothing
        if self._on_success or isinstance(goal, str):
            self._blackboard = self.attach_blackboard_client()
            for key in self._on_success:
                self._blackboard.register_key(key, Access.WRITE)
            if isinstance(goal, str):
                self._blackboard.register_key(goal, Access.READ)

    @property
    def action(self) -> Action[G, R, F] | None:
        """The action, where it is known without asking the simulator."""
        return None if isinstance(self._action, str) else self._action

    @property
    def handle(self) -> GoalHandle[R, F] | None:
        """The handle of the latest goal; None before the first one, and if it could not be sent."""
        return self._handle

    @property
    def open_goals(self) -> list[GoalHandle[R, F]]:
        """The goals that are not done; more than one while a canceled goal has not ended."""
        if self._open:
            self._open = [handle for handle in self._open if not handle.done]
        return self._open

    @property
    def wants_feedback(self) -> bool:
        """True if a node of the tree reads the feedback that this leaf writes."""
        return False

    @property
    def is_unfinished(self) -> bool:
        """True if the leaf was suspended and has to send its goal again."""
        return self._suspended and self._handle is not None and self._is_undone(self._handle)

    def setup(self, **kwargs: Any) -> None:
        """Look up the action and the places in the goal.

        Args:
            **kwargs: *client*, a `hmrsim_zenoh.client.client.Client`; *robot*, that of the tree; *directory*,
                what the simulator serves (asked for if left out); *places*, those of the world by name; *wake*, called
                from any thread when the leaf should be ticked; *resume*, under which name goals are found again in the
                next life of the controller (not at all if left out).

        Raises:
            NotServed: There is no such robot, it has no such action, or the goal names a place that does not exist.
            TreeError: The goal has other fields than the action's.
            SimulatorNotFound: No simulator answers.
        """
        client = kwargs["client"]
        directory = kwargs.get("directory") or Directory.from_info(client.info())
        wanted = self._action if isinstance(self._action, str) else self._action.name
        robot, name = directory.resolve(self._robot or kwargs["robot"], wanted)
        action = _named(name) if isinstance(self._action, str) else self._action
        self._client = client.action_client(robot, action)
        self._wake = kwargs.get("wake") or _do_nothing
        self._place_pose = kwargs["places"].pose if kwargs.get("places") is not None else None
        if not callable(self._goal) and isinstance(self._goal, Mapping):
            try:
                self._checked(self._goal)
            except ValidationError as error:
                mistakes = "\n".join(f"{self.name!r}: goal: {each}" for each in field_errors(error))
                raise TreeError(mistakes) from None
            except ValueError as error:
                raise NotServed(f"{self.name!r}: {error}") from None
        if kwargs.get("resume"):
            self._resumption = Resumption(f"{kwargs['resume']}/{place_of(self)}", robot, action)

    def initialise(self) -> None:
        """Send the goal, if there is one."""
        self._handle = None
        self._suspended = False
        goal = self._next_goal()
        if goal is None:
            self.feedback_message = "no goal to send"
            return
        # A running leaf replaces the goal of its current step.
        if self._resumption is not None and self.status is not Status.RUNNING:
            self._resumption.begin(goal)
        self._send(goal)

    def _send(self, goal: G) -> None:
        if self._client is None:
            raise RuntimeError(f"{self.name!r} was ticked before it was set up")
        self._sent, self._handle = goal, None
        try:
            self._handle = self._client.send_goal(
                goal,
                on_feedback=self._note_feedback,
                on_change=self._note_change,
                goal_id=None if self._resumption is None else self._resumption.next_id(),
                adopt=self._resumption is not None,
                read_result=not self.PLAIN,
            )
        except HmrsimError as error:
            self.feedback_message = str(error)
            return
        if self._resumption is not None:
            self._resumption.note(self._handle)
        self._open = [*self.open_goals, self._handle]
        self.feedback_message = "sent goal request"

    def _note_feedback(self, _feedback: F) -> None:
        self._wake()

    def _note_change(self, handle: GoalHandle[R, F]) -> None:
        if handle.done:
            self._wake()

    def update(self) -> Status:
        """Return the status of the goal."""
        handle = self._handle
        if handle is None:
            return Status.FAILURE
        if not handle.done:
            if handle.feedback is not None:
                self.feedback_message = f"feedback: {self._describe(handle.feedback)}"
            return Status.RUNNING
        if self._sent is not None and self._is_undone(handle):
            self._suspended = False
            self._send(self._sent)
            return Status.FAILURE if self._handle is None else Status.RUNNING
        self.verdicts += 1
        if isinstance(handle.error, ResultExpired) and handle.status is GoalStatus.SUCCEEDED:
            return self._succeeded("was done before; its result has expired")
        return self.ended(handle)

    def repeat(self) -> None:
        """Repeat goals that ended in an earlier run of the controller: the subtree is no step of the mission itself."""
        if self._resumption is not None:
            self._resumption.repeats = True

    def suspend(self) -> None:
        """Cancel the goal, if it is active, and resume it with the next tick; returns at once.

        The leaf's status stays as it is. The caller must not tick it before its open goals have ended. Then the goal's
        end counts: the leaf sends it again only if it was CANCELED.
        """
        if self.status is Status.RUNNING and self._handle is not None and not self._handle.done:
            self._suspended = True
            self.cancel()

    def ended(self, handle: GoalHandle[R, F]) -> Status:
        """Return the behavior's status for the end of the goal."""
        if handle.error is None and handle.status is GoalStatus.SUCCEEDED:
            return self._succeeded("successfully completed")
        self.feedback_message = _verdict(handle)
        return Status.FAILURE

    def _succeeded(self, message: str) -> Status:
        for key, value in self._on_success.items():
            self._blackboard.set(key, value)
        self.feedback_message = message
        return Status.SUCCESS

    def _is_undone(self, handle: GoalHandle[R, F]) -> bool:
        """Return whether to send a goal again, as it ended by suspension or in an earlier run."""
        if self._suspended and handle.error is None and handle.status is GoalStatus.CANCELED:
            return True
        return self._resumption is not None and self._resumption.is_undone(handle)

    def terminate(self, new_status: Status) -> None:
        """Cancel the goal if the leaf is interrupted."""
        if new_status is Status.INVALID:
            self.cancel()

    def cancel(self) -> None:
        """Cancel the active goals; returns at once."""
        for handle in self._open:
            if not handle.done:
                handle.cancel()

    def _next_goal(self) -> G | None:
        source: Any = self._goal
        if isinstance(source, str):
            source = self._blackboard.get(source) if self._blackboard.exists(source) else None
        goal: G | None = self._checked(source() if callable(source) else source)
        return goal

    def _checked(self, goal: Any) -> Any:
        """Return a goal; one in plain values with poses for the names of places.

        Raises:
            ValueError: There is no such place.
            ValidationError: It is not a goal of this action.
        """
        if self._client is None or self.PLAIN:
            return goal
        kind = self._client.action.goal
        # Before a check that calls Python code for each goal.
        if type(goal) is kind or not isinstance(goal, Mapping):
            return goal
        plain = goal if self._place_pose is None else with_poses(goal, kind, self._place_pose)
        # As the simulator reads it.
        kind.model_validate_json(to_json(plain))
        return plain


@cache
def _named(name: str) -> Action[Any, Any, Any]:
    actions = registry()
    return actions[known_name("action", name, actions)]


def _verdict(handle: GoalHandle[Any, Any]) -> str:
    """Return why a goal that is done has not succeeded."""
    if handle.error is not None:
        return f"rejected: {handle.error}" if isinstance(handle.error, GoalRejected) else str(handle.error)
    why = error_of(handle.result_message) if handle.result_message is not None else ""
    return f"{handle.status.name.lower()}: {why}" if why else handle.status.name.lower()


def _plain_fields(feedback: Message) -> str:
    """Return the plain fields of a message, without nested messages; durations in seconds."""
    shown = []
    for name in type(feedback).model_fields:
        value = getattr(feedback, name)
        if isinstance(value, Duration):
            shown.append(f"{name}: {value.to_seconds()} s")
        elif isinstance(value, (bool, int, float, str)):
            shown.append(f"{name}: {value}")
    return ", ".join(shown)


def _do_nothing() -> None:
    """Do nothing: the default of *wake*."""
