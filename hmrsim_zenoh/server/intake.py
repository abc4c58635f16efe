"""How a server takes queries and finds its subscribers: over a network, or within one process."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from hmrsim_zenoh.server.channel_inbox import ChannelInbox
from hmrsim_zenoh.server.interest import SubscriberWatch

if TYPE_CHECKING:
    from hmrsim_zenoh.server.inbox import InboxMaker
    from hmrsim_zenoh.server.interest import InterestMaker


class Intake(NamedTuple):
    """The makers of a server's inbox and of what finds its subscribers."""

    inbox: InboxMaker
    interest: InterestMaker


OVER_ZENOH = Intake(ChannelInbox, SubscriberWatch)
