"""The certificate authority of a keystore and the certificates that it signs, with keys on the curve P-256."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Final

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from hmrsim_zenoh.errors import BadOptions

if TYPE_CHECKING:
    from collections.abc import Sequence

_SKEW: Final = timedelta(minutes=5)
"""The tolerated difference between clocks: certificates are valid from that long ago."""
_AUTHORITY_DAYS: Final = 3650
"""The shortest validity of an authority."""


@dataclass(frozen=True)
class Issued:
    """A certificate with its key, both as PEM.

    Attributes:
        expires: The end of its validity.
    """

    certificate: bytes
    key: bytes
    expires: datetime


class Authority:
    """A certificate authority, which signs the certificates of a keystore.

    Args:
        issued: Its own certificate and key.

    Raises:
        BadOptions: They can't be read.
    """

    def __init__(self, issued: Issued) -> None:
        try:
            self._certificate = x509.load_pem_x509_certificate(issued.certificate)
            key = serialization.load_pem_private_key(issued.key, password=None)
        except (ValueError, TypeError) as error:
            raise BadOptions(f"the authority can't be read: {error}") from None
        if not isinstance(key, ec.EllipticCurvePrivateKey):
            raise BadOptions("the authority can't be read: its key is of no elliptic curve")
        self._key = key

    @classmethod
    def create(cls, days: float) -> tuple[Authority, Issued]:
        """Return a new authority whose certificates are valid for some days, and its own certificate and key."""
        key, now = ec.generate_private_key(ec.SECP256R1()), datetime.now(UTC)
        name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, f"hmrsim {x509.random_serial_number():032x}"[:39])])
        expires = now + timedelta(days=max(days, _AUTHORITY_DAYS))
        builder = _builder(key, name, name, now - _SKEW, expires)
        builder = builder.add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        usage = _usage(signs_certificates=True)
        issued = Issued(
            _pem(builder.add_extension(usage, critical=True).sign(key, hashes.SHA256())), _key(key), expires
        )
        return cls(issued), issued

    def issue(self, name: str, hosts: Sequence[str], days: float, *, serves: bool) -> Issued:
        """Return a certificate for a client; if it *serves*, also for a server at *hosts*.

        It expires with the authority, if that is earlier.

        Raises:
            BadOptions: The authority has expired.
        """
        key, now = ec.generate_private_key(ec.SECP256R1()), datetime.now(UTC)
        subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
        # Negative days give an expired certificate, which must have begun before it expired.
        expires = min(now + timedelta(days=days), self._certificate.not_valid_after_utc)
        if now >= self._certificate.not_valid_after_utc:
            raise BadOptions(f"the authority expired on {expires:%Y-%m-%d}; make a new keystore")
        usages = [ExtendedKeyUsageOID.CLIENT_AUTH] + [ExtendedKeyUsageOID.SERVER_AUTH] * serves
        authority = self._certificate
        builder = (
            _builder(key, subject, authority.subject, min(now, expires) - _SKEW, expires)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(_usage(signs_certificates=False), critical=True)
            .add_extension(x509.ExtendedKeyUsage(usages), critical=False)
            .add_extension(x509.SubjectAlternativeName([_host(host) for host in hosts]), critical=False)
            .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(self._key.public_key()), critical=False)
        )
        return Issued(_pem(builder.sign(self._key, hashes.SHA256())), _key(key), expires)


def _builder(
    key: ec.EllipticCurvePrivateKey, subject: x509.Name, issuer: x509.Name, since: datetime, until: datetime
) -> x509.CertificateBuilder:
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(since)
        .not_valid_after(until)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
    )


def _usage(*, signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_certificates,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        encipher_only=False,
        decipher_only=False,
    )


def _host(text: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(text))
    except ValueError:
        return x509.DNSName(text)


def _pem(certificate: x509.Certificate) -> bytes:
    return certificate.public_bytes(serialization.Encoding.PEM)


def _key(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
