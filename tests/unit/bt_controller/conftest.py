"""A client without a network: each goal is accepted, fed and ended by the test itself."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
from py_trees.blackboard import Blackboard
from pydantic_core import to_json

from hmrsim.interfaces.simulation_interfaces import GetNamedPoses
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.goal_handle import GoalHandle
from hmrsim_zenoh.client.places import NamedPlaces
from hmrsim_zenoh.errors import GoalRejectedError, ResultExpired
from hmrsim_zenoh.wire.keys import Keys

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message

INFO = {
    "robots": [
        {"name": "wall_e", "actions": ["navigate_to_pose", "pickup", "place", "wait"]},
        {"name": "eve", "actions": ["navigate_to_pose"]},
    ],
    "aliases": {"navigate_to_pose/wall_e": "wall_e/navigate_to_pose"},
}


class FakeGoal(GoalHandle[Any, Any]):
    """A ticket that does what the test says; it remembers whether it was canceled."""

    def __init__(
        self, robot: str, action: AnyAction, goal: Message, goal_id: str | None, *, adopt: bool, **callbacks: Any
    ) -> None:
        super().__init__(f"/{robot}/{action.name}", goal_id or "1" * 32, **callbacks)
        self.may_be_known = adopt
        self.robot = robot
        self.action = action
        self.goal = goal
        self.canceled = False
        self.when_canceled: Callable[[], None] | None = None

    def cancel(self) -> None:
        """Remember it, and let the robot do what it does then."""
        self.canceled = True
        if self.when_canceled is not None:
            self.when_canceled()

    def accept(self) -> None:
        """Accept the goal, as a robot does."""
        self._accept(GoalStatus.ACCEPTED)

    def is_known(self, status: GoalStatus) -> None:
        """Report that the robot has had the goal since an earlier run of the controller."""
        self._found = status
        self._accept(status)

    def expire(self, status: GoalStatus) -> None:
        """Report how the goal ended, without its result."""
        self._fail(ResultExpired("the result is not kept any longer"), status=status)

    def feed(self, **fields: Any) -> None:
        """Send feedback, as a robot does."""
        self.take_feedback(self.action.feedback(**fields))

    def succeed(self) -> None:
        """End the goal as SUCCEEDED."""
        self._end(GoalStatus.SUCCEEDED, self.action.result())

    def abort(self, code: int, message: str) -> None:
        """End the goal as ABORTED."""
        self._end(GoalStatus.ABORTED, self.action.failure(code, message))

    def end_canceled(self) -> None:
        """End the goal as CANCELED."""
        self._end(GoalStatus.CANCELED, self.action.failure(0, "canceled"))

    def reject(self, reason: str, message: str) -> None:
        """Reject the goal, as a robot does."""
        self._fail(GoalRejectedError(reason, 1, message), rejected=True)

    def fail(self, error: Exception) -> None:
        """End the goal with an error of the connection."""
        self._fail(error)


class FakeActionClient:
    """An action client that returns a ticket for each goal."""

    def __init__(self, client: FakeClient, robot: str, action: AnyAction) -> None:
        self._client = client
        self._robot = robot
        self._action = action

    def send_goal(
        self,
        goal: Message | Mapping[str, Any],
        *,
        goal_id: str | None = None,
        adopt: bool = False,
        read_result: bool = True,
        **callbacks: Any,
    ) -> FakeGoal:
        """Return a ticket, and keep it for the test, with the goal as a message."""
        if not read_result:
            goal = self._action.goal.model_validate_json(to_json(goal))
        if self._client.refuses is not None:
            raise self._client.refuses
        sent = FakeGoal(self._robot, self._action, goal, goal_id, adopt=adopt, **callbacks)
        self._client.goals.append(sent)
        return sent

    def cancel_all(self) -> None:
        """Cancel the goals of the action that were sent so far."""
        for goal in self._client.goals:
            if (goal.robot, goal.action) == (self._robot, self._action):
                goal.cancel()


class FakeSubscription:
    """A subscription that ignores its end."""

    def close(self) -> None:
        """Close nothing: the subscription is a stand-in."""


class FakeSession:
    """Declares what a controller publishes, without subscribers."""

    matching_status = SimpleNamespace(matching=False)

    def declare_queryable(self, *_args: object, **_options: object) -> FakeSession:
        """Return what can be undeclared."""
        return self

    declare_publisher = declare_matching_listener = declare_queryable

    def undeclare(self) -> None:
        """Undeclare nothing: the publisher is a stand-in."""


class FakeClient:
    """The parts of a client that a controller uses.

    Attributes:
        goals: The tickets of all goals, in order.
        alive: Whether the simulator is there.
        lockstep: None: time moves by itself.
        began: When the clock is heard for the first time; None for never.
        refuses: The error with which sending a goal fails; None if it doesn't.
    """

    def __init__(self) -> None:
        self.keys = Keys()
        self.session = FakeSession()
        self.goals: list[FakeGoal] = []
        self.alive = True
        self.lockstep = None
        self.began: float | None = 0.0
        self.refuses: Exception | None = None
        self._listeners: dict[str, Callable[[str, bytes], None]] = {}

    @property
    def places(self) -> NamedPlaces:
        """The places of the world: none."""
        return NamedPlaces(GetNamedPoses.Response)

    def info(self) -> dict[str, Any]:
        """Return two robots."""
        return INFO

    def action_client(self, robot: str, action: AnyAction) -> FakeActionClient:
        """Return what sends goals."""
        return FakeActionClient(self, robot, action)

    def subscribe(self, key: str, callback: Callable[[str, bytes], None], *, history: bool) -> FakeSubscription:
        """Keep the callback; only topics with history are followed."""
        assert history
        self._listeners[key] = callback
        if self.began is not None:
            self.clock(self.began)
        return FakeSubscription()

    def publish(self, key: str, payload: bytes) -> None:
        """Publish a message, as the simulator does."""
        self._listeners[key](key, payload)

    def clock(self, now: float) -> None:
        """Publish the time, as the simulator does."""
        sec, nanosec = divmod(round(now * 1e9), 1_000_000_000)
        self.publish("hmrsim/_world/clock", json.dumps({"clock": {"sec": sec, "nanosec": nanosec}}).encode())


@pytest.fixture
def client() -> FakeClient:
    """Return a client whose goals wait for the test."""
    return FakeClient()


@pytest.fixture(autouse=True)
def _clean_blackboard() -> Iterator[None]:
    """Leave no keys to the next test: py_trees' blackboard belongs to the process."""
    yield
    Blackboard.clear()
