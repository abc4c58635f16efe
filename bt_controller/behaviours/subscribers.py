"""Leaves that read a robot's topics, named as in py_trees_ros.

The topics are ``odom``, ``battery_state`` and ``detections``. Each always has a latest message, so that, other than
with py_trees_ros, the default *clearing_policy* accepts it. With `ClearingPolicy.ON_INITIALISE` or `ON_SUCCESS` a leaf
accepts only a message that is newer than its initialise or its last success.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from py_trees.behaviour import Behaviour
from py_trees.common import Access, ClearingPolicy, Status

from bt_controller.core.robots import TOPICS
from hmrsim_zenoh.client.connection import Condition

if TYPE_CHECKING:
    from bt_controller.core.robots import Topics
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.connection import Operator, Value


_ORDERS: Final[Mapping[Callable[[Any, Any], bool], Operator]] = MappingProxyType(
    {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">="}
)
"""Comparisons as conditions have them."""

_LEVELS: Final = ("/charge", "/percentage")
"""The fields of a battery that are formulas of time."""


class Handler(Behaviour):
    """The base class of subscribers: it reads the latest message of a topic, and has arguments common to all of them.

    Args:
        robot: The robot; None for the robot of the tree.
        clearing_policy: When a message is discarded as too old.

    Raises:
        ValueError: There is no such topic.
    """

    def __init__(
        self,
        name: str,
        topic_name: str,
        *,
        robot: str | None = None,
        clearing_policy: ClearingPolicy = ClearingPolicy.NEVER,
    ) -> None:
        super().__init__(name)
        if topic_name not in TOPICS:
            raise ValueError(f"{name!r}: no topic {topic_name!r}; there are {', '.join(TOPICS)}")
        self.topic_name = topic_name
        self.clearing_policy = clearing_policy
        self._robot = robot
        self._topics: Topics | None = None
        self._cleared: Message | None = None

    def setup(self, **kwargs: Any) -> None:
        """Watch the topic of the robot.

        Raises:
            NotServed: There is no such robot, or it does not publish this topic.
            SimulatorNotFound: No simulator answers.
        """
        self._topics = kwargs["topics"]
        self._robot = self._robot or kwargs["robot"]
        self._topics.watch(self._robot, self.topic_name, kwargs.get("wake"))

    def initialise(self) -> None:
        """Discard older messages, if the policy says so."""
        if self.clearing_policy == ClearingPolicy.ON_INITIALISE:
            self._cleared = self._latest()

    def awaited(self) -> Sequence[Condition]:
        """Return the conditions that end the wait, where time stops for them; none if the topic has to be polled."""
        return ()

    def message(self) -> Any:
        """Return the latest message; None while it is too old."""
        latest = self._latest()
        return None if latest is self._cleared else latest

    def succeeded(self) -> Status:
        """Return SUCCESS, and discard older messages if the policy says so."""
        if self.clearing_policy == ClearingPolicy.ON_SUCCESS:
            self._cleared = self._latest()
        return Status.SUCCESS

    def _conditions(self, *whens: tuple[str, Operator, Value]) -> Sequence[Condition]:
        """Return a condition for each comparison; none if time does not stop for them."""
        if self._topics is None or not self._topics.stop_time(self._robot or "", self.topic_name):
            return ()
        return [Condition(f"{self._robot}/{self.topic_name}", (when,)) for when in whens]

    def _latest(self) -> Any:
        if self._topics is None:
            raise RuntimeError(f"{self.name!r} was ticked before it was set up")
        return self._topics.latest(self._robot or "", self.topic_name)


class CheckData(Handler):
    """Compares a field of the latest message with a value: SUCCESS when the comparison holds.

    Args:
        variable_name: The field, such as ``twist.twist.linear.x``.
        expected_value: The value to compare it with.
        comparison_operator: A function of both, such as `operator.lt`.
        fail_if_no_data: Whether to fail instead of waiting while no message is new enough.
        fail_if_bad_comparison: Whether to fail instead of waiting while the comparison does not hold.

    Raises:
        ValueError: There is no such topic, or no such field.
    """

    def __init__(  # noqa: PLR0913 - those of py_trees_ros
        self,
        name: str,
        topic_name: str,
        variable_name: str,
        expected_value: object,
        comparison_operator: Callable[[Any, Any], bool] = operator.eq,
        *,
        fail_if_no_data: bool = False,
        fail_if_bad_comparison: bool = False,
        robot: str | None = None,
        clearing_policy: ClearingPolicy = ClearingPolicy.NEVER,
    ) -> None:
        super().__init__(name, topic_name, robot=robot, clearing_policy=clearing_policy)
        self._field = _field(name, topic_name, variable_name)
        self._variable = variable_name
        self._expected = expected_value
        self._compare = comparison_operator
        self._without_data = Status.FAILURE if fail_if_no_data else Status.RUNNING
        self._otherwise = Status.FAILURE if fail_if_bad_comparison else Status.RUNNING

    def awaited(self) -> Sequence[Condition]:
        """Return the comparison, if it is one of a battery's level with a number: that is a formula of time."""
        order, path, value = _ORDERS.get(self._compare), f"/{self._variable}", self._expected
        level = self.topic_name == "battery_state" and path in _LEVELS
        if order is None or not level or isinstance(value, bool) or not isinstance(value, (int, float)):
            return ()
        return self._conditions((path, order, value)) if self.clearing_policy == ClearingPolicy.NEVER else ()

    def update(self) -> Status:
        """Return whether the comparison holds."""
        message = self.message()
        if message is None:
            self.feedback_message = "no message so far"
            return self._without_data
        value = self._field(message)
        holds = self._compare(value, self._expected)
        verdict = "succeeded" if holds else "failed"
        self.feedback_message = f"{self._variable!r} comparison {verdict} [v: {value}][e: {self._expected}]"
        return self.succeeded() if holds else self._otherwise


