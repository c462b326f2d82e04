"""The hub's own certificate: made at the first start where none is given, and renewed."""

from __future__ import annotations

import datetime as dt
import ipaddress
import os
import socket
from typing import TYPE_CHECKING, NamedTuple

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from talaia.hub.errors import CannotStart

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from talaia.hub.settings import Settings

__all__ = ["Certificate", "fingerprint", "own_certificate"]

# Browsers do not take a longer life.
_LIFE = dt.timedelta(days=825)
_RENEW = dt.timedelta(days=30)


class Certificate(NamedTuple):
    """Where the chain and its key are (PEM)."""

    cert: Path
    key: Path


def own_certificate(settings: Settings, now: dt.datetime) -> Certificate:
    """Give the certificate to use: the one in the settings, or one of our own in the data folder.

    Raises:
        CannotStart: a file is missing or cannot be read or written.

    """
    if settings.cert is not None or settings.key is not None:
        if settings.cert is None or settings.key is None:
            raise CannotStart("a certificate needs its key", "give both --cert and --key")
        for path in (settings.cert, settings.key):
            if not os.access(path, os.R_OK):
                raise CannotStart(f"{path} cannot be read", "check the path and its rights")
        return Certificate(settings.cert, settings.key)
    folder = settings.data / "tls"
    own = Certificate(folder / "cert.pem", folder / "key.pem")
    names = {"localhost", "127.0.0.1", "::1", socket.gethostname().lower(), *settings.host_names}
    try:
        if not _is_good(own, names, now):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            _make(own, names, now)
    except OSError as error:
        raise CannotStart(f"{folder} cannot be written: {error.strerror}") from error
    return own


def fingerprint(cert: Path) -> str:
    """Give the SHA-256 of the first certificate in a file, as browsers show it.

    Raises:
        CannotStart: the file holds no certificate.

    """
    try:
        found = x509.load_pem_x509_certificate(cert.read_bytes())
    except ValueError as error:
        raise CannotStart(f"{cert} holds no PEM certificate") from error
    return found.fingerprint(hashes.SHA256()).hex(":").upper()


def _is_good(own: Certificate, names: Iterable[str], now: dt.datetime) -> bool:
    if not own.cert.exists() or not own.key.exists():
        return False
    try:
        found = x509.load_pem_x509_certificate(own.cert.read_bytes())
        said = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (ValueError, x509.ExtensionNotFound):
        return False
    covered = {str(each.value).lower() for each in said}
    return found.not_valid_after_utc - now > _RENEW and set(names) <= covered


def _make(own: Certificate, names: Iterable[str], now: dt.datetime) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "Talaia hub")])
    alternatives = [_alternative(each) for each in sorted(names)]
    cert = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        # A clock that is a little slow must not take it for one of the future.
        .not_valid_before(now - dt.timedelta(days=1))
        .not_valid_after(now + _LIFE)
        .add_extension(x509.SubjectAlternativeName(alternatives), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .sign(key, hashes.SHA256())
    )
    secret = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    own.key.unlink(missing_ok=True)
    with open(os.open(own.key, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(secret)
    own.cert.write_bytes(cert.public_bytes(serialization.Encoding.PEM))


def _alternative(name: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)
