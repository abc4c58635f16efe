"""How rmw_zenoh spells keys and liveliness tokens, both ways, and the id that an endpoint has by its token.

::

    <domain>/<name>/<type>/<hash>
    @ros2_lv/<domain>/<session>/<node>/<node>/NN/<enclave>/<namespace>/<node's name>
    @ros2_lv/<domain>/<session>/<node>/<endpoint>/<kind>/<enclave>/<namespace>/<node's name>/<name>/<type>/<hash>/<qos>

Inside a token every ``/`` of a name is a ``%``, and what is empty is a ``%``, too. A type is
``nav2_msgs::action::dds_::NavigateToPose_SendGoal_``. Names begin with a ``/`` here, as ROS's tools show them.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Final, NamedTuple

import xxhash

if TYPE_CHECKING:
    from collections.abc import Iterable

MAX_DOMAIN: Final = 232
"""ROS takes no higher domain id; with DDS the ports end there."""

DOMAINS: Final = {str(domain): domain for domain in range(MAX_DOMAIN + 1)}
"""All of ROS's domains, by how they are written."""

NO_HASH: Final = "TypeHashNotSupported"
"""What stands for the hash in the keys of humble."""

TypeHash = tuple[str, str]
"""A type as keys have it, and its hash."""

_TOKENS: Final = "@ros2_lv"
_NODE_CHUNKS, _ENDPOINT_CHUNKS = 9, 13
_BUFFER_CHUNKS: Final = 14
"""From lyrical on some topics' tokens say which memory their messages may be in."""


class Kind(Enum):
    """What a token tells of."""

    NODE = "NN"
    PUBLISHER = "MP"
    SUBSCRIBER = "MS"
    SERVICE = "SS"
    CLIENT = "SC"


_KINDS: Final = {kind.value: kind for kind in Kind}


DEFAULT_QOS: Final = "::,10:,:,:,,"
"""The quality of service of services, feedback and most topics, as tokens say it: rmw_zenoh's own is left out."""
LATCHED_QOS: Final = ":1:,1:,:,:,,"
"""The quality of service of latched topics: transient local, depth 1."""
TF_QOS: Final = "::,100:,:,:,,"
"""Of transforms."""


class Node(NamedTuple):
    """A ROS node.

    Attributes:
        namespace: Such as ``/wall_e``, or ``/``.
        name: Such as ``bt_navigator``.
    """

    namespace: str
    name: str

    @property
    def full_name(self) -> str:
        """Its name as ``ros2 node list`` shows it."""
        return f"{self.namespace.rstrip('/')}/{self.name}"


@dataclass(frozen=True)
class Endpoint:
    """A publisher, a subscriber, a service or a client of one.

    Attributes:
        kind: Which of them.
        name: The topic's or the service's, such as ``/wall_e/navigate_to_pose/_action/status``.
        type: The type's name as keys have it, such as ``sensor_msgs::msg::dds_::BatteryState_``.
        hash: The type's hash.
        qos: The quality of service as tokens have it.
    """

    kind: Kind
    name: str
    type: str
    hash: str
    qos: str = DEFAULT_QOS


@dataclass(frozen=True)
class Token:
    """What a liveliness token tells.

    Attributes:
        session: The Zenoh id of the session that declared it, in hex.
        node: The node.
        endpoint: What the node has there; None for the token of the node itself.
    """

    session: str
    node: Node
    endpoint: Endpoint | None = None


@dataclass(frozen=True)
class Address:
    """What a key is about.

    Attributes:
        name: The topic's or the service's, such as ``/wall_e/navigate_to_pose/_action/status``.
        type: The type's name in the key; empty where keys have none.
        hash: The type's hash, likewise.
    """

    name: str
    type: str = ""
    hash: str = ""


def key(domain: int, name: str, type_: str, hash_: str) -> str:
    """Return the key of a topic or a service."""
    return f"{domain}/{name.strip('/')}/{type_}/{hash_}"


def everything(domain: int) -> str:
    """Return the wildcard that all topics and services of a domain match."""
    return f"{domain}/**"


def read_key(domain: int, text: str) -> Address | None:
    """Return what a key is about; None when it is none of this domain's."""
    head, *name, type_, hash_ = text.split("/") if text.count("/") > 2 else ("", "", "")  # noqa: PLR2004 - four parts
    if head != str(domain) or not all(name):
        return None
    return Address("/" + "/".join(name), type_, hash_)


def node_token(domain: int, session: str, node_id: int, node: Node) -> str:
    """Return the token of a node."""
    return "/".join((*_head(domain, session, node_id, node_id), Kind.NODE.value, *_node(node)))


def endpoint_token(domain: int, session: str, ids: tuple[int, int], node: Node, endpoint: Endpoint) -> str:
    """Return the token of what a node has; *ids* are the node's and its own, counted together in a session."""
    described = (_mangled(endpoint.name), endpoint.type, endpoint.hash, endpoint.qos)
    return "/".join((*_head(domain, session, *ids), endpoint.kind.value, *_node(node), *described))


def all_tokens(domain: int) -> str:
    """Return the wildcard of all tokens of a domain."""
    return f"{_TOKENS}/{domain}/**"


def read_token(text: str) -> Token | None:
    """Return what a token tells; None when it is none of rmw_zenoh's."""
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
    """Return the 16 bytes by which ROS knows the endpoint of a token: its XXH3 hash."""
    return xxhash.xxh3_128_intdigest(token.encode()).to_bytes(16, "little")


def _head(domain: int, *ids: object) -> Iterable[str]:
    return (_TOKENS, str(domain), *map(str, ids))


def _node(node: Node) -> Iterable[str]:
    namespace = node.namespace if node.namespace != "/" else ""
    return ("%", _mangled(namespace), _mangled(node.name))


def _mangled(name: str) -> str:
    return name.replace("/", "%") or "%"


def _plain(chunk: str) -> str:
    return chunk.replace("%", "/") if chunk != "%" else ""
