"""A snapshot of the network."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Literal

from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.ros2.keys import Kind
from hmrsim_zenoh.ros2.names import Names
from hmrsim_zenoh.server.tokens import MAX_TOKENS
from hmrsim_zenoh.wire.options import DEFAULT_ENDPOINT

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.keys import Endpoint, Token, TypeHash
    from hmrsim_zenoh.wire.enclave import Enclave

OFFER: Final = (Kind.SERVICE, Kind.PUBLISHER)
"""Endpoints that serve or publish."""
WANT: Final = (Kind.CLIENT, Kind.SUBSCRIBER)
"""Endpoints that send requests or subscribe."""

_ACTION: Final = "/_action/"
_DEFAULTS: Final = (DEFAULT_ENDPOINT, DEFAULT_ENDPOINT.replace("127.0.0.1", "localhost"))


@dataclass(frozen=True)
class Simulator:
    """The simulator with the requested prefix.

    Attributes:
        info: Its description, ``_world/info``.
        session: The Zenoh id of its session, in hex.
        twins: The session ids of other simulators with the same prefix.
        times: The state of its clock at the beginning and at the end of the observation.
        watched: Wall seconds between the two.
        alive: The robots that have a liveliness token.
        tokens: The participants in lockstep that have a liveliness token.
        trees: The states of behavior trees by robot, as controllers publish them.
    """

    info: Mapping[str, Any]
    session: str = ""
    twins: tuple[str, ...] = ()
    times: tuple[Mapping[str, Any], ...] = ()
    watched: float = 0.0
    alive: frozenset[str] = frozenset()
    tokens: frozenset[str] = frozenset()
    trees: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def time(self) -> Mapping[str, Any]:
        """The latest state of its clock."""
        return self.times[-1] if self.times else {}

    @cached_property
    def robots(self) -> dict[str, list[str]]:
        """The actions of each robot."""
        return {robot["name"]: list(robot.get("actions", ())) for robot in self.info.get("robots", ())}

    @property
    def lost(self) -> list[str]:
        """The robots that can't be reached; none in worlds that are too large for tokens."""
        if len(self.robots) > MAX_TOKENS:
            return []
        return [robot for robot in self.robots if robot not in self.alive]

    @cached_property
    def names(self) -> Names:
        """The ROS names of its actions."""
        return Names({**self.robots, WORLD: list(self.info.get("actions", ()))}, self.info.get("aliases", {}))


class Domain:
    """The nodes and endpoints of one of ROS's domains.

    Args:
        tokens: The tokens of the domain.
        session: The session of the simulator; empty if there is none.
    """

    def __init__(self, tokens: Iterable[Token] = (), session: str = "") -> None:
        self.tokens = tuple(tokens)
        self.ours = tuple(token for token in self.tokens if token.session == session)
        self.others = tuple(token for token in self.tokens if token.session != session)

    @cached_property
    def types(self) -> Mapping[str, set[TypeHash]]:
        """Types and hashes that are served or published, by name."""
        return _types(self.tokens)

    @cached_property
    def simulator_types(self) -> Mapping[str, set[TypeHash]]:
        """Types and hashes that the simulator serves or publishes, by name."""
        return _types(self.ours)


def _types(tokens: Iterable[Token]) -> Mapping[str, set[TypeHash]]:
    found: defaultdict[str, set[TypeHash]] = defaultdict(set)
    for _, endpoint in endpoints(tokens, *OFFER):
        found[endpoint.name].add((endpoint.type, endpoint.hash))
    return dict(found)


def endpoints(tokens: Iterable[Token], *kinds: Kind) -> Iterator[tuple[Token, Endpoint]]:
    """Yield the endpoints of some kinds, or all of them."""
    for token in tokens:
        if token.endpoint is not None and (not kinds or token.endpoint.kind in kinds):
            yield token, token.endpoint


def collapsed(names: Iterable[str]) -> list[str]:
    """Return names with the parts of each action collapsed into the action."""
    return sorted({name.partition(_ACTION)[0] for name in names})


@dataclass(frozen=True)
class Snapshot:
    """Everything that was found on the network.

    Attributes:
        endpoints: The endpoints of the session.
        prefix: The requested prefix.
        domain: The requested ROS domain id.
        environment: The environment variables of ROS and Zenoh.
        wants_ros: Whether the user works with ROS, according to the command line.
        routers: The Zenoh ids of the connected routers, in hex.
        peers: The Zenoh ids of the other connected peers.
        prefixes: The prefixes of all simulators.
        simulator: The simulator with the requested prefix.
        tokens: The tokens in each ROS domain.
        unreadable: Tokens below ROS's prefix in an unknown format.
        enclave: The enclave of this session; None where sessions are open.
        names: The names on the certificates of connected sessions, by their Zenoh ids, in hex.
    """

    endpoints: tuple[str, ...] = ()
    prefix: str = "hmrsim"
    domain: int = 0
    environment: Mapping[str, str] = field(default_factory=dict)
    wants_ros: bool = False
    routers: tuple[str, ...] = ()
    peers: tuple[str, ...] = ()
    prefixes: tuple[str, ...] = ()
    simulator: Simulator | None = None
    tokens: Mapping[int, tuple[Token, ...]] = field(default_factory=dict)
    unreadable: tuple[str, ...] = ()
    enclave: Enclave | None = None
    names: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def domains(self) -> dict[int, Domain]:
        """The ROS domains by their ids, in ascending order."""
        session = self.simulator.session if self.simulator else ""
        return {domain: Domain(tokens, session) for domain, tokens in sorted(self.tokens.items())}

    @cached_property
    def ros(self) -> Domain:
        """The ROS domain that the user asked for."""
        return self.domains.get(self.domain, Domain())

    @property
    def uses_ros(self) -> bool:
        """True if the user asked for ROS, or the environment or the network shows signs of it."""
        return (
            self.wants_ros
            or any(name.startswith(("ROS_", "RMW_")) for name in self.environment)
            or any(domain.others for domain in self.domains.values())
        )

    @property
    def where(self) -> str:
        """The endpoints as text, separated by commas."""
        return ", ".join(self.endpoints)

    @property
    def command(self) -> str:
        """The command that starts a simulator there; at the default endpoint it joins a running Zenoh by itself."""
        elsewhere = [endpoint for endpoint in self.endpoints if endpoint not in _DEFAULTS]
        return f"`hmrsim run WORLD --ros2{''.join(f' --connect {endpoint}' for endpoint in elsewhere[:1])}`"


_SHOWN: Final = 4
"""The number of names that a message lists."""


@dataclass(frozen=True)
class Problem:
    """A problem on the network.

    Attributes:
        kind: A machine-readable word, such as ``no_router``.
        severity: A ``warning`` may be intended.
    """

    kind: str
    text: str
    remedy: str
    severity: Literal["error", "warning"] = "error"


def first_few(names: Iterable[str]) -> str:
    """Return the first few names and the number of the others, as text."""
    every = list(names)
    shown = every if len(every) <= _SHOWN + 1 else every[:_SHOWN]
    more = len(every) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")
