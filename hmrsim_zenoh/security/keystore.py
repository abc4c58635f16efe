"""Keystores: the folder of ``hmrsim security``, with an authority, enclaves and their policy.

::

    keystore.json                     the members, and the names of revoked ones
    private/ca.key.pem                the authority's key, which no other machine needs
    public/ca.cert.pem
    enclaves/<name>/                  one for each member; copied to the machine that uses it
        enclave.json                  its name and role
        cert.pem, key.pem             its certificate and key
        ca.cert.pem                   the authority's certificate
        policy.json                   the policy, which simulators enforce
        session.json5                 the configuration of other programs' sessions, such as ROS nodes'

Folders have mode 0700, and files with keys 0600.
"""

from __future__ import annotations

import fcntl
import json
import os
import re
import shutil
import socket
import tempfile
from base64 import b64encode
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from hmrsim.diagnostics import shown
from hmrsim.errors import HmrsimError, printable, reason_of
from hmrsim.program.files import NO_SPACE, check_regular, unwritable
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.security.authority import Authority, Issued
from hmrsim_zenoh.security.roles import Rights
from hmrsim_zenoh.wire.access_control import AccessControl, trusting
from hmrsim_zenoh.wire.enclave import (
    AUTHORITY,
    CERTIFICATE,
    DESCRIPTION,
    ENCLAVES,
    KEY,
    POLICY,
    ROLES,
    SIMULATOR,
    Enclave,
    Member,
    parsed,
)
from hmrsim_zenoh.wire.keys import DEFAULT_PREFIX, Keys

DEFAULT_DAYS: Final = 365.0
"""How long certificates are valid, in days."""
SESSION: Final = "session.json5"
"""The configuration of other programs' sessions."""

_FILE: Final = "keystore.json"
_PRIVATE: Final = 0o600
_NAME: Final = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.~-]{0,63}")
_HOST: Final = re.compile(r"[A-Za-z0-9:]([A-Za-z0-9._:-]{0,251}[A-Za-z0-9])?")
_SERVES: Final = (SIMULATOR, "viewer", "operator")
"""Roles whose certificates are for servers, too: simulators, and the page of `hmrsim view`."""
_PORT: Final = 7447
_QUERY_TIMEOUT: Final = 600_000
"""In milliseconds, as rmw_zenoh has it."""


