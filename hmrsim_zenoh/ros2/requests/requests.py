"""Queries of ROS clients, and the commands that they stand for.

What can't be read is answered here, at once and never with an error, which would leave a ROS client waiting for
ever. All else is answered by what comes of the command, which carries the query as its ``reply_to``.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from pydantic import ValidationError

from hmrsim.protocol.commands import GetResult
from hmrsim_zenoh.ros2.codec.cdr import CdrError
from hmrsim_zenoh.ros2.requests.pending import NOBODY, PendingRosReply, attached_to
from hmrsim_zenoh.wire.envelopes import unreadable

if TYPE_CHECKING:
    from collections.abc import Callable

    import zenoh

    from hmrsim.protocol.commands import AnyCommand
    from hmrsim_zenoh.ros2.keys import Address
    from hmrsim_zenoh.ros2.requests.catalog import Catalog
    from hmrsim_zenoh.ros2.requests.rejection_log import Complaints
    from hmrsim_zenoh.ros2.requests.waiting import PendingResults
    from hmrsim_zenoh.ros2.wires import Wire

_log = logging.getLogger(__name__)


class Requests:
    """Reads queries.

    Args:
        wire: How keys are spelled.
        catalog: What is on offer.
        waiting: Remembers who waits for results.
        complaints: Says what is wrong.
        name_of: Gives what to call a client, by its id in hex.
        wrong_hash: Told what was asked in a layout that is none of ours, and by whom.
        max_payload: Bytes that a request may have.
    """

    def __init__(
        self,
        wire: Wire,
        catalog: Catalog,
        *,
        waiting: PendingResults,
        complaints: Complaints,
        name_of: Callable[[str], str],
        wrong_hash: Callable[[Address, str], None],
        max_payload: int,
    ) -> None:
        self._wire = wire
        self._catalog = catalog
        self._waiting = waiting
        self._say = complaints.say
        self._name_of = name_of
        self._wrong_hash = wrong_hash
        self._max_payload = max_payload

    def decode(self, query: zenoh.Query) -> list[AnyCommand]:
        """Return the commands that a query stands for; answer here what can't be read."""
        asked = self._asked(query)
        if asked is None:
            return []
        try:
            return self._commands(asked)
        except ValidationError as error:
            self._refuse(asked, str(unreadable(error)))
        except CdrError as error:
            self._refuse(asked, str(error))
        except Exception:  # noqa: BLE001 - whatever a client sends, the simulation goes on
            _log.exception("reading a request on %s", query.key_expr)
            asked.refuse("the simulator has a bug: it can't read this request")
        return []

    def refuse(self, query: zenoh.Query, text: str) -> None:
        """Answer a query that is not going to be read; from any thread."""
        asked = self._asked(query)
        if asked is not None:
            self._refuse(asked, text)

    def complain(self, client: str, service: str, text: str) -> None:
        """Say what is wrong with what a client asked; from any thread.

        Args:
            client: The client's id in hex; empty if it has none.
            service: What it asked.
            text: What is wrong, and what would do.
        """
        self._say(f"ROS 2: {self._name_of(client)}: {service}: {text}", client)

    def _asked(self, query: zenoh.Query) -> PendingRosReply | None:
        """Return what a query asks, and in which layout to answer; drop it if that is not for us to answer."""
        address = self._wire.read(str(query.key_expr))
        offer = self._catalog.find(address.name) if address else None
        if address is None or offer is None:
            query.drop()
            return None
        layout = offer.layouts.of(address)
        attached = None
        if self._wire.tells_types:
            try:
                attached = attached_to(query)
            except ValueError as error:
                self.complain("", offer.name, str(error))
                attached = NOBODY
        asked = PendingRosReply(query, self._wire, offer, layout or offer.layouts.nearest(address), attached)
        if layout is None:
            self._wrong_hash(address, asked.client)
            asked.refuse("a type of another layout was asked for")
            return None
        if offer.lost:
            self._refuse(asked, "it is no longer there; it was while its robot was")
            return None
        return asked

    def _commands(self, asked: PendingRosReply) -> list[AnyCommand]:
        payload = asked.query.payload
        size = len(payload) if payload is not None else 0
        if payload is None or size > self._max_payload:
            self._refuse(asked, f"payload of {size} bytes; 1 to {self._max_payload} are taken")
            return []
        commands = asked.offer.commands(asked.type.request.decode(payload.to_bytes()), asked)
        room = [
            each for command in commands if isinstance(command, GetResult) for each in self._waiting.add(asked, command)
        ]
        return [*room, *commands]

    def _refuse(self, asked: PendingRosReply, text: str) -> None:
        self.complain(asked.client, asked.offer.name, text)
        asked.refuse(text)
