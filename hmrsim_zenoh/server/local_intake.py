"""How a server within its clients' process takes queries and finds subscribers."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from typing import TYPE_CHECKING, TypeVar

from hmrsim_zenoh.server.intake import Intake
from hmrsim_zenoh.server.local_inbox import LocalInbox
from hmrsim_zenoh.server.local_interest import LocalInterest

if TYPE_CHECKING:
    import zenoh

    from hmrsim_zenoh.loopback.exchange import Exchange

K = TypeVar("K", bound="Hashable")


def within(exchange: Exchange) -> Intake:
    """Return those for the sessions of an exchange."""

    def interest(
        _session: zenoh.Session, patterns: Mapping[K, str], _anything: str, _changed: Callable[[], None]
    ) -> LocalInterest[K]:
        return LocalInterest(exchange, patterns)

    return Intake(LocalInbox, interest)
