"""Decoding of ROS clients' queries to commands, and the requests for results that wait.

An invalid query is answered here at once, never with an error reply, after which a ROS client would wait forever. Any
other query travels with its command as ``reply_to`` and is answered when the command has been processed. ROS's replies
have no field for the reason of a rejection, so the log has it.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Final

import zenoh
from pydantic import ValidationError

from hmrsim.protocol.commands import CallService, GetResult, SendGoal, StopWaiting
from hmrsim_zenoh.ros2.codec.layout import CdrError
from hmrsim_zenoh.ros2.keys import numbered
from hmrsim_zenoh.ros2.requests.handlers import PendingRosReply
from hmrsim_zenoh.ros2.wires import Attachment, read_attachment
from hmrsim_zenoh.wire.envelopes import MAX_TEXT, UnreadableError, check_texts_of, unreadable

if TYPE_CHECKING:
    from hmrsim.protocol.commands import AnyCommand
    from hmrsim_zenoh.ros2.codec.types import ServiceType
    from hmrsim_zenoh.ros2.keys import Node
    from hmrsim_zenoh.ros2.peers import Peers
    from hmrsim_zenoh.ros2.rejection_log import RejectionLog
    from hmrsim_zenoh.ros2.requests.catalog import Catalog
    from hmrsim_zenoh.ros2.requests.handlers import Handler
    from hmrsim_zenoh.ros2.wires import Wire
    from hmrsim_zenoh.server.publisher import Publisher

_log = logging.getLogger(__name__)

_MISSING: Final = "the request has no attachment, by which rmw_zenoh identifies the client; see docs/reference/ros2.md"

MAX_WAITING: Final = 16_384
"""The largest number of pending requests for results."""
MAX_PER_CLIENT: Final = 1_024
"""The largest number of pending requests of one client."""
MAX_ANONYMOUS: Final = 32
"""The largest number for one goal, of clients without an id: it is unknown when they leave; most gave up long ago."""


class PendingResults:
    """The requests for results that have not been answered; for any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._of: dict[str, dict[PendingRosReply, GetResult]] = {}
        self._owners: dict[PendingRosReply, str] = {}

    def add(self, pending: PendingRosReply, command: GetResult) -> list[StopWaiting]:
        """Remember a request; return the commands that drop another one if there are too many now.

        That is the oldest of the same client, or the oldest of the client with the most if the total is too large.
        """
        owner = pending.client or f"goal {command.goal_id}"
        with self._lock:
            requests = self._of.setdefault(owner, {})
            requests[pending], self._owners[pending] = command, owner
            if len(requests) > (MAX_PER_CLIENT if pending.client else MAX_ANONYMOUS):
                return self._make_room(owner)
            if len(self._owners) > MAX_WAITING:
                return self._make_room(max(self._of, key=lambda one: len(self._of[one])))
        return []

    def answered(self, pending: PendingRosReply) -> None:
        """Forget a request that has been answered."""
        with self._lock:
            self._forget(pending)

    def gone(self, client: str) -> list[StopWaiting]:
        """Forget all requests of a client that has gone; return the commands that drop them."""
        with self._lock:
            requests = self._of.pop(client, {})
            for pending in requests:
                del self._owners[pending]
        return _stop_waiting(requests)

    def _make_room(self, owner: str) -> list[StopWaiting]:
        pending, command = next(iter(self._of[owner].items()))
        self._forget(pending)
        return [stop._replace(tell=True) for stop in _stop_waiting({pending: command})]

    def _forget(self, pending: PendingRosReply) -> None:
        owner = self._owners.pop(pending, None)
        if owner is not None:
            del self._of[owner][pending]
            if not self._of[owner]:
                del self._of[owner]


