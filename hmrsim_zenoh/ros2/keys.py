"""Spelling and parsing of rmw_zenoh's keys and liveliness tokens, and the id of an endpoint from its token.

::

    <domain>/<name>/<type>/<hash>
    @ros2_lv/<domain>/<session>/<node>/<node>/NN/<enclave>/<namespace>/<node's name>
    @ros2_lv/<domain>/<session>/<node>/<endpoint>/<kind>/<enclave>/<namespace>/<node's name>/<name>/<type>/<hash>/<qos>

Inside a token every ``/`` of a name is a ``%``, and an empty part is a ``%``, too. A type is
``nav2_msgs::action::dds_::NavigateToPose_SendGoal_``. Names begin with a ``/`` here, as ROS's tools show them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Final, NamedTuple

import xxhash

MAX_DOMAIN: Final = 232
"""The highest domain id of ROS, given by the ports of DDS."""

DOMAINS: Final = {str(domain): domain for domain in range(MAX_DOMAIN + 1)}
"""All domains of ROS by their spelling."""

NO_HASH: Final = "TypeHashNotSupported"
"""The text in place of a hash in the keys of humble."""

TypeHash = tuple[str, str]
"""A type's name in keys, and its hash."""

_TOKENS: Final = "@ros2_lv"
_NODE_CHUNKS, _ENDPOINT_CHUNKS = 9, 13
_BUFFER_CHUNKS: Final = 14
"""From lyrical on, the tokens of some topics name the memory backends of their messages."""

_SHOWN_OF_ID: Final = 8
"""Digits that are shown of a client's id."""


class Kind(Enum):
    """The kind of entity that a token declares."""

    NODE = "NN"
    PUBLISHER = "MP"
    SUBSCRIBER = "MS"
    SERVICE = "SS"
    CLIENT = "SC"


_KINDS: Final = {kind.value: kind for kind in Kind}


DEFAULT_QOS: Final = "::,10:,:,:,,"
"""The quality of service of services, feedback and most topics, in tokens; the defaults of rmw_zenoh are omitted."""
LATCHED_QOS: Final = ":1:,1:,:,:,,"
"""The quality of service of latched topics: transient local, depth 1."""
TF_QOS: Final = "::,100:,:,:,,"
"""The quality of service of transforms."""

ROSOUT_QOS: Final = "::,1000:,:,:,,"
"""The quality of service of the log; that of a node of ROS keeps its lines for late subscribers, too."""
SENSOR_QOS: Final = "2::,5:,:,:,,"
"""The quality of service of sensor data: best effort, depth 5."""


class Node(NamedTuple):
    """A ROS node by its namespace and name.

    Attributes:
        namespace: Such as ``/wall_e``, or ``/``.
        name: Such as ``bt_navigator``.
    """

    namespace: str
    name: str

    @property
    def full_name(self) -> str:
        """The name as ``ros2 node list`` shows it."""
        return f"{self.namespace.rstrip('/')}/{self.name}"

    @property
    def robot(self) -> str:
        """The robot's name; empty for the world's node."""
        return self.namespace[1:]


@dataclass(frozen=True)
class Endpoint:
    """A publisher, a subscriber, a service or a client of one.

    Attributes:
        name: The topic's or the service's, such as ``/wall_e/navigate_to_pose/_action/status``.
        type: The type's name in keys, such as ``sensor_msgs::msg::dds_::BatteryState_``.
        qos: The quality of service as tokens spell it.
    """

    kind: Kind
    name: str
    type: str
    hash: str
    qos: str = DEFAULT_QOS


@dataclass(frozen=True)
class Token:
    """A parsed liveliness token of rmw_zenoh.

    Attributes:
        session: The Zenoh id of the session that declared it, in hex.
        endpoint: The node's endpoint; None for the token of the node itself.
    """

    session: str
    node: Node
    endpoint: Endpoint | None = None


@dataclass(frozen=True)
class Address:
    """A parsed key of rmw_zenoh.

    Attributes:
        name: The topic's or the service's, such as ``/wall_e/navigate_to_pose/_action/status``.
        type: The type's name in the key; empty on a wire without types.
        hash: The type's hash; empty on a wire without types.
    """

    name: str
    type: str = ""
    hash: str = ""

    @property
    def robot(self) -> str:
        """The name's first part, which is the robot's name if there are several."""
        return self.name.split("/")[1]


