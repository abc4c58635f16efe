"""Opening of Zenoh sessions, with clear errors when that fails.

The simulator is its own router, so no zenohd is needed. Multicast scouting is off: only configured endpoints are used.
"""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Final

import zenoh

from hmrsim_zenoh.errors import BadOptions, ClientClosed, ConnectionDenied, PortTaken, SimulatorNotFound
from hmrsim_zenoh.wire.configuration import base_config, first_line
from hmrsim_zenoh.wire.enclave import SIMULATOR, Enclave, find_enclave
from hmrsim_zenoh.wire.handshake import why_denied
from hmrsim_zenoh.wire.options import ENCRYPTED, SessionOptions, check_endpoint, with_port

_log = logging.getLogger(__name__)

_PORT_TRIES: Final = 5

_ADVICE: Final = "start `hmrsim run WORLD` or give another endpoint"
_LOOPBACK: Final = "tcp/127.0.0.1:0"
_JOIN_TIMEOUT: Final = 2.0
"""Wall seconds within which another Zenoh has to answer."""

# Zenoh's own retry begins at 1 s: a tool that starts along with its simulator would wait that long.
_RETRY: Final = {"period_init_ms": 20, "period_max_ms": 200, "period_increase_factor": 1.05}

# Of several endpoints Zenoh tries the first until the timeout, so each is tried once, in turn. Delete this when
# `connect/timeout_ms` no longer keeps a client from its second endpoint.
_FIRST_TRY: Final = 0.15
_OPEN_TIMEOUT_KEY: Final = "transport/unicast/open_timeout"

# A stopped subscriber would otherwise block its publishers for 5 s.
_WAIT_BEFORE_CLOSE: Final = 500_000
_WAIT_BEFORE_CLOSE_KEY: Final = "transport/link/tx/queue/congestion_control/block/wait_before_close"

_MAX_MESSAGE_KEY: Final = "transport/link/rx/max_message_size"
MAX_MESSAGE: Final = 16 << 20
"""The largest message that a simulator receives, in bytes: Zenoh drops larger ones while they arrive, unanswered."""

# Deallocating a router's session waits for Zenoh's network thread with the GIL held, and that thread may be waiting for
# the GIL in a callback of another session: a deadlock of 10 s or more, at any garbage collection. So closed sessions of
# simulators are kept, 16 kB each. Delete this when zenoh-python drops sessions without the GIL.
_never_deallocated: Final[list[zenoh.Session]] = []


DEFAULT_OPTIONS: Final = SessionOptions()


def enclave_of(options: SessionOptions) -> Enclave | None:
    """Return the enclave that the options choose; None for open sessions.

    Raises:
        BadOptions: There is no such enclave, or it can't be used.
    """
    if options.secure is None:
        if options.role is not None:
            raise BadOptions(f"--role {options.role}: it is for --secure DIR, which is missing")
        return None
    found = find_enclave(options.secure, options.role or options.default_role)
    found.check()
    return found


def open_client(options: SessionOptions = DEFAULT_OPTIONS) -> zenoh.Session:
    """Return a session for a tool; close it, or the process may not end.

    Connects within the timeout, unless it only listens: then the simulator has to connect.

    Raises:
        SimulatorNotFound: No peer answers at the endpoints.
        ConnectionDenied: A peer answers but rejects the connection.
        PortTaken: Another process listens on the endpoint.
        BadOptions: An endpoint, the configuration or the enclave is invalid.
    """
    return _Opening(options).open()


def open_server(
    options: SessionOptions = DEFAULT_OPTIONS, *, join: bool = False, max_message: int = MAX_MESSAGE
) -> tuple[zenoh.Session, tuple[str, ...]]:
    """Return a session for a simulator, and the endpoints that it listens on.

    Close it, or the process may not end. Port 0 becomes a free port. With endpoints to connect to and none to listen
    on, it doesn't listen.

    Args:
        options: The session options.
        join: Whether to join, as a peer, another Zenoh that listens at the default endpoint: clients of a router there,
            such as ROS nodes, discover the simulator through it.
        max_message: The largest message that is received, in bytes, unless the configuration file has another limit.

    Raises:
        PortTaken: Another process listens there.
        SimulatorNotFound: The session only connects, and no peer answers.
        BadOptions: An endpoint or the configuration is invalid.
    """
    opening = _Opening(replace(options, default_role=SIMULATOR), max_message=max_message)
    try:
        return opening.serve()
    except PortTaken:
        if not (join and opening.is_default):
            raise
        there = options.default
        peer = replace(options, mode="peer", connect=(there,), listen=(_LOOPBACK,), timeout=_JOIN_TIMEOUT)
        try:
            session, endpoints = _Opening(peer, max_message=max_message, must_connect=True).serve()
        except SimulatorNotFound:
            pass  # it is no Zenoh that listens there
        else:
            # A warning, since a lower level would be lost before logging is set up.
            _log.warning("another Zenoh listens on %s; joining it, and listening on %s", there, _listed(endpoints))
            return session, endpoints
        raise


