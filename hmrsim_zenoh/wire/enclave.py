"""Enclaves: folders with a certificate, its key and a policy, as `hmrsim security create` makes them.

Nothing here needs the extra `security`: an enclave is copied to the machine that uses it.
"""

from __future__ import annotations

import json
import ssl
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from hmrsim.errors import printable, reason_of
from hmrsim.program.files import check_regular
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.wire.access_control import AccessControl, trusting
from hmrsim_zenoh.wire.options import ENCRYPTED

if TYPE_CHECKING:
    from pathlib import Path

SIMULATOR: Final = "simulator"
"""The role, and the enclave, of simulators."""

ROLES: Final = (SIMULATOR, "controller", "viewer", "operator")
"""All roles."""

ENCLAVES: Final = "enclaves"
"""The folder of a keystore that has the enclaves."""

AUTHORITY, CERTIFICATE, KEY = "ca.cert.pem", "cert.pem", "key.pem"
DESCRIPTION, POLICY = "enclave.json", "policy.json"


@dataclass(frozen=True)
class Member:
    """A participant of a secured network.

    Attributes:
        name: The common name of its certificate.
        role: One of `ROLES`.
        robots: The robots that a controller drives; empty for all.
        services: Services of the world that a controller may call in addition.
        expires: The end of its certificate's validity, as ISO 8601.
    """

    name: str
    role: str
    robots: tuple[str, ...] = ()
    services: tuple[str, ...] = ()
    expires: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Any) -> Member:
        """Return the member of plain values.

        Raises:
            ValueError: They have another form.
        """
        try:
            found = cls(
                str(data["name"]),
                str(data["role"]),
                tuple(map(str, data["robots"])),
                tuple(map(str, data["services"])),
                str(data["expires"]),
            )
            if datetime.fromisoformat(found.expires).tzinfo is None:
                raise ValueError(f"expires: {found.expires!r} has no time zone")
        except (KeyError, TypeError) as error:
            raise ValueError(f"{type(error).__name__}: {error}") from None
        return found


@dataclass(frozen=True)
class Enclave:
    """The folder with the certificate and policy of one member."""

    folder: Path
    member: Member

    @property
    def name(self) -> str:
        """The common name of its certificate."""
        return self.member.name

    @cached_property
    def access_control(self) -> AccessControl:
        """The policy that the simulator enforces, as it was when this folder was written.

        Raises:
            BadOptions: It can't be read.
        """
        return self._policy[0]

    @cached_property
    def _policy(self) -> tuple[AccessControl, dict[str, Any]]:
        """The policy, and Zenoh's form of it as it is in the file, where people may have changed it."""
        path = self.folder / POLICY
        try:
            data = parsed(_text(path))
            return AccessControl.from_json(data), {**data, "enabled": True, "default_permission": "deny"}
        except ValueError as error:
            raise BadOptions(f"--secure: {path}: {error}") from None

    @property
    def left(self) -> float:
        """Seconds until the certificate expires."""
        return (datetime.fromisoformat(self.member.expires) - datetime.now(UTC)).total_seconds()

    def check(self) -> None:
        """Check that the certificate can be used.

        Raises:
            BadOptions: It has expired, or a file is missing or damaged.
        """
        for file in (AUTHORITY, CERTIFICATE, KEY, POLICY):
            _text(self.folder / file)
        self._check_readable()
        if self.left <= 0:
            raise BadOptions(
                f"--secure: the certificate of {self.name!r} in {self.folder} expired on {self.member.expires[:10]}; "
                f"make another with `hmrsim security renew DIR {self.name}`"
            )

    def _check_readable(self) -> None:
        """Check that the certificates and the key can be read: Zenoh tries to connect with damaged ones, too.

        Raises:
            BadOptions: They can't.
        """
        context, folder = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT), self.folder
        what = AUTHORITY
        try:
            context.load_verify_locations(folder / AUTHORITY)
            what = f"{CERTIFICATE} and {KEY}"
            # An empty password in place of a prompt.
            context.load_cert_chain(folder / CERTIFICATE, folder / KEY, password="")
        except ssl.SSLError as error:
            reason = (error.reason or "unreadable").replace("_", " ").lower()
            raise BadOptions(
                f"--secure: {what} in {folder}: {reason}; copy the enclave again, or `hmrsim security renew` it"
            ) from None

    def session(self) -> dict[str, Any]:
        """Return the keys and values of the configuration of its sessions."""
        folder = self.folder.resolve()
        key, certificate = str(folder / KEY), str(folder / CERTIFICATE)
        policy = self._policy[1] if self.member.role == SIMULATOR else trusting([SIMULATOR]).to_json()
        return {
            "transport/link/protocols": list(ENCRYPTED),
            "transport/link/tls": {
                "root_ca_certificate": str(folder / AUTHORITY),
                "enable_mtls": True,
                "verify_name_on_connect": True,
                "close_link_on_expiration": True,
                "listen_certificate": certificate,
                "listen_private_key": key,
                "connect_certificate": certificate,
                "connect_private_key": key,
            },
            "access_control": policy,
        }


def find_enclave(path: Path, wanted: str) -> Enclave:
    """Return the enclave that *path* is, or the one in a keystore of that name or role.

    Raises:
        BadOptions: No enclave has that name or role, or several have it; the text lists the available ones.
    """
    if (path / DESCRIPTION).exists():
        return read_enclave(path)
    found = {enclave.name: enclave for enclave in enclaves(path)}
    if not found:
        raise BadOptions(f"--secure {str(path)!r} has no enclaves; make some with `hmrsim security create {path}`")
    if wanted in found:
        return found[wanted]
    fitting = [enclave for enclave in found.values() if enclave.member.role == wanted]
    if len(fitting) == 1:
        return fitting[0]
    names = ", ".join(enclave.name for enclave in fitting or found.values())
    what = f"several enclaves with the role {wanted!r}" if fitting else f"no enclave {wanted!r}"
    raise BadOptions(f"--secure {str(path)!r} has {what}; choose with --role: {names}")


def enclaves(path: Path) -> list[Enclave]:
    """Return the enclaves of a keystore, by name.

    Raises:
        BadOptions: One of them can't be read.
    """
    try:
        folders = sorted(one for one in (path / ENCLAVES).iterdir() if (one / DESCRIPTION).exists())
    except OSError as error:
        if not isinstance(error, FileNotFoundError):
            raise BadOptions(f"--secure {str(path)!r}: {reason_of(error)}") from None
        return []
    return [read_enclave(folder) for folder in folders]


def read_enclave(folder: Path) -> Enclave:
    """Return the enclave in a folder.

    Raises:
        BadOptions: It can't be read.
    """
    path = folder / DESCRIPTION
    try:
        return Enclave(folder, Member.from_json(parsed(_text(path))))
    except ValueError as error:
        raise BadOptions(f"--secure: {path} does not describe an enclave: {printable(str(error))}") from None


def parsed(text: str) -> Any:
    """Return the value of a JSON text.

    Raises:
        ValueError: It is not a JSON object, or nested too deeply.
    """
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def _text(path: Path) -> str:
    try:
        check_regular(path)
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = reason_of(error) if isinstance(error, OSError) else "not a text"
        raise BadOptions(f"--secure: {path}: {reason}") from None