def key(domain: int, name: str, type_: str, hash_: str) -> str:
    """Return the key of a topic or a service."""
    return f"{domain}/{name.strip('/')}/{type_}/{hash_}"


def everything(domain: int) -> str:
    """Return the wildcard that all topics and services of a domain match."""
    return f"{domain}/**"


def read_key(domain: int, text: str) -> Address | None:
    """Return a parsed key; None when it is not of this domain."""
    head, *name, type_, hash_ = text.split("/") if text.count("/") > 2 else ("", "", "")  # noqa: PLR2004 - four parts
    if head != str(domain) or not all(name):
        return None
    return Address("/" + "/".join(name), type_, hash_)


def node_token(domain: int, session: str, node_id: int, node: Node) -> str:
    """Return the token of a node."""
    return "/".join((*_head(domain, session, node_id, node_id), Kind.NODE.value, *_node(node)))


def endpoint_token(domain: int, session: str, ids: tuple[int, int], node: Node, endpoint: Endpoint) -> str:
    """Return the token of an endpoint; *ids* are the node's and the endpoint's, counted together in a session."""
    described = (_mangled(endpoint.name), endpoint.type, endpoint.hash, endpoint.qos)
    return "/".join((*_head(domain, session, *ids), endpoint.kind.value, *_node(node), *described))


def all_tokens(domain: int) -> str:
    """Return the wildcard of all tokens of a domain."""
    return f"{_TOKENS}/{domain}/**"


def tokens_of(domain: int, kind: Kind, session: str = "*") -> str:
    """Return the wildcard of the tokens of one kind in a domain, of one session or of all."""
    return f"{_TOKENS}/{domain}/{session}/*/*/{kind.value}/**"


def publishers_of(domain: int, topic: str) -> str:
    """Return the wildcard of the tokens of a topic's publishers in a domain."""
    return f"{_TOKENS}/{domain}/*/*/*/{Kind.PUBLISHER.value}/*/*/*/{_mangled(topic)}/**"


def tokens_of_node(node: Node) -> str:
    """Return the wildcard of the tokens of a node in all domains and sessions."""
    return "/".join((_TOKENS, "*", "*", "*", "*", Kind.NODE.value, *_node(node)))


def domain_of(token: str) -> str:
    """Return the domain in a token."""
    return token.split("/")[1]


def read_token(text: str) -> Token | None:
    """Return a parsed token; None when it is not one of rmw_zenoh's."""
    chunks = text.split("/")
    if chunks[0] != _TOKENS or len(chunks) < _NODE_CHUNKS or chunks[5] not in _KINDS:
        return None
    session, kind, (namespace, name) = chunks[2], _KINDS[chunks[5]], chunks[7:9]
    node = Node(_plain(namespace) or "/", _plain(name))
    if kind is Kind.NODE:
        return Token(session, node) if len(chunks) == _NODE_CHUNKS else None
    if len(chunks) not in (_ENDPOINT_CHUNKS, _BUFFER_CHUNKS):
        return None
    topic, type_, hash_, qos = chunks[9:13]
    return Token(session, node, Endpoint(kind, _plain(topic), type_, hash_, qos))


def gid(token: str) -> bytes:
    """Return the gid of a token's endpoint in ROS: the token's XXH3 hash, 16 bytes."""
    return xxhash.xxh3_128_intdigest(token.encode()).to_bytes(16, "little")


def numbered(gid: str) -> str:
    """Return the name of a client whose node is unknown, by its gid in hex; empty if it has none."""
    return f"client {gid[:_SHOWN_OF_ID]}" if gid else "a client without an id"


def _head(domain: int, *ids: object) -> Iterable[str]:
    return (_TOKENS, str(domain), *map(str, ids))


def _node(node: Node) -> Iterable[str]:
    namespace = node.namespace if node.namespace != "/" else ""
    return ("%", _mangled(namespace), _mangled(node.name))


def _mangled(name: str) -> str:
    return name.replace("/", "%") or "%"


def _plain(chunk: str) -> str:
    return chunk.replace("%", "/") if chunk != "%" else ""