@dataclass(frozen=True)
class Network:
    """The network settings that all members of a keystore share.

    Attributes:
        prefix: The prefix of the simulator's keys.
        domain: ROS's domain id.
        hosts: The names and addresses at which simulators and pages are reached; the first is in `SESSION`.
    """

    prefix: str = DEFAULT_PREFIX
    domain: int = 0
    hosts: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check the prefix and the hosts.

        Raises:
            BadOptions: One of them is invalid.
        """
        try:
            Keys(self.prefix)
        except ValueError as error:
            raise BadOptions(f"--prefix: {error}") from None
        for host in self.hosts:
            if not _HOST.fullmatch(host):
                raise BadOptions(f"--host {host!r} is neither a name nor an address, such as 10.0.0.7")


def own_hosts() -> tuple[str, ...]:
    """Return the names and addresses by which programs on this machine reach it, and its name."""
    name = socket.gethostname()
    return tuple(dict.fromkeys(["localhost", "127.0.0.1", "::1", *([name] if _HOST.fullmatch(name) else ())]))


class Keystore:
    """A keystore that exists on disk.

    Args:
        path: Its folder.

    Attributes:
        network: The network settings of all members.
        members: Its members by name, except the revoked ones.
        revoked: The names of the revoked members, which can't be used again.

    Raises:
        BadOptions: The folder is not a keystore, or can't be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._load()

    def _load(self) -> None:
        path = self.path
        try:
            data = parsed(_read(path / _FILE))
            self.network = Network(str(data["prefix"]), int(data["ros_domain_id"]), tuple(map(str, data["hosts"])))
            members = [Member.from_json(one) for one in data["members"]]
            self.members = {one.name: one for one in members}
            self.revoked = tuple(map(str, data["revoked"]))
            # Names are folders and parts of rules.
            _check_members(members, _checked(self.revoked))
        except FileNotFoundError:
            raise BadOptions(f"{path} is no keystore; make one with `hmrsim security create {path}`") from None
        except (ValueError, KeyError, TypeError, OverflowError, BadOptions) as error:
            raise BadOptions(f"{path / _FILE}: not a keystore: {printable(str(error))}") from None

    @classmethod
    def create(
        cls, path: Path, members: Sequence[Member], network: Network, *, days: float = DEFAULT_DAYS, force: bool = False
    ) -> Keystore:
        """Create a keystore with an authority and members, completely or not at all.

        Args:
            path: The folder, which must not exist yet.
            members: The members to create enclaves for; their expiry is ignored.
            network: Their network settings.
            days: How long their certificates are valid.
            force: Whether to replace a keystore that exists.

        Raises:
            BadOptions: The folder exists, a member is invalid, or nothing can be written there.
        """
        # Not `resolve`: where the folder is a link, the link is replaced, not its target.
        path = path.absolute()
        _check_place(path, force=force)
        _check_members(members, ())
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            # Made by mkdtemp with mode 0700.
            new = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
        except OSError as error:
            raise _unusable(path, error) from None
        try:
            (new / ENCLAVES).mkdir(mode=0o700)
            authority, issued = Authority.create(days)
            _write(new / "private" / "ca.key.pem", issued.key)
            _write(new / "public" / AUTHORITY, issued.certificate, mode=0o644)
            _write(new / _FILE, _json(_data(network, (), ())))
            store = cls(new)
            store._issue(authority, members, days)
            if force and (path.exists() or path.is_symlink()):
                path.rename(new / "replaced")
            new.rename(path)
            _remove(path / "replaced")
        except OSError as error:
            raise _unusable(path, error) from None
        finally:
            with suppress(OSError):
                shutil.rmtree(new)
        return cls(path)

    def add(self, member: Member, days: float = DEFAULT_DAYS) -> None:
        """Create an enclave for another member.

        Raises:
            BadOptions: The member is invalid or known already, or the keystore can't be written.
        """
        with self._changing():
            _check_members([member], [*self.members, *self.revoked])
            self._issue(self._authority(), [member], days)

    def revoke(self, name: str) -> None:
        """Revoke all rights of a member; simulators that start afterwards enforce this.

        Raises:
            BadOptions: There is no such member, or the keystore can't be written.
        """
        with self._changing():
            self._check_known([name])
            if self.members[name].role == SIMULATOR:
                raise BadOptions(f"{name!r} is the simulator, which all clients trust; make a new keystore instead")
            del self.members[name]
            self.revoked = (*self.revoked, name)
            # The rights first: its folder may have been moved to another machine.
            self._save()
            _remove(self._folder(name))

    def renew(self, names: Sequence[str], days: float = DEFAULT_DAYS) -> list[str]:
        """Issue new certificates to some members, or to all if none is named; return their names.

        Raises:
            BadOptions: There is no such member, or the keystore can't be written.
        """
        with self._changing():
            self._check_known(names)
            renewed = [self.members[name] for name in names or self.members]
            self._issue(self._authority(), renewed, days)
        return [member.name for member in renewed]

    def enclave(self, name: str) -> Enclave:
        """Return the enclave of a member."""
        return Enclave(self._folder(name), self.members[name])

    @property
    def access_control(self) -> AccessControl:
        """The policy of all members."""
        return Rights(self.network.prefix, self.network.domain).access_control(self.members.values())

    def stranger(self, name: str, days: float, folder: Path, authority: Authority | None = None) -> Enclave:
        """Return an enclave outside the keystore that is no member's, to test access control.

        Its certificate is signed by this keystore's authority unless *authority* is given.
        """
        member = Member(name, "operator")
        issued = (authority or self._authority()).issue(name, own_hosts(), days, serves=False)
        member = replace(member, expires=issued.expires.isoformat())
        self._write_enclave(folder, member, issued)
        _write(folder / POLICY, _json(self.access_control.to_json()))
        return Enclave(folder, member)

    def _folder(self, name: str) -> Path:
        return self.path / ENCLAVES / name

    def _authority(self) -> Authority:
        key, certificate = self.path / "private" / "ca.key.pem", self.path / "public" / AUTHORITY
        return Authority(Issued(_signing(certificate), _signing(key), datetime.now(UTC)))

    def _check_known(self, names: Iterable[str]) -> None:
        for name in names:
            if name in self.revoked:
                raise BadOptions(f"{name!r} is revoked")
            if name not in self.members:
                raise BadOptions(f"{self.path} has no {name!r}; there are: {', '.join(self.members)}")

    @contextmanager
    def _changing(self) -> Iterator[None]:
        """Read the current files for a change, and keep other processes from changing them meanwhile."""
        try:
            folder = os.open(self.path, os.O_RDONLY)
            try:
                fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
                self._load()
                yield
            finally:
                os.close(folder)
        except BlockingIOError:
            raise BadOptions(f"{self.path} is being changed by another command; try again") from None
        except OSError as error:
            raise _unusable(error.filename or self.path, error) from None

    def _issue(self, authority: Authority, members: Sequence[Member], days: float) -> None:
        """Issue certificates to new or existing members."""
        for member in members:
            issued = authority.issue(member.name, self.network.hosts, days, serves=member.role in _SERVES)
            known = replace(member, expires=issued.expires.isoformat(timespec="seconds"))
            self.members[member.name] = known
            self._write_enclave(self._folder(member.name), known, issued)
        self._save()

    def _write_enclave(self, folder: Path, member: Member, issued: Issued) -> None:
        authority = _read(self.path / "public" / AUTHORITY).encode()
        _write(folder / KEY, issued.key)
        _write(folder / CERTIFICATE, issued.certificate)
        _write(folder / AUTHORITY, authority)
        if member.role != SIMULATOR:
            # No IPv6 address, at which Zenoh checks no certificate.
            host = next((host for host in self.network.hosts if ":" not in host), "localhost")
            session = _session(host, authority, issued)
            _write(folder / SESSION, _json(session))
        _write(folder / DESCRIPTION, _json(member.to_json()))

    def _save(self) -> None:
        """Write the list of members, and each member's copy of the policy."""
        policy = _json(self.access_control.to_json())
        for name in self.members:
            _write(self._folder(name) / POLICY, policy)
        _write(self.path / _FILE, _json(_data(self.network, self.members.values(), self.revoked)))