class WaitForData(Handler):
    """Waits for a message of any content: the next one, by default.

    Raises:
        ValueError: There is no such topic.
    """

    def __init__(
        self,
        name: str,
        topic_name: str,
        *,
        robot: str | None = None,
        clearing_policy: ClearingPolicy = ClearingPolicy.ON_INITIALISE,
    ) -> None:
        super().__init__(name, topic_name, robot=robot, clearing_policy=clearing_policy)

    def update(self) -> Status:
        """Return whether there is one."""
        if self.message() is None:
            self.feedback_message = "no message so far"
            return Status.RUNNING
        self.feedback_message = "got a message"
        return self.succeeded()


class ToBlackboard(Handler):
    """Writes the latest message, or some of its fields, on the blackboard.

    Args:
        blackboard_variables: The message's key; or its fields by key, where None is the whole message.
        initialise_variables: Values to write before the first tick, by key.

    Raises:
        ValueError: There is no such topic, or no such field.
    """

    def __init__(
        self,
        name: str,
        topic_name: str,
        blackboard_variables: str | Mapping[str, str | None],
        *,
        initialise_variables: Mapping[str, object] | None = None,
        robot: str | None = None,
        clearing_policy: ClearingPolicy = ClearingPolicy.NEVER,
    ) -> None:
        super().__init__(name, topic_name, robot=robot, clearing_policy=clearing_policy)
        fields = {blackboard_variables: None} if isinstance(blackboard_variables, str) else blackboard_variables
        self._fields = {key: _field(name, topic_name, field) for key, field in fields.items()}
        self.blackboard = self.attach_blackboard_client()
        initial = initialise_variables or {}
        for key in dict.fromkeys((*fields, *initial)):
            self.blackboard.register_key(key, Access.WRITE)
        for key, value in initial.items():
            self.blackboard.set(key, value)

    def update(self) -> Status:
        """Write the message; wait for the first one."""
        message = self.message()
        if message is None:
            self.feedback_message = "no message so far"
            return Status.RUNNING
        for key, field in self._fields.items():
            self.blackboard.set(key, field(message))
        self.feedback_message = f"wrote {', '.join(self._fields)}"
        return self.succeeded()


class EventToBlackboard(Handler):
    """Writes on the blackboard whether a message has come since the last tick; always succeeds.

    Args:
        variable_name: The blackboard key.

    Raises:
        ValueError: There is no such topic.
    """

    def __init__(self, name: str, topic_name: str, variable_name: str, *, robot: str | None = None) -> None:
        super().__init__(name, topic_name, robot=robot, clearing_policy=ClearingPolicy.ON_SUCCESS)
        self._variable = variable_name
        self.blackboard = self.attach_blackboard_client()
        self.blackboard.register_key(variable_name, Access.WRITE)
        self.blackboard.set(variable_name, value=False)

    def update(self) -> Status:
        """Write whether one has come."""
        came = self.message() is not None
        self.blackboard.set(self._variable, came)
        self.feedback_message = "got a message" if came else "nothing new"
        return self.succeeded()


def _field(name: str, topic: str, field: str | None) -> Callable[[Any], Any]:
    """Return a function that reads a field of a topic's message; of None, the message itself."""
    if field is None:
        return lambda message: message
    read = operator.attrgetter(field)
    try:
        read(TOPICS[topic]())
    except AttributeError:
        raise ValueError(f"{name!r}: {TOPICS[topic].ros_type} has no field {field!r}") from None
    return read
