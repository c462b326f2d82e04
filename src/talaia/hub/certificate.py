"""The hub's certificate: the given one, or one of our own, made at the first start and renewed.

Gateways know a hub by its public key. So a certificate of our own is renewed with the key it had,
and no gateway has to enrol again because a name was added or two years have passed.
"""

from __future__ import annotations

import datetime as dt
import hashlib
import ipaddress
import logging
import secrets
import socket
import stat
from typing import TYPE_CHECKING, NamedTuple

from cryptography import x509
from cryptography.exceptions import UnsupportedAlgorithm
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec, ed25519, rsa
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from talaia.hub.auth.key_file import read_or_make_key
from talaia.hub.errors import CannotStart

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from cryptography.hazmat.primitives.asymmetric.types import CertificatePublicKeyTypes

    from talaia.hub.settings import Settings

__all__ = [
    "Certificate",
    "certificate_fingerprint",
    "certificate_of",
    "fresh_certificate",
    "key_hash",
    "own_certificate",
]

_LOG = logging.getLogger(__name__)

_Key = ec.EllipticCurvePrivateKey | rsa.RSAPrivateKey | ed25519.Ed25519PrivateKey
# Browsers do not take a longer life.
_LIFE = dt.timedelta(days=825)
# Before its end a certificate of our own is made anew; a running hub looks every hour.
_RENEW = dt.timedelta(days=30)


class Certificate(NamedTuple):
    """Where the chain and its key are (PEM)."""

    cert: Path
    key: Path


def certificate_of(settings: Settings) -> Certificate:
    """Tell where the certificate and its key are, given or our own.

    Raises:
        CannotStart: only one of the two was given.

    """
    if settings.cert is None and settings.key is None:
        folder = settings.data / "tls"
        return Certificate(folder / "cert.pem", folder / "key.pem")
    if settings.cert is None or settings.key is None:
        raise CannotStart("a certificate needs its key", "give both --tls-cert and --tls-key")
    return Certificate(settings.cert, settings.key)


def own_certificate(settings: Settings, now: dt.datetime) -> Certificate:
    """Give the certificate to use: the one in the settings, or one of our own in the data folder.

    Raises:
        CannotStart: a file is missing, cannot be read or written, or does not fit the other.

    """
    # Given files are only checked: others renew them, and they are not ours to write.
    found = certificate_of(settings)
    if settings.cert is not None:
        _check_given(found, now)
        return found
    folder = found.cert.parent
    # A name that was added since makes it due, too.
    names = {"localhost", "127.0.0.1", "::1", *settings.host_names}
    if settings.cluster:
        # Several hubs may share the folder, and so this certificate: the names of their machines
        # would have each of them make it anew, again and again.
        names = {*names} - {socket.gethostname().lower()} | {
            name.lower() for name in settings.hosts
        }
    try:
        if not _is_good(found, names, now):
            # Made with its rights: a chmod afterwards would leave it open for a moment.
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            # Another hub's names stay, for the same reason.
            _make(found, names | (_covered_names(found) if settings.cluster else set()), now)
        # Copied from a backup, they may have lost their rights.
        folder.chmod(0o700)
        found.key.chmod(0o600)
    except OSError as error:
        raise CannotStart(f"{folder} cannot be written: {error.strerror}") from error
    return found


def fresh_certificate(settings: Settings, now: dt.datetime, shown: str) -> Certificate | None:
    """Give the certificate if it is another than the one that is shown (by its fingerprint).

    Ours is renewed in time; given files are looked at again, since others renew them.

    Raises:
        CannotStart: the files cannot be used (any more); the one that is shown should stay.

    """
    found = own_certificate(settings, now)
    # Compared by fingerprint, not by the file's time: a copy of the same certificate is no news.
    return None if certificate_fingerprint(found.cert) == shown else found


def certificate_fingerprint(cert: Path) -> str:
    """Give the SHA-256 of the first certificate in a file, as browsers show it.

    Raises:
        CannotStart: the file holds no certificate.

    """
    # Of the whole certificate: it changes at each renewal, while `key_hash` stays.
    return _read_cert(cert).fingerprint(hashes.SHA256()).hex(":").upper()


def key_hash(cert: Path) -> str:
    """Give the SHA-256 (hexadecimal) of the public key in a file's first certificate.

    Raises:
        CannotStart: the file holds no certificate.

    """
    return hashlib.sha256(_public_key(_read_cert(cert).public_key())).hexdigest()