class _Opening:
    """The opening of a session by its options, with defaults from the configuration file.

    Args:
        max_message: The largest message that a simulator's session receives, in bytes; None for the session of a tool.
        must_connect: Whether the session has to connect although it listens.

    Attributes:
        is_default: Whether nothing says where and how to open it.
    """

    def __init__(self, options: SessionOptions, *, max_message: int | None = None, must_connect: bool = False) -> None:
        if not options.timeout > 0:
            raise BadOptions(f"--timeout must be positive, got {options.timeout} s")
        for flag, endpoints in (("--connect", options.connect), ("--listen", options.listen)):
            for endpoint in endpoints:
                check_endpoint(flag, endpoint)
        self._config = base_config(options.zenoh_config)
        self._timeout = options.timeout
        self._max_message = max_message
        self._must_connect = must_connect
        self._enclave = enclave_of(options)
        self._is_stranger = not (self._enclave or options.zenoh_config)
        mode = options.mode or json.loads(self._config.get_json("mode"))
        self._connect: tuple[Any, ...] = options.connect or _endpoints(self._config, "connect", mode)
        # The configuration of a simulator listens; a client that is given the same one does not.
        found = () if options.mode == "client" else _endpoints(self._config, "listen", mode)
        self._listen: tuple[Any, ...] = options.listen or found
        if self._enclave:
            _check_encrypted("--connect", self._connect)
            _check_encrypted("--listen", self._listen)
        self.is_default = not (self._connect or self._listen or self._enclave) and mode in {None, "peer"}
        serves = max_message is not None
        if not (self._connect or self._listen):
            default = encrypted(options.default) if self._enclave else options.default
            if serves and mode != "client":
                self._listen = (default,)
            else:
                self._connect = (default,)
        self._mode: str = mode or ("client" if not self._listen else "router" if serves else "peer")
        self._advice = "start a Zenoh router there or give another" if serves else _ADVICE

    def open(self) -> zenoh.Session:
        """Open the session."""
        if self._mode == "client" and self._listen:
            raise BadOptions(f"mode 'client' can't listen on {_listed(self._listen)}; use 'peer' or 'router'")
        if self._mode == "client" and not self._connect:
            raise BadOptions("mode 'client' needs an endpoint; give one with --connect")
        for key, value in self._values().items():
            self._insert(key, value)
        if self._is_stranger and len(self._connect) == 1 and str(self._connect[0]).startswith("tls/"):
            # It would try for the whole timeout.
            self._check_denied()
        try:
            return self._open_in_turn() if self._has_choice else self._try()
        except SimulatorNotFound:
            self._check_denied()
            raise

    def serve(self) -> tuple[zenoh.Session, tuple[str, ...]]:
        """Open a session that stays alive in memory, with port 0 made free ports; return its endpoints, too."""
        wanted = self._listen
        for tries_left in reversed(range(_PORT_TRIES)):
            self._listen = tuple(with_port(str(endpoint)) for endpoint in wanted)
            try:
                session = self.open()
            except PortTaken:
                # Another process may have taken the free port meanwhile.
                if self._listen == tuple(wanted) or not tries_left:
                    raise
            else:
                _never_deallocated.append(session)
                return session, self._listen
        raise AssertionError

    def _check_denied(self) -> None:
        """Check that no process at the endpoints refuses this one.

        Raises:
            ConnectionDenied: One does.
        """
        for endpoint in map(str, self._connect):
            if why := why_denied(endpoint, self._enclave):
                who = f", with the certificate of {self._enclave.name!r}" if self._enclave else ""
                raise ConnectionDenied(f"denied by {endpoint}{who}: {why}") from None

    @property
    def _has_choice(self) -> bool:
        """True if the session may connect to any one of several endpoints."""
        return len(self._connect) > 1 and not self._listen

    def _open_in_turn(self) -> zenoh.Session:
        """Try all endpoints in turn, with increasing timeouts, until one answers or the whole timeout is over."""
        end = time.monotonic() + self._timeout
        patience, pause = _FIRST_TRY, _RETRY["period_init_ms"] / 1000
        while True:
            share = max(end - time.monotonic(), 0.0) / len(self._connect)
            self._insert(_OPEN_TIMEOUT_KEY, round(min(patience, share) * 1000) or 1)
            try:
                return self._try()
            except SimulatorNotFound:
                if time.monotonic() + pause >= end:
                    raise
            time.sleep(pause)
            patience *= 2
            pause = min(pause * _RETRY["period_increase_factor"], _RETRY["period_max_ms"] / 1000)

    def _try(self) -> zenoh.Session:
        try:
            session = zenoh.open(self._config)
        except zenoh.ZError as error:
            raise self._translated(error) from None
        if self._has_choice and not (session.info.routers_zid() or session.info.peers_zid()):
            session.close()
            raise self._not_found()
        return session

    def _values(self) -> dict[str, object]:
        values: dict[str, object] = {
            "mode": self._mode,
            "connect/endpoints": self._connect,
            "listen/endpoints": self._listen,
            "connect/retry": _RETRY,
            "listen/exit_on_failure": True,
            "scouting/multicast/enabled": False,
            "timestamping/enabled": True,
            # Implicit shared memory can fail under load: https://github.com/eclipse-zenoh/zenoh/issues/2628
            "transport/shared_memory/enabled": False,
        }
        if self._must_connect or not self._listen:
            # A listening session does not need its connections, nor a peer all of them: Zenoh keeps trying.
            values["connect/exit_on_failure"] = not self._has_choice
            once = self._has_choice and self._mode == "client"
            values["connect/timeout_ms"] = 0 if once else round(self._timeout * 1000)
        if not self._connect:
            # A router waits this long for scouting, which is off.
            values["scouting/delay"] = 0
        if self._enclave:
            values |= self._enclave.session()
        if self._max_message is not None:
            values[_WAIT_BEFORE_CLOSE_KEY] = _WAIT_BEFORE_CLOSE
            if _is_default(self._config, _MAX_MESSAGE_KEY):
                values[_MAX_MESSAGE_KEY] = self._max_message
        return values

    def _insert(self, key: str, value: object) -> None:
        try:
            self._config.insert_json5(key, json.dumps(value))
        except zenoh.ZError as error:
            raise BadOptions(f"Zenoh rejects {value!r} for {key}: {first_line(error)}") from None

    def _translated(self, error: zenoh.ZError) -> BadOptions | PortTaken | SimulatorNotFound:
        text = first_line(error)
        if "in use" in text:
            taken = tuple(endpoint for endpoint in self._listen if str(endpoint) in text) or self._listen
            return PortTaken(
                f"{_listed(taken)} is in use; give another endpoint with --listen, or join it with --connect",
            )
        if "Unable to connect" in text:
            return self._not_found()
        return BadOptions(f"can't open a Zenoh session: {text}")

    def _not_found(self) -> SimulatorNotFound:
        return SimulatorNotFound(f"no answer from {_listed(self._connect)}; {self._advice} with --connect")


