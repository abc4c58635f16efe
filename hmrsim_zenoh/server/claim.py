"""The claim of a simulator on its prefix, so that of several that start at the same time one stays.

A simulator declares that it starts, and then looks for others. Of two that start, at least the second sees the other.
The one with the greater id gives way; the other waits until that is either gone, or serves because it has seen nobody.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Final

import zenoh

from hmrsim_zenoh.errors import PrefixTaken

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hmrsim_zenoh.wire.keys import Keys

_STARTING, _SERVING = "starting", "serving"
_PATIENCE: Final = 2.0
"""Wall seconds for another simulator to decide."""
_LOOK: Final = 0.02
_ANSWER: Final = 1.0


def claim(session: zenoh.Session, keys: Keys) -> zenoh.LivelinessToken:
    """Claim the prefix for the simulator of a session; return the token that keeps it.

    Raises:
        PrefixTaken: Another simulator serves it, or starts to.
    """
    own, liveliness = str(session.info.zid()), session.liveliness()
    starting = liveliness.declare_token(keys.claim(own, _STARTING))
    try:
        _wait_for_others(session, keys, own)
        return liveliness.declare_token(keys.claim(own, _SERVING))
    finally:
        starting.undeclare()


def _wait_for_others(session: zenoh.Session, keys: Keys, own: str) -> None:
    """Return when no other simulator claims the prefix.

    Raises:
        PrefixTaken: Another one has it.
    """
    deadline = time.monotonic() + _PATIENCE
    while others := [(zid, state) for zid, state in _claims(session, keys) if zid != own]:
        if time.monotonic() > deadline or any(state == _SERVING or zid < own for zid, state in others):
            raise PrefixTaken(f"another simulator serves prefix {keys.prefix!r}; give another with --prefix")
        time.sleep(_LOOK)


def _claims(session: zenoh.Session, keys: Keys) -> Iterator[tuple[str, str]]:
    """Yield the id and the state of each simulator that claims the prefix."""
    for key in _tokens(session, keys.claim("*", "*")):
        _, zid, state = key.rsplit("/", 2)
        yield zid, state


def _tokens(session: zenoh.Session, key: str) -> Iterator[str]:
    replies = session.liveliness().get(key, zenoh.handlers.FifoChannel(256), timeout=_ANSWER)
    for reply in replies:
        if reply.ok is not None:
            yield str(reply.ok.key_expr)
