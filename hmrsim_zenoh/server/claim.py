"""The claim of a simulator on its prefix, so that of several that start at the same time one stays.

A simulator declares that it starts, and then looks for others. Of two that start, at least the second sees the other.
The one with the greater id gives way; the other waits until that is either gone, or serves because it has seen nobody.
Where two connect to each other, neither may see the other before both serve. So a simulator keeps looking while it is
young: then the one with the greater id gives way, and any young one gives way to an older one.
"""

from __future__ import annotations

import logging
import time
from contextlib import suppress
from threading import Timer
from typing import TYPE_CHECKING, Final

import zenoh

from hmrsim_zenoh.errors import PrefixTaken

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)

_STARTING, _SERVING = "starting", "serving"
_PATIENCE: Final = 2.0
"""Wall seconds for another simulator to decide."""
_YOUTH: Final = 10.0
"""Wall seconds within which a simulator that serves gives way; links that are made later are another's mistake."""
_LOOK: Final = 0.02
_ANSWER: Final = 10.0
"""Wall seconds for which others may not answer; where nobody is, Zenoh says so at once."""


class Claim:
    """The claim of a simulator's session on its prefix.

    Raises:
        PrefixTaken: Another simulator serves it, or starts to.
    """

    _watch: zenoh.Subscriber[None]

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self._session = session
        self._keys = keys
        self._own = str(session.info.zid())
        self._made = time.monotonic()
        starting = session.liveliness().declare_token(keys.claim(self._own, _STARTING))
        try:
            self._wait_for_others()
            self._token = session.liveliness().declare_token(keys.claim(self._own, _SERVING))
        finally:
            starting.undeclare()

    def watch(self, lose: Callable[[PrefixTaken], None]) -> None:
        """Call *lose*, in a thread of its own, when this simulator has to give way after all."""

        def look(sample: zenoh.Sample) -> None:
            zid, _ = _parts(sample.key_expr)
            if zid == self._own or sample.kind != zenoh.SampleKind.PUT:
                return
            if time.monotonic() - self._made > _YOUTH:
                _log.error("another simulator serves prefix %r, too; end one of them", self._keys.prefix)
                return
            # A callback of Zenoh's must not close what it is called by.
            decision = Timer(0.0 if zid < self._own else _PATIENCE, decide, (zid,))
            decision.daemon = True
            decision.start()

        def decide(zid: str) -> None:
            with suppress(zenoh.ZError):
                if (zid, _SERVING) in _claims(self._session, self._keys):
                    lose(self._taken())

        handler = zenoh.handlers.Callback(look)
        key = self._keys.claim("*", _SERVING)
        self._watch = self._session.liveliness().declare_subscriber(key, handler, history=True)

    def undeclare(self) -> None:
        """Give the prefix up."""
        self._token.undeclare()

    def _wait_for_others(self) -> None:
        """Return when no other simulator claims the prefix.

        Raises:
            PrefixTaken: Another one has it.
        """
        deadline = time.monotonic() + _PATIENCE
        while others := [(zid, state) for zid, state in _claims(self._session, self._keys) if zid != self._own]:
            if time.monotonic() > deadline or any(state == _SERVING or zid < self._own for zid, state in others):
                raise self._taken()
            time.sleep(_LOOK)

    def _taken(self) -> PrefixTaken:
        return PrefixTaken(f"another simulator serves prefix {self._keys.prefix!r}; give another with --prefix")


def _claims(session: zenoh.Session, keys: Keys) -> Iterator[tuple[str, str]]:
    """Yield the id and the state of each simulator that claims the prefix."""
    replies = session.liveliness().get(keys.claim("*", "*"), zenoh.handlers.FifoChannel(256), timeout=_ANSWER)
    for reply in replies:
        if reply.ok is not None:
            yield _parts(reply.ok.key_expr)


def _parts(key: zenoh.KeyExpr) -> tuple[str, str]:
    """Return the id and the state that a token's key names."""
    _, zid, state = str(key).rsplit("/", 2)
    return zid, state