def _check_given(given: Certificate, now: dt.datetime) -> None:
    cert, key = _read_cert(given.cert), _read_key(given.key)
    # OpenSSL would refuse the pair, too, but names neither file.
    if _public_key(cert.public_key()) != _public_key(key.public_key()):
        raise CannotStart(
            f"the key {given.key} is not that of the first certificate in {given.cert}",
            "give the two that were made together; in a chain, the hub's own stands first",
        )
    if cert.not_valid_after_utc <= now:
        raise CannotStart(
            f"the certificate {given.cert} ended on {cert.not_valid_after_utc:%Y-%m-%d}",
            "renew it, or leave --tls-cert and --tls-key out",
        )
    if cert.not_valid_before_utc > now:
        raise CannotStart(
            f"the certificate {given.cert} begins on {cert.not_valid_before_utc:%Y-%m-%d}",
            "set this machine's clock",
        )
    # A group may read it: so Debian's ssl-cert group does. The rest is warned of, not refused.
    if given.key.stat().st_mode & (stat.S_IRWXO | stat.S_IWGRP):
        _LOG.warning("others on this machine can read %s; run: chmod 600 %s", given.key, given.key)


def _read_cert(path: Path) -> x509.Certificate:
    try:
        # The first of the file; in a chain (RFC 8446, 4.4.2) the server's own stands first.
        return x509.load_pem_x509_certificate(_bytes_of(path))
    except ValueError as error:
        raise CannotStart(f"{path} holds no PEM certificate") from error


def _read_key(path: Path) -> _Key:
    try:
        found = serialization.load_pem_private_key(_bytes_of(path), None)
    except TypeError as error:
        # So cryptography says that a password is needed and none was given.
        raise CannotStart(
            f"the key {path} is locked by a passphrase",
            "give one without: openssl pkey -in LOCKED -out OPEN",
        ) from error
    except (ValueError, UnsupportedAlgorithm) as error:
        raise CannotStart(f"{path} holds no private key (PEM)", "check --tls-key") from error
    if not isinstance(found, _Key):
        raise CannotStart(f"the key {path} is of a kind that TLS cannot use", "use EC or RSA")
    return found


def _bytes_of(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise CannotStart(
            f"{path} cannot be read: {error.strerror}", "check the path and its rights"
        ) from error


# The SubjectPublicKeyInfo is what is pinned: it stays the same when the key is certified anew.
def _public_key(key: CertificatePublicKeyTypes) -> bytes:
    return key.public_bytes(
        serialization.Encoding.DER, serialization.PublicFormat.SubjectPublicKeyInfo
    )


def _is_good(own: Certificate, names: Iterable[str], now: dt.datetime) -> bool:
    if not own.cert.exists() or not own.key.exists():
        return False
    try:
        found, key = _read_cert(own.cert), _read_key(own.key)
    except CannotStart:
        # Ours, and unreadable: it is made anew rather than keep the hub from starting.
        return False
    if _public_key(found.public_key()) != _public_key(key.public_key()):
        return False
    # Names that are covered and wanted no more do no harm until the next renewal.
    return found.not_valid_after_utc - now > _RENEW and set(names) <= _covered_names(own)


def _covered_names(own: Certificate) -> set[str]:
    """Give the names in a certificate of ours; none where it cannot be read."""
    try:
        found = _read_cert(own.cert).extensions
        said = found.get_extension_for_class(x509.SubjectAlternativeName).value
    except (CannotStart, x509.ExtensionNotFound):
        return set()
    return {str(name.value).lower() for name in said}


def _make(own: Certificate, names: Iterable[str], now: dt.datetime) -> None:
    key = _key_of(own)
    # For people only: what counts are the alternative names (RFC 9110, 4.3.4).
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "Talaia hub")])
    alternatives = [_alternative_name(name) for name in sorted(names)]
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
        # It certifies itself; the length lets it certify nobody who certifies others.
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        # Ed25519 has its hash built in, and cryptography refuses another one.
        .sign(key, None if isinstance(key, ed25519.Ed25519PrivateKey) else hashes.SHA256())
    )
    # Written aside: a hub that is killed here leaves the certificate of before whole. Named by
    # chance: another hub may be making it, too, in a folder that both have.
    fresh = own.cert.with_suffix(f".{secrets.token_hex(8)}")
    fresh.write_bytes(cert.public_bytes(serialization.Encoding.PEM))
    fresh.replace(own.cert)


def _key_of(own: Certificate) -> _Key:
    """Give the key there is, or make one that only its owner can read."""
    if own.key.exists():
        try:
            return _read_key(own.key)
        except CannotStart as error:
            _LOG.warning("a new key is made, gateways must enrol again: %s", error)
            own.key.unlink(missing_ok=True)
    # P-256 is the curve that every browser takes.
    key = ec.generate_private_key(ec.SECP256R1())
    secret = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    # A new file, with its rights from the start; of hubs that start at once in one folder, one
    # makes it and the others take it.
    read_or_make_key(own.key, secret)
    return _read_key(own.key)


def _alternative_name(name: str) -> x509.GeneralName:
    try:
        # An address must be said as one: browsers do not take it from a DNS name.
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)