def encrypted(endpoint: str) -> str:
    """Return an endpoint with TLS."""
    return f"{ENCRYPTED[0]}/{endpoint.partition('/')[2]}"


def _check_encrypted(flag: str, endpoints: tuple[Any, ...]) -> None:
    for endpoint in map(str, endpoints):
        if endpoint.partition("/")[0] not in ENCRYPTED:
            raise BadOptions(f"{flag} {endpoint!r} is not encrypted; with --secure it is {encrypted(endpoint)}")
        if flag == "--connect" and "/[" in endpoint:
            # Zenoh takes the address for a name of DNS, and would try in vain until the timeout.
            raise BadOptions(
                f"--connect {endpoint!r}: Zenoh checks no certificate at an IPv6 address; give the name of the host, "
                "such as localhost"
            )


def _listed(endpoints: tuple[Any, ...]) -> str:
    return ", ".join(str(endpoint) for endpoint in endpoints)


def _endpoints(config: zenoh.Config, side: str, mode: str | None) -> tuple[Any, ...]:
    """Return a configuration's endpoints of one side, in Zenoh's form; none if they are Zenoh's defaults."""
    if _is_default(config, f"{side}/endpoints"):
        return ()
    found = json.loads(config.get_json(f"{side}/endpoints"))
    if isinstance(found, dict):
        found = found.get(mode or "", [])
    return tuple(found)


def _is_default(config: zenoh.Config, key: str) -> bool:
    return bool(json.loads(config.get_json(key)) == json.loads(zenoh.Config().get_json(key)))


@contextmanager
def unless_closed() -> Iterator[None]:
    """Turn Zenoh's error about a closed session into that of a closed client.

    Raises:
        ClientClosed: The session is closed.
    """
    try:
        yield
    except zenoh.ZError:
        raise ClientClosed("the client is closed") from None