def _data(network: Network, members: Iterable[Member], revoked: Sequence[str]) -> dict[str, Any]:
    return {
        "prefix": network.prefix,
        "ros_domain_id": network.domain,
        "hosts": list(network.hosts),
        "members": [member.to_json() for member in members],
        "revoked": list(revoked),
    }


def _session(host: str, authority: bytes, issued: Issued) -> dict[str, Any]:
    """Return a configuration that is complete in itself, so that it can be copied: keys are part of it."""
    return {
        "mode": "client",
        "connect": {"endpoints": [f"tls/{host}:{_PORT}"]},
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "timestamping": {"enabled": True},
        "queries_default_timeout": _QUERY_TIMEOUT,
        "transport": {
            "shared_memory": {"enabled": False},
            "link": {
                "protocols": ["tls"],
                "tls": {
                    "enable_mtls": True,
                    "verify_name_on_connect": True,
                    "close_link_on_expiration": True,
                    "root_ca_certificate_base64": b64encode(authority).decode(),
                    "connect_certificate_base64": b64encode(issued.certificate).decode(),
                    "connect_private_key_base64": b64encode(issued.key).decode(),
                },
            },
        },
        "access_control": trusting([SIMULATOR]).to_json(),
    }


def _check_place(path: Path, *, force: bool) -> None:
    if not path.exists() and not path.is_symlink():
        return
    if not force:
        raise BadOptions(f"{path} exists; name another folder, or replace the keystore there with --force")
    if not (path / _FILE).is_file() and not (path.is_dir() and not any(path.iterdir())):
        raise BadOptions(f"{path} exists and is no keystore; name another folder")


def _check_members(members: Sequence[Member], taken: Sequence[str]) -> None:
    names = list(taken)
    for member in members:
        if member.role not in ROLES:
            raise BadOptions(f"no role {member.role!r}; there are: {', '.join(ROLES)}")
        _checked((member.name, *member.robots, *member.services))
        for robot in member.robots:
            if robot.startswith("_"):
                raise BadOptions(f"{robot!r} is no robot's name; names that begin with _ are the simulator's own")
        if member.role == SIMULATOR and member.name != SIMULATOR:
            raise BadOptions(f"the enclave of simulators is named {SIMULATOR!r}, by which clients know it")
        if member.role != SIMULATOR and member.name == SIMULATOR:
            raise BadOptions(f"{SIMULATOR!r} is the name of the simulator's enclave")
        if member.name in names:
            raise BadOptions(f"{member.name!r} exists already, or is revoked; give another name")
        names.append(member.name)


def _checked(names: Sequence[str]) -> Sequence[str]:
    for name in names:
        if not _NAME.fullmatch(name):
            raise BadOptions(f"{shown(name)} is not a name of at most 64 letters, digits and _.~-, no . first")
    return names


def _remove(path: Path) -> None:
    if path.is_symlink():
        path.unlink()
    elif path.exists():
        shutil.rmtree(path)


def _unusable(path: object, error: OSError) -> HmrsimError:
    """Return the error of a keystore that can't be written: of the disk if that is full, else of the folder."""
    return unwritable(str(path), error) if error.errno in NO_SPACE else BadOptions(f"{path}: {reason_of(error)}")


def _read(path: Path) -> str:
    try:
        check_regular(path)
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise
    except OSError as error:
        raise BadOptions(f"{path}: {reason_of(error)}") from None


def _signing(path: Path) -> bytes:
    """Return the content of a file of the authority."""
    try:
        check_regular(path)
        return path.read_bytes()
    except OSError as error:
        raise BadOptions(f"{path}: {reason_of(error)}; the authority signs certificates") from None


def _json(data: object) -> bytes:
    return f"{json.dumps(data, indent=2)}\n".encode()


def _write(path: Path, data: bytes, *, mode: int = _PRIVATE) -> None:
    """Write a file that appears with its whole content, and never with a wider mode than wanted."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    new = path.with_name(f".{path.name}.new")
    new.unlink(missing_ok=True)
    with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(data)
    new.replace(path)
