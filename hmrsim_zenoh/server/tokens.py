"""The liveliness tokens of a simulator and its robots, and the simulator's claim on its prefix.

If several simulators start at the same time with one prefix, only one of them goes on.

A simulator declares that it starts, and then looks for others. Of two that start, at least the second one sees the
other. The one with the greater id gives way. The other one waits until that has gone, or serves because it has seen no
other. If two simulators connect to each other, neither may see the other before both serve. So a simulator keeps
looking while it is young: the one with the greater id gives way, and any young one gives way to an older one.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Collection
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
"""Wall seconds within which a simulator that serves gives way to another one."""
_LOOK: Final = 0.02
"""Wall seconds between two looks for other simulators."""
_ANSWER: Final = 10.0
"""Wall seconds to wait for answers; without another simulator Zenoh ends the query at once."""


class Claim:
    """The claim of a simulator's session on its prefix.

    Args:
        connect: The endpoints to which the session connects, through which it can meet another simulator.

    Raises:
        PrefixTaken: Another simulator serves it, or starts to.
    """

    _watch: zenoh.Subscriber[None]

    def __init__(self, session: zenoh.Session, keys: Keys, connect: Collection[str] = ()) -> None:
        self._session = session
        self._keys = keys
        self._connect = connect
        self._own = str(session.info.zid())
        self._made = time.monotonic()
        starting = session.liveliness().declare_token(keys.claim(self._own, _STARTING))
        try:
            self._wait_for_others()
            self._token = session.liveliness().declare_token(keys.claim(self._own, _SERVING))
        finally:
            starting.undeclare()

    def watch(self, lose: Callable[[PrefixTaken], None]) -> None:
        """Call *lose* in a separate thread if this simulator has to give way after all."""

        def look(sample: zenoh.Sample) -> None:
            zid, _ = _parts(sample.key_expr)
            if zid == self._own or sample.kind != zenoh.SampleKind.PUT:
                return
            if time.monotonic() - self._made > _YOUTH:
                _log.error("another simulator serves prefix %r, too; end one of them", self._keys.prefix)
                return
            # A callback must not close the session that calls it.
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
        """Undeclare the claim, so that another simulator can serve the prefix."""
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
        taken = f"another simulator serves prefix {self._keys.prefix!r}"
        if not self._connect:
            return PrefixTaken(f"{taken}; give another with --prefix")
        return PrefixTaken(
            f"{taken}, found by connecting to {', '.join(self._connect)} (--connect or HMRSIM_CONNECT); don't connect "
            "there, or give another prefix with --prefix"
        )


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


MAX_TOKENS = 1000
"""The largest number of robots with tokens: declaring them takes quadratic time."""


class LivelinessTokens:
    """The tokens of one simulation."""

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self._liveliness = session.liveliness()
        self._keys = keys
        self._simulator: zenoh.LivelinessToken | None = None
        self._robots: dict[str, zenoh.LivelinessToken] = {}

    def declare(self, robots: Collection[str]) -> None:
        """Declare the robots' tokens and then the simulator's."""
        self._follow(robots)
        self._simulator = self._liveliness.declare_token(self._keys.alive())

    def follow(self, robots: Collection[str], lost: Collection[str] = ()) -> None:
        """Declare the tokens of exactly these robots, except for *lost* ones; do nothing before `declare`."""
        if self._simulator is not None:
            with suppress(zenoh.ZError):
                self._follow(robots, lost)

    def undeclare(self) -> None:
        """Undeclare the tokens of the simulator and its robots."""
        tokens = [*self._robots.values(), *([self._simulator] if self._simulator else [])]
        self._robots, self._simulator = {}, None
        for token in tokens:
            token.undeclare()

    def _follow(self, robots: Collection[str], lost: Collection[str] = ()) -> None:
        wanted = dict.fromkeys(robot for robot in robots if robot not in lost) if len(robots) <= MAX_TOKENS else {}
        for robot in [robot for robot in self._robots if robot not in wanted]:
            self._robots.pop(robot).undeclare()
        for robot in wanted:
            if robot not in self._robots:
                self._robots[robot] = self._liveliness.declare_token(self._keys.alive(robot))
