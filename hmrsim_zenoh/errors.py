"""The errors between a client and a simulator; all are `HmrsimError`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from hmrsim.errors import GoalRejected, HmrsimError

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.goal import GoalStatus

_MAX_SHOWN = 200


class BadOptions(HmrsimError):
    """An endpoint, a prefix or a Zenoh configuration is invalid; the text names the value."""


class PortTaken(HmrsimError):
    """Another process listens at an endpoint already; the text names the endpoint."""


class PrefixTaken(HmrsimError):
    """Another simulator serves this prefix; the text names it."""


class SimulatorNotFound(HmrsimError):
    """No simulator answers at the endpoint, or none with this prefix."""


class ConnectionDenied(SimulatorNotFound):
    """A process listens at the endpoint, but does not let this one in; the text says why."""


class SimulatorGone(HmrsimError):
    """The simulator died, or was restarted and does not know the goal."""


class SimulationEnded(SimulatorGone):
    """The run is over, as its duration is, or the simulator was stopped; the text says which."""


class ParticipantLost(HmrsimError):
    """The run has ended with the loss of a participant; the text names it, and says why it was dropped."""


class Unreachable(HmrsimError):
    """The simulator is there, but nothing answers on that key; the request's effect is unknown."""


class RequestError(HmrsimError):
    """The simulator answered with an error: it can't read or serve the request.

    Attributes:
        details: A mapping for each error in the request, with ``field``, ``message`` and ``value``.
    """

    def __init__(self, message: str, details: Sequence[dict[str, Any]] = ()) -> None:
        self.details = tuple(details)
        super().__init__(message)

    @classmethod
    def from_json(cls, payload: bytes) -> RequestError:
        """Return the error in the body of a Zenoh error reply, whatever its format."""
        try:
            body = json.loads(payload)
            error, details = body["error"], [dict(item) for item in body.get("details", ())]
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            return cls(payload[:_MAX_SHOWN].decode(errors="replace"))
        return cls(str(error), details)


class Denied(RequestError):
    """The simulator's access control denies the request; the text names the certificate and the key."""


class NameTaken(RequestError):
    """Another participant has that name; the text names it."""


class GoalRejectedError(GoalRejected):
    """The simulator rejects a goal.

    Attributes:
        reason: A machine-readable word, such as ``unknown_robot`` or ``busy``.
        error_code: The code that the action's result would have.
    """

    def __init__(self, reason: str, error_code: int, message: str) -> None:
        self.error_code = error_code
        self.message = message
        super().__init__(reason, f"{reason}: {message}" if message else reason)


class RequestTimeout(HmrsimError, TimeoutError):
    """There was no answer in time."""


class GoalTimeout(RequestTimeout):
    """A goal was not answered or did not end in time; the text says whether it may still be running."""


class ResultExpired(HmrsimError):
    """A goal has ended, but the simulator no longer keeps its result."""


class ClientClosed(HmrsimError):
    """The client was closed while a request or a goal was active."""


class Dropped(HmrsimError):
    """The simulator goes on without this client; the text says since when and why."""


class Idle(HmrsimError):
    """Nothing is scheduled in the simulation and no participant acts: the awaited event can't happen."""


class Deadlock(SystemExit):
    """No task of an event loop can go on, and nothing is awaited that could change that.

    It ends `asyncio.run` even if tasks catch all errors. A program that does not catch it prints it and exits with 1.
    """


class NotCharging(HmrsimError):
    """A robot is not charging, so its battery will not reach the awaited charge."""


class GoalFailed(HmrsimError):
    """A goal did not end with SUCCEEDED.

    Attributes:
        status: How it ended.
        result: The action's result, with its error code and message.
        cause: Why, as an identifier such as ``preempted``; empty if the simulator does not say.
    """

    def __init__(self, message: str, status: GoalStatus, result: Message, cause: str = "") -> None:
        self.status = status
        self.result = result
        self.cause = cause
        super().__init__(message)
