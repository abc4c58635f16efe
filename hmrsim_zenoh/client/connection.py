"""The connection from a client to its simulator, which carries typed commands and their typed answers.

Within one process a command goes to the simulator's inbox as it is. Over Zenoh it is encoded here and decoded by the
server. The rest of the client neither knows which of the two is used nor handles JSON.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, Protocol, TypeVar, Union

from pydantic_core import ValidationError, to_json

from hmrsim.interfaces.message import Message
from hmrsim_zenoh.client.worker import Worker
from hmrsim_zenoh.errors import RequestError
from hmrsim_zenoh.wire.envelopes import plain, unreadable

if TYPE_CHECKING:
    from hmrsim.actions import Action
    from hmrsim.protocol.commands import Advance, CancelGoal, GetResult, SendGoal
    from hmrsim.protocol.time import Join, Leave, ReadTime
    from hmrsim_zenoh.errors import Denied
    from hmrsim_zenoh.wire.enclave import Enclave

M = TypeVar("M", bound=Message)
T = TypeVar("T")

PATIENCE: Final = 60.0
"""Wall seconds to wait for an answer by default; the absence of a simulator is noticed earlier."""

# Zenoh's own reply to a query that timed out; a simulator's errors are JSON.
_TIMED_OUT: Final = b"Timeout"

LOOK: Final = 1.0
"""The longest wait of a thread at a time, in wall seconds: Ctrl-C may fail to interrupt one that begins just then."""

Answer = Any
"""The answer to a command, as in `hmrsim.protocol.goal`; an `HmrsimError`, such as one that the simulator sent; or None
if no reply came and the effect of the command is unknown."""


class ActionTarget(Protocol):
    """An action of a robot, and the receiver of its feedback.

    Attributes:
        name: The name of the action in ROS.
    """

    robot: str
    action: Action[Any, Any, Any]
    name: str

    @property
    def wanted(self) -> bool:
        """Return whether there is a goal that needs feedback."""

    def take(self, goal_id: str, feedback: Message | Mapping[str, Any]) -> None:
        """Process the feedback of a goal."""


class ReadInfo(NamedTuple):
    """A request for the simulator's description; the answer is plain values, which the caller may modify."""


class Ask(NamedTuple):
    """A request to one of the world's services; the answer is its response.

    Attributes:
        service: Its name, such as ``get_named_poses``.
        response: The type of its response.
    """

    service: str
    request: Message
    response: type[Message]


class Read(NamedTuple):
    """A request for the latest value of a key, or with a payload to the service at a key; the answer is bytes."""

    key: str
    payload: bytes | None = None


Reply = bytes | RequestError | None
"""The bytes of a reply, the error that came instead, or None if no reply came and the request's effect is unknown."""

Operator = Literal["==", "!=", "<", "<=", ">", ">="]

Value = float | str | bool | None


@dataclass(frozen=True)
class Condition:
    """A condition on a message of a topic, such as ``Condition("eve/battery_state", [("/percentage", "<", 0.3)])``.

    Attributes:
        key: The topic, without the prefix.
        when: JSON pointer, operator and value of each comparison; without one any message will do.
    """

    key: str
    when: Sequence[tuple[str, Operator, Value]] = ()


class Watched(NamedTuple):
    """A command of an advance that adds a condition to watch.

    Attributes:
        name: The sender's name for the condition.
    """

    name: str
    condition: Condition


GoalCommand = Union["SendGoal", "CancelGoal", "GetResult"]
"""A command about the goals of one action."""

Asked = Union["Join", "Advance", "Leave", "ReadTime", ReadInfo, Ask, Read]
"""A request that blocks the calling thread until its answer arrives."""


class Call(Protocol):
    """A request whose answer one thread waits for.

    Attributes:
        answer: The answer; None before it arrives, and if it was lost.
    """

    answer: Answer

    def wait(self, timeout: float) -> bool:
        """Return whether there is an answer, or will be none, within *timeout* wall seconds."""

    def give_up(self) -> None:
        """End the request without an answer; from any thread."""


