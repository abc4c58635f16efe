"""Leaves that call the world's services, named as in py_trees_ros.

Where time moves by itself, the leaf waits for the response from tick to tick. In lockstep, time stands still while
trees are ticked, and the response is there within the tick, so that every run is the same. A service that takes
simulated time, such as ``step_simulation``, has no response then, and the leaf fails.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from py_trees.behaviour import Behaviour
from py_trees.common import Access, Status

from hmrsim.errors import HmrsimError
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim_zenoh.errors import RequestError, RequestTimeout
from hmrsim_zenoh.wire.envelopes import UnreadableError, plain, read

if TYPE_CHECKING:
    from bt_controller.core.robots import Topics
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.connection import Reply

_TIMEOUT: Final = 10.0
"""The response's timeout in wall seconds."""

_AT_ONCE: Final = 5.0
"""The response's timeout in wall seconds where it needs no simulated time."""


class FromBlackboard(Behaviour):
    """Calls a service with the request that is on the blackboard upon initialise; fails if there is none.

    A response whose ``result`` is an error is FAILURE.

    Args:
        service_type: The service's type, such as `SetDoorState`.
        service_name: The service, such as ``set_door_state``.
        key_request: The request's blackboard key.
        key_response: The response's blackboard key; None to drop the response.
    """

    def __init__(
        self, name: str, service_type: Any, service_name: str, key_request: str, key_response: str | None = None
    ) -> None:
        super().__init__(name)
        self._type = service_type
        self._service = service_name
        self._key_request = key_request
        self._key_response = key_response
        self._client: Client | None = None
        self._wake: Callable[[], None] = lambda: None
        self._topics: Topics | None = None
        self._answers: list[Reply | HmrsimError] | None = None
        self.blackboard = self.attach_blackboard_client()
        if key_request:
            self.blackboard.register_key(key_request, Access.READ)
        if key_response is not None:
            self.blackboard.register_key(key_response, Access.WRITE)

    def setup(self, **kwargs: Any) -> None:
        """Keep the client for the requests."""
        self._client = kwargs["client"]
        self._wake = kwargs.get("wake") or self._wake
        self._topics = kwargs.get("topics")

    def initialise(self) -> None:
        """Send the request to the service."""
        self._answers = None
        request = self.request()
        if request is None:
            self.feedback_message = "no request to send"
            return
        if not isinstance(request, self._type.Request):
            self.feedback_message = f"{self._service} takes {self._type.Request.ros_type}, got {request!r:.80}"
            return
        if self._client is None:
            raise RuntimeError(f"{self.name!r} was ticked before it was set up")
        key, payload = self._client.keys.world(self._service), request.model_dump_json().encode()
        # A leaf that was interrupted and starts again ignores the response to an older request.
        answers: list[Reply | HmrsimError] = []
        self._answers = answers
        self.feedback_message = "sent request"
        if self._client.lockstep is None:

            def answered(answer: Reply) -> None:
                answers.append(answer)
                self._wake()

            self._client.ask(key, payload, answered, timeout=_TIMEOUT)
            return
        try:
            answers.append(self._client.get(key, _AT_ONCE, payload=payload))
        except RequestTimeout as error:
            answers.append(RequestTimeout(f"{error}; in lockstep time stands meanwhile, so it must not take any"))
        except HmrsimError as error:
            answers.append(error)
        if self._topics is not None:
            self._topics.forget()

    def request(self) -> Message | None:
        """Return the request; None if there is none."""
        key = self._key_request
        return self.blackboard.get(key) if self.blackboard.exists(key) else None

    def update(self) -> Status:
        """Return the status of the request."""
        if self._answers is None:
            return Status.FAILURE
        if not self._answers:
            return Status.RUNNING
        try:
            response = self._response(self._answers[0])
        except (HmrsimError, UnreadableError) as error:
            self.feedback_message = str(error)
            return Status.FAILURE
        if self._key_response is not None:
            self.blackboard.set(self._key_response, response)
        result = getattr(response, "result", None)
        if isinstance(result, Result) and result.result != Result.RESULT_OK:
            self.feedback_message = result.error_message or f"result {result.result}"
            return Status.FAILURE
        self.feedback_message = "successfully completed"
        return Status.SUCCESS

    def _response(self, answer: Reply | HmrsimError) -> Message:
        if isinstance(answer, HmrsimError):
            raise answer
        if answer is None:
            raise RequestError(f"no answer from {self._service!r}; it may have been served all the same")
        response: Message = read(plain(self._type.Response), answer)
        return response


class FromConstant(FromBlackboard):
    """Calls a service with a constant request; the other arguments are those of `FromBlackboard`."""

    def __init__(
        self,
        name: str,
        service_type: Any,
        service_name: str,
        service_request: Message,
        key_response: str | None = None,
    ) -> None:
        super().__init__(name, service_type, service_name, "", key_response)
        self._request = service_request

    def request(self) -> Message:
        """Return the request."""
        return self._request