class Requests:
    """Decodes queries of ROS clients to commands.

    A key is parsed, and its handler looked up, for the first query on it.

    Args:
        keys: Declares the keys that are served, each for the first query on it.
        waiting: The pending get_result requests.
        peers: Name clients in messages, and warn of those with unknown layouts; None on a wire without tokens.
        reject: Called with the node and the reason when a request is rejected here; from any thread.
        max_payload: The largest request in bytes.
    """

    def __init__(
        self,
        wire: Wire,
        catalog: Catalog,
        keys: Publisher,
        *,
        waiting: PendingResults,
        rejections: RejectionLog,
        peers: Peers | None,
        reject: Callable[[Node, str], None],
        max_payload: int,
    ) -> None:
        self._wire = wire
        self._catalog = catalog
        self._keys = keys
        self._routes: dict[str, tuple[Handler, ServiceType]] = {}
        self._waiting = waiting
        self._warn = rejections.warn
        self._peers = peers
        self._reject = reject
        self._max_payload = max_payload

    def follow(self, robots: Collection[str]) -> None:
        """Look up handlers anew after the served names have changed, and undeclare the keys of other robots."""
        self._routes.clear()
        self._keys.forget(lambda key: (address := self._wire.read(key)) is None or address.robot not in robots)

    def decode(self, query: zenoh.Query) -> list[AnyCommand]:
        """Return the commands of a query; an invalid query is answered here; in the simulation's thread."""
        key = str(query.key_expr)
        if (route := self._routes.get(key)) is not None:
            handler, layout = route
            pending = PendingRosReply(query, self._wire, handler, layout, self._attachment_of(query, handler))
        elif (new := self._pending_reply(query)) is not None:
            pending, self._routes[key] = new, (new.handler, new.type)
            with suppress(zenoh.ZError):
                self._keys.declare(key)
        else:
            return []
        try:
            return self._commands(pending)
        except ValidationError as error:
            self._refuse(pending, str(unreadable(error)))
        except (CdrError, UnreadableError) as error:
            self._refuse(pending, str(error))
        except Exception:  # noqa: BLE001 - no request may end the simulation
            _log.exception("reading a request on %s", query.key_expr)
            pending.refuse("the simulator has a bug: it can't read this request")
        return []

    def refuse(self, query: zenoh.Query, text: str) -> None:
        """Answer a query that will not be decoded; from any thread."""
        pending = self._pending_reply(query)
        if pending is not None:
            self._refuse(pending, text)

    def log_rejection(self, client: str, service: str, text: str) -> None:
        """Log why a client's request is rejected; from any thread.

        Args:
            client: The client's gid in hex; empty if it has none.
            service: The requested service.
            text: The error and the remedy.
        """
        name = (self._peers.name_of if self._peers else numbered)(client)
        self._warn(f"ROS 2: {name}: {service}: {text}", client)

    def _pending_reply(self, query: zenoh.Query) -> PendingRosReply | None:
        """Return a query with its handler and layout; drop a query to an unknown name; from any thread."""
        address = self._wire.read(str(query.key_expr))
        found = self._catalog.find(address.name) if address else None
        if address is None or found is None:
            query.drop()
            return None
        known = found.layouts.of(address)
        attached = self._attachment_of(query, found)
        pending = PendingRosReply(query, self._wire, found, known or found.layouts.nearest(address), attached)
        if known is None:
            if self._peers is not None:
                self._peers.wrong_hash(address, pending.client)
            pending.refuse("the request has another type or layout than the service")
            return None
        if found.lost:
            self._refuse(pending, "no longer served: its robot is gone")
            return None
        return pending

    def _attachment_of(self, query: zenoh.Query, handler: Handler) -> Attachment | None:
        """Return the attachment of a query, or zeros if it is invalid; None on a wire without attachments."""
        if not self._wire.has_types:
            return None
        attached = query.attachment
        try:
            if attached is None:
                raise ValueError(_MISSING)  # noqa: TRY301 - one place handles errors
            return read_attachment(attached.to_bytes())
        except ValueError as error:
            self.log_rejection("", handler.name, str(error))
            return Attachment(0, 0, bytes(16))

    def _commands(self, pending: PendingRosReply) -> list[AnyCommand]:
        payload = pending.query.payload
        size = len(payload) if payload is not None else 0
        if payload is None or size > self._max_payload:
            self._refuse(pending, f"payload of {size} bytes; 1 to {self._max_payload} are taken")
            return []
        commands = pending.handler.commands(pending.type.request.decode(payload.to_bytes()), pending)
        for command in commands:
            if isinstance(command, GetResult):
                return [*self._waiting.add(pending, command), command]
            if size > MAX_TEXT and isinstance(command, (SendGoal, CallService)):
                check_texts_of(command.goal if isinstance(command, SendGoal) else command.request)
        return commands

    def _refuse(self, pending: PendingRosReply, text: str) -> None:
        self.log_rejection(pending.client, pending.handler.name, text)
        self._reject(pending.handler.serving, f"{pending.handler.name}: {text}")
        pending.refuse(text)


def _stop_waiting(pending_requests: Mapping[PendingRosReply, GetResult]) -> list[StopWaiting]:
    """Return the commands that drop requests, one for each goal."""
    of_goals: dict[tuple[str, str, str], list[PendingRosReply]] = {}
    for pending, command in pending_requests.items():
        of_goals.setdefault((command.robot, command.action, command.goal_id), []).append(pending)
    return [StopWaiting(*goal, tuple(requests)) for goal, requests in of_goals.items()]