class Connection(ABC):
    """A connection to one simulator.

    Attributes:
        ordered: Whether commands arrive in the order in which they are sent.
        in_process: Whether the simulator runs in this process, where time moves only while a client waits.
        broken: Whether the connection is known to be closed.
        enclave: The identity of the client; None where sessions are open.
    """

    ordered = False
    in_process = False
    broken = False
    enclave: Enclave | None = None

    @abstractmethod
    def send(
        self,
        target: ActionTarget,
        command: GoalCommand,
        then: Callable[[Answer], None],
        *,
        timeout: float,
        read: bool = True,
        ended: bool = False,
    ) -> None:
        """Send a goal, cancel goals, or ask for a result, which may come much later.

        Answered by `GoalResponse`, `CancelResponse` or `ResultResponse`. The message of a goal may be plain values,
        which the simulator checks.

        Args:
            target: The action of the goals.
            command: The command.
            then: Receives the answer, once.
            timeout: Wall seconds for the answer.
            read: Whether to read the result of a goal that succeeded; if not, it is None.
            ended: Whether the goal whose result is wanted is known to have ended.
        """

    def execute(
        self,
        target: ActionTarget,
        command: SendGoal,
        *,
        timeout: float,
        on_answer: Callable[[Answer], None],
        on_end: Callable[[], None],
        read: bool = True,  # noqa: ARG002 - for subclasses
    ) -> None:
        """Send a goal that also requests its result; *on_answer* receives both answers, then *on_end* is called.

        By default only the goal is sent; a caller that has no result when *on_end* is called requests it separately.
        """
        self.send(target, command, on_answer, timeout=timeout)
        on_end()

    @abstractmethod
    def listen(self, target: ActionTarget) -> None:
        """Subscribe to the feedback of an action; its target may be called in Zenoh's thread."""

    @abstractmethod
    def call(self, command: Asked, *, timeout: float) -> Call:
        """Send a command whose answer a thread waits for; see `hmrsim.protocol.time` for answers about time."""

    @abstractmethod
    def ask(self, request: Read, then: Callable[[Reply], None], *, timeout: float) -> None:
        """Send a request and return at once; *then* receives the answer, once, in any thread."""

    @abstractmethod
    def subscribe(self, key: str, take: Callable[[str, bytes], None], *, history: bool = False) -> Callable[[], object]:
        """Call a function with the key and payload of each sample; return a function that unsubscribes.

        Raises:
            ClientClosed: The connection is closed.
        """

    def worker(self) -> Worker:
        """Return a worker that runs a client's deferred calls."""
        return Worker("hmrsim client", at_once=False)

    @abstractmethod
    def token(self) -> str:
        """Return a text that no other connection has."""

    def fitting(self, commands: list[Any]) -> int:
        """Return how many of these commands, from the first on, fit into one advance; at least one."""
        return len(commands)

    @abstractmethod
    def announce(self, name: str) -> Callable[[], None]:
        """Announce a participant; return a function that withdraws the announcement.

        Raises:
            ClientClosed: The connection is closed.
        """

    @abstractmethod
    def follow(self, on_change: Callable[[bool], None]) -> Callable[[], object]:
        """Report whether the simulator is alive, now and whenever that changes; return a function to stop that.

        Raises:
            ClientClosed: The connection is closed.
        """

    @abstractmethod
    def look(self, on_alive: Callable[[], None], then: Callable[[], None], *, timeout: float) -> None:
        """Check whether the simulator is alive: call *on_alive* if it is, then *then* within *timeout* seconds."""

    @abstractmethod
    def unlisten(self) -> None:
        """Unsubscribe from all feedback; the session stays open."""

    def denial(self, target: ActionTarget, command: GoalCommand) -> Denied | None:  # noqa: ARG002 - for subclasses
        """Return why access control denies a command to an action; None if it allows it, or if there is none."""
        return None


def body_of(reply: Any) -> Reply:
    """Return the payload or the error of a reply of Zenoh, or of an object with the same attributes."""
    if (sample := reply.ok) is not None:
        payload: bytes = sample.payload.to_bytes()
        if (attachment := sample.attachment) is None:
            return payload
        # The cause of a goal's failure is in the attachment, since a result has only the fields of its ROS type.
        cause = to_json(attachment.to_bytes().decode(errors="replace"))
        return b'%b,"cause":%b}' % (payload[:-1], cause)
    body = reply.err.payload.to_bytes() if reply.err is not None else b""
    return None if body == _TIMED_OUT else RequestError.from_json(body)


def take_within(queue: SimpleQueue[T], timeout: float) -> T:
    """Return the next item of a queue.

    Raises:
        Empty: There is none within *timeout* wall seconds.
    """
    limit = time.monotonic() + timeout
    while (left := limit - time.monotonic()) > LOOK:
        with suppress(Empty):
            return queue.get(timeout=LOOK)
    return queue.get(timeout=max(0.0, left))


def message_of(kind: type[M], value: object) -> M:
    """Return a message that arrived as an object or as plain values.

    Raises:
        UnreadableError: The values are not of the message's type.
    """
    if isinstance(value, kind):
        return value
    try:
        message: M = plain(kind).validate_python(value)
    except ValidationError as error:
        raise unreadable(error) from None
    return message
