"""A check that a running simulator enforces a security policy: members and strangers send it requests.

The requests change nothing: they are unreadable, so the simulator answers with an error if access control lets them
through.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from hmrsim_zenoh.errors import BadOptions, SimulatorNotFound
from hmrsim_zenoh.security.authority import Authority
from hmrsim_zenoh.security.keystore import SESSION
from hmrsim_zenoh.wire.enclave import AUTHORITY, SIMULATOR
from hmrsim_zenoh.wire.keys import Keys, Verb
from hmrsim_zenoh.wire.session import open_client

if TYPE_CHECKING:
    import zenoh

    from hmrsim_zenoh.security.keystore import Keystore
    from hmrsim_zenoh.wire.enclave import Member
    from hmrsim_zenoh.wire.options import SessionOptions

_UNREADABLE: Final = b"[]"
"""A payload that is no valid request."""
_OF_ROS: Final = "wait/_action/send_goal/nav2_msgs::action::dds_::Wait_SendGoal_/RIHS01_0"
"""The end of a ROS key with a type that no distribution has, so that its goals are rejected."""
_EARLIER: Final = "@adv/**?_anyke"
"""The end of a selector for earlier values, which all members may query."""
_ATTACHMENT: Final = struct.pack("<qqB16s", 1, 0, 16, bytes(16))
"""The attachment of a ROS request."""
_PATIENCE: Final = 3.0
"""Wall seconds for an answer."""
_OPENING: Final = 0.5
"""Wall seconds for which a stranger tries to connect."""
_UNKNOWN: Final = "mallory"
"""The name in a certificate that the authority has signed but that belongs to no member."""


@dataclass(frozen=True)
class Attempt:
    """A request that a member or a stranger has sent, and its outcome.

    Attributes:
        who: The name of the member, or a description of the stranger.
        what: A description of the request.
        expected: Whether the policy of the keystore allows the request.
        done: Whether the simulator let the request through.
    """

    who: str
    what: str
    expected: bool
    done: bool

    @property
    def as_expected(self) -> bool:
        """True if the simulator enforces the policy in this case."""
        return self.expected == self.done


def attempts(store: Keystore, options: SessionOptions) -> Iterator[Attempt]:
    """Send all requests, and yield the outcome of each; this takes some seconds.

    Args:
        store: The complete keystore, with its authority and the enclaves of all members.
        options: Only the endpoint of the simulator is used.

    Raises:
        SimulatorNotFound: No simulator answers.
        BadOptions: The keystore is incomplete.
    """
    options = replace(options, prefix=store.network.prefix)
    members = [member for member in store.members.values() if member.role != SIMULATOR]
    if not members:
        raise BadOptions(f"{store.path} has no clients; add some with `hmrsim security add`")
    keys = Keys(store.network.prefix)
    robots = _robots(store, members, keys, options)
    domain = store.network.domain
    for member in members:
        with open_client(replace(options, secure=store.enclave(member.name).folder)) as session:
            # Read all replies, since unread ones would block the session.
            nodes = list(session.liveliness().get(f"@ros2_lv/{domain}/**", timeout=_PATIENCE))
            requests = list(_requests(keys, robots, member))
            if nodes:
                requests += [
                    (f"sends a goal to {robot} over ROS 2", f"{domain}/{robot}/{_OF_ROS}")
                    for robot in _own_and_other(robots, member)
                ]
            for what, request_key in requests:
                allowed = store.access_control.may_query(member.name, request_key).allowed
                yield Attempt(member.name, what, allowed, _is_answered(session, request_key))
            earlier = _is_answered(session, f"{_goal_key(keys, robots[0])}/{_EARLIER}")
            yield Attempt(member.name, "sends a goal as if to read earlier values", expected=False, done=earlier)
    key = _goal_key(keys, robots[0])
    with TemporaryDirectory(prefix="hmrsim-") as folder:
        for who, stranger in _strangers(store, Path(folder), options):
            done = _stranger_is_answered(stranger, key)
            yield Attempt(who, f"sends a goal to {robots[0]}", expected=False, done=done)


def _robots(store: Keystore, members: Sequence[Member], keys: Keys, options: SessionOptions) -> list[str]:
    with open_client(replace(options, secure=store.enclave(members[0].name).folder)) as session:
        for reply in session.get(keys.world("info"), timeout=options.timeout):
            if reply.ok is not None:
                robots = json.loads(reply.ok.payload.to_bytes()).get("robots", ())
                return [str(robot["name"]) for robot in robots] or ["wall_e"]
    raise SimulatorNotFound(
        f"no simulator with the prefix {keys.prefix!r} answers {members[0].name!r}; "
        "is it started with --secure and this keystore, or one that is younger?"
    )


def _requests(keys: Keys, robots: Sequence[str], member: Member) -> Iterator[tuple[str, str]]:
    """Yield the requests that a member sends: a description and the key of each."""
    yield "reads the description of the world", keys.world("info")
    for robot in _own_and_other(robots, member):
        yield f"sends a goal to {robot}", _goal_key(keys, robot)
        yield f"executes a goal of {robot}", keys.action(robot, "wait", Verb.EXECUTE)
        yield f"cancels goals of {robot}", keys.action(robot, "wait", Verb.CANCEL_GOAL)
    yield "sends a goal to any robot at once", _goal_key(keys, "*")
    for service in ("delete_entity", "inject_fault", *member.services):
        yield f"calls {service}", keys.world(service)
    yield "changes the clock", keys.world("time/set")
    yield "advances time with goals of any robots", keys.world("time/advance")


def _own_and_other(robots: Sequence[str], member: Member) -> list[str]:
    """Return a robot that a member may drive and, if there is one, a robot that it may not drive."""
    own = next((robot for robot in robots if robot in member.robots), robots[0])
    others = [robot for robot in robots if robot not in member.robots] if member.robots else []
    return [own, *others[:1]]


def _goal_key(keys: Keys, robot: str) -> str:
    return keys.action(robot, "wait", Verb.SEND_GOAL)


def _is_answered(session: zenoh.Session, key: str) -> bool:
    """Send a request; return whether the simulator answers, even if with an error."""
    payload = None if key.endswith("/info") else _UNREADABLE
    attachment = _ATTACHMENT if key.endswith(_OF_ROS) else None
    replies = session.get(key, payload=payload, attachment=attachment, timeout=_PATIENCE)
    # The simulator's errors are JSON, unlike Zenoh's timeout.
    return any(reply.err is None or reply.err.payload.to_bytes().startswith(b"{") for reply in replies)


def _strangers(store: Keystore, folder: Path, options: SessionOptions) -> Iterator[tuple[str, SessionOptions]]:
    """Yield each stranger: a description, and the options of its session."""
    options = replace(options, timeout=_OPENING)

    def with_certificate(name: str, days: float, authority: Callable[[], Authority] | None = None) -> SessionOptions:
        """Return the options of a stranger whose certificate has a name and is valid for some days."""
        enclave = store.stranger(name, days, folder / f"{name}{days:g}", authority() if authority else None)
        return replace(options, zenoh_config=enclave.folder / SESSION)

    known = next(member.name for member in store.members.values() if member.role != SIMULATOR)
    yield f"the name {known!r} by another authority", with_certificate(known, 1.0, lambda: Authority.create(1.0)[0])
    yield f"{known!r}, expired", with_certificate(known, -1.0)
    yield f"{_UNKNOWN!r}, who is no member", with_certificate(_UNKNOWN, 1.0)
    for name in store.revoked:
        yield f"{name!r}, revoked", with_certificate(name, 1.0)
    bare = folder / "none.json5"
    tls: dict[str, Any] = {"root_ca_certificate": str(store.path.resolve() / "public" / AUTHORITY)}
    bare.write_text(json.dumps({"transport": {"link": {"tls": tls}}}), encoding="utf-8")
    yield "a stranger without a certificate", replace(options, zenoh_config=bare)
    plain = tuple(f"tcp/{endpoint.partition('/')[2]}" for endpoint in options.connect or (options.default,))
    yield "a stranger without TLS", replace(options, connect=plain)


def _stranger_is_answered(options: SessionOptions, key: str) -> bool:
    """Send a request as a stranger; return whether the simulator answers."""
    if not options.connect:
        options = replace(options, connect=(f"tls/{options.default.partition('/')[2]}",))
    with suppress(SimulatorNotFound), open_client(options) as session:
        return _is_answered(session, key)
    return False
