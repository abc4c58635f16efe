"""The external planner: its discovery, the requests to it and its answers.

The planner is a Zenoh queryable of another program. Each of its answers becomes a command, even an unusable one.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

import zenoh

from hmrsim.errors import SimulationStopped
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.protocol.commands import PlanAnswered, PlannerPresent
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.envelopes import UnreadableError, plain, read

if TYPE_CHECKING:
    from hmrsim.protocol.commands import AnyCommand
    from hmrsim.protocol.outputs import PlanWanted
    from hmrsim_zenoh.wire.keys import Keys

_MAX_TIMEOUT = 1e9
"""Zenoh's query timeout in wall seconds where the planner has no time limit."""

_TIMED_OUT = b"Timeout"
"""Zenoh's own reply in place of a planner that times out."""

_SHOWN = 200
"""Characters of a planner's answer that are shown."""


class Planner:
    """Finds the planner on the network, and sends it requests for paths.

    Args:
        wanted: Returns whether any robot needs a planner.
        timeout: Wall seconds within which the planner has to answer.
        max_payload: The largest answer in bytes.
    """

    def __init__(
        self,
        session: zenoh.Session,
        keys: Keys,
        put: Callable[[AnyCommand], None],
        *,
        wanted: Callable[[], bool],
        timeout: float,
        max_payload: int,
    ) -> None:
        self._put = put
        self._wanted = wanted
        self._timeout = timeout
        self._max_payload = max_payload
        self._lock = threading.Lock()
        self._announced = False
        # The simulator's own queryable matches the key, too. Of several planners the first answer counts.
        self._querier = session.declare_querier(
            keys.planner(),
            target=zenoh.QueryTarget.ALL,
            timeout=min(timeout, _MAX_TIMEOUT),
            allowed_destination=zenoh.Locality.REMOTE,
        )
        self._querier.declare_matching_listener(zenoh.handlers.Callback(self._on_matching))

    def look(self) -> list[AnyCommand]:
        """Return the commands to process before a goal: a planner may have appeared just before it.

        If no robot needs a planner, there are none, and goals do not wait until Zenoh has found one.
        """
        if not self._wanted():
            return []
        with self._lock:
            return self._changes()

    def _on_matching(self, _status: zenoh.MatchingStatus) -> None:
        # With the lock held: a concurrent call that finds nothing new is ordered after this one.
        with self._lock, suppress(SimulationStopped):
            for command in self._changes():
                self._put(command)

    def _changes(self) -> list[AnyCommand]:
        present: bool = self._querier.matching_status.matching  # type: ignore[attr-defined]  # the stub errs
        if present == self._announced:
            return []
        self._announced = present
        return [PlannerPresent(present)]

    def ask(self, event: PlanWanted) -> None:
        """Request a path; the answer becomes a command when it arrives."""
        answered = False

        def answer(result: ComputePathToPose.Result) -> None:
            """Put the only answer to the request into the inbox; called in Zenoh's threads, too."""
            nonlocal answered
            if not answered:
                answered = True
                with suppress(SimulationStopped):
                    self._put(PlanAnswered(event.request, result))

        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            lambda reply: answer(self._read(reply)),
            lambda: answer(_failed("the planner has left or has not answered")),
        )
        payload, mime = encoding.message(event.goal), encoding.of_message(event.goal)
        try:
            self._querier.get(handler, payload=payload, encoding=mime, attachment=event.robot)
        except zenoh.ZError as error:
            answer(_failed(f"the request to the planner can't be sent: {error}"))

    def _read(self, reply: zenoh.Reply) -> ComputePathToPose.Result:
        """Return the result in a reply; an error of the planner becomes a result with an error code."""
        if reply.err is not None:
            text = reply.err.payload.to_bytes()
            if text == _TIMED_OUT:
                code = ComputePathToPose.Result.TIMEOUT
                return _failed(f"the planner has not answered in {self._timeout:g} s", code)
            return _failed(f"the planner answered with an error: {text[:_SHOWN].decode(errors='replace')}")
        if reply.ok is None:
            raise AssertionError
        payload = reply.ok.payload
        if len(payload) > self._max_payload:
            return _failed(f"the planner's answer has {len(payload)} bytes; at most {self._max_payload} are taken")
        try:
            result: ComputePathToPose.Result = read(
                plain(ComputePathToPose.Result), payload.to_bytes(), max_payload=self._max_payload
            )
        except UnreadableError as error:
            return _failed(f"the planner's answer can't be read: {error}")
        return result


def _failed(text: str, code: int = ComputePathToPose.Result.UNKNOWN) -> ComputePathToPose.Result:
    return ComputePathToPose.Result(error_code=code, error_msg=text)
