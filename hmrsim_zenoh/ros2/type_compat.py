"""Type compatibility between a client and a server: the hashes of each distribution, and remedies for differences."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from hmrsim.actions import registry as all_actions
from hmrsim.protocol.goal import WORLD
from hmrsim.services import registry as all_services
from hmrsim_zenoh.ros2.codec.types import DISTROS
from hmrsim_zenoh.ros2.keys import NO_HASH, Node
from hmrsim_zenoh.ros2.names import LOCALIZATION, MAP_SERVER, WORLD_NODE
from hmrsim_zenoh.ros2.publishing.endpoints import TOPICS, Endpoints, Part
from hmrsim_zenoh.ros2.wires import RmwZenoh

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.keys import TypeHash


class Difference(NamedTuple):
    """A difference between the types of a client and a server."""

    what: str
    remedy: str


@cache
def known() -> Mapping[str, Mapping[str, tuple[str, ...]]]:
    """Return the distributions that have a type with a hash: by the type's name in keys, and by the hash."""
    result: defaultdict[str, dict[str, tuple[str, ...]]] = defaultdict(dict)
    for distro in DISTROS:
        for type_, hash_ in _all_of(distro):
            result[type_][hash_] = (*result[type_].get(hash_, ()), distro)
    return dict(result)


def distros_of(served: Collection[TypeHash]) -> tuple[str, ...]:
    """Return the distributions whose types are all served, ignoring names that are not served at all."""
    names = {type_ for type_, _ in served} & known().keys()
    return tuple(
        distro
        for distro in DISTROS
        if names and all(any((type_, hash_) in served for hash_ in _hashes(type_, distro)) for type_ in names)
    )


def difference(theirs: TypeHash, ours: Collection[TypeHash], *, simulator: bool = True) -> Difference:
    """Return the difference between the types of a client and a server, and a remedy."""
    type_, hash_ = theirs
    by_hash = known().get(type_, {})
    # In order of the distributions.
    hashes = sorted({each for name, each in ours if name == type_}, key=lambda each: (by_hash.get(each, ("~",)), each))
    if not hashes:
        types = " or ".join(sorted({ros_name(name) for name, _ in ours}))
        return Difference(f"its type is {ros_name(type_)}, the server's {types}", f"use {types}")
    served_hashes = ", ".join(_with_distros(type_, each) for each in hashes)
    what = f"its hash is {_with_distros(type_, hash_)}, the server's {served_hashes}"
    if hash_ == NO_HASH:
        return Difference(what, f"humble is not supported; use {_or(DISTROS)}")
    package = type_.partition("::")[0]
    distros = by_hash.get(hash_, ())
    if not simulator:
        return Difference(what, f"build client and server against the same {package}")
    if distros:
        return Difference(what, f"start `hmrsim run --ros2` with --ros-distro {distros[0]}, or without --ros-distro")
    served = [distro for each in hashes for distro in by_hash.get(each, ())]
    return Difference(what, f"build the client's workspace against {package} of {_or(served or DISTROS)}")


def ros_name(type_: str) -> str:
    """Return a type's name as ROS's tools show it: ``nav2_msgs/action/NavigateToPose_SendGoal``."""
    package, _, rest = type_.partition("::")
    kind, _, short = rest.partition("::dds_::")
    return f"{package}/{kind}/{short.removesuffix('_')}" if short else type_


def _hashes(type_: str, distro: str) -> Iterator[str]:
    return (hash_ for hash_, distros in known()[type_].items() if distro in distros)


def _with_distros(type_: str, hash_: str) -> str:
    if hash_ == NO_HASH:
        return f"{hash_} (humble)"
    return f"{hash_} ({', '.join(known().get(type_, {}).get(hash_, ())) or 'of an unknown distribution'})"


def _or(words: Iterable[str]) -> str:
    *most, last = dict.fromkeys(words)
    return f"{', '.join(most)} or {last}" if most else last


def _all_of(distro: str) -> set[TypeHash]:
    actions, services = all_actions(), all_services()
    named = tuple((f"/{name}", name) for name in actions)
    nodes = WORLD_NODE, MAP_SERVER, Node("/", LOCALIZATION)
    everything = Part(WORLD, named, tuple(TOPICS), (("/get_state", WORLD_NODE),), served=nodes)
    owned = Endpoints(RmwZenoh(distros=(distro,)), actions, services).of(everything)
    return {(endpoint.type, endpoint.hash) for _, endpoint in owned}
