"""The succession of a router: ROS nodes find one another at a fixed endpoint, where some process has to listen."""

from __future__ import annotations

import logging
import threading
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import zenoh

from hmrsim_zenoh.errors import BadOptions, PortTaken, SimulatorNotFound
from hmrsim_zenoh.wire.session import open_server

if TYPE_CHECKING:
    from hmrsim_zenoh.wire.options import SessionOptions

_log = logging.getLogger(__name__)

_LOOK_SECONDS: Final = 0.5
"""Wall seconds between two checks whether the router is still there; ROS nodes look for one every 1 to 4 s."""
_JOIN_SECONDS: Final = 5.0


class RouterSuccession:
    """Opens a router in place of the one that a simulator has joined, once that has ended.

    Processes that are connected already keep their connections; later ones find each other again. The router's endpoint
    is the default one of the simulator's *options*.
    """

    def __init__(self, session: zenoh.Session, options: SessionOptions, endpoints: tuple[str, ...]) -> None:
        self._session = session
        self._options = replace(options, mode="router", listen=(options.default,), connect=endpoints)
        self._ended = threading.Event()
        self._router: zenoh.Session | None = None
        self._thread = threading.Thread(target=self._watch, name="hmrsim-router", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop watching, and close the router if there is one."""
        self._ended.set()
        self._thread.join(_JOIN_SECONDS)
        if self._router is not None:
            self._router.close()

    def _watch(self) -> None:
        while self._router is None and not self._ended.wait(_LOOK_SECONDS):
            try:
                if not self._session.info.routers_zid():
                    self._router, _ = open_server(self._options)
                    _log.warning("the router has ended; listening on %s in its place", self._options.default)
            except (PortTaken, BadOptions, SimulatorNotFound) as error:
                # Another process has taken its place, or takes it now.
                _log.debug("no router opened: %s", error)
            except (zenoh.ZError, RuntimeError):
                return
