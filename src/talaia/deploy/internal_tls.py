"""Certificates for what hubs speak to behind them: NATS and the database. Texts out.

An authority of this deployment's own signs one for each server, and nobody has its key afterwards:
whoever reads one server's key cannot pass for another one.
"""

from __future__ import annotations

import datetime as dt
from typing import TYPE_CHECKING, NamedTuple

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["ServerPair", "make_server_pairs"]

# Hubs alone read them, and whoever made the deployment makes them anew; a date in two years would
# only be a day on which all hubs lose each other.
_LIFE = dt.timedelta(days=3650)


class ServerPair(NamedTuple):
    """A server's certificate and its key (PEM)."""

    certificate: str
    key: str


def make_server_pairs(names: Iterable[str], now: dt.datetime) -> tuple[str, dict[str, ServerPair]]:
    """Make an authority and a certificate for each name; give the authority's own, and those."""
    signer = ec.generate_private_key(ec.SECP256R1())
    issuer = _common_name("Talaia, behind the hubs")
    key_usage = _key_usage(signs=True)
    authority = (
        _begin_certificate(issuer, issuer, signer.public_key(), now)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(key_usage, critical=True)
        .sign(signer, hashes.SHA256())
    )
    pairs: dict[str, ServerPair] = {}
    for name in names:
        key = ec.generate_private_key(ec.SECP256R1())
        certificate = (
            _begin_certificate(_common_name(name), issuer, key.public_key(), now)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(_key_usage(signs=False), critical=True)
            # `localhost` is for whoever asks a server in its own container.
            .add_extension(
                x509.SubjectAlternativeName([x509.DNSName(name), x509.DNSName("localhost")]),
                critical=False,
            )
            .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
            .add_extension(
                x509.AuthorityKeyIdentifier.from_issuer_public_key(signer.public_key()),
                critical=False,
            )
            .sign(signer, hashes.SHA256())
        )
        pairs[name] = ServerPair(_pem(certificate), _private_pem(key))
    return _pem(authority), pairs


def _common_name(name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])


def _begin_certificate(
    name: x509.Name, issuer: x509.Name, public: ec.EllipticCurvePublicKey, now: dt.datetime
) -> x509.CertificateBuilder:
    return (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(issuer)
        .public_key(public)
        .serial_number(x509.random_serial_number())
        # A clock that is a little slow must not take it for one of the future.
        .not_valid_before(now - dt.timedelta(days=1))
        .not_valid_after(now + _LIFE)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(public), critical=False)
    )


def _key_usage(*, signs: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs,
        key_cert_sign=signs,
        crl_sign=signs,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        encipher_only=False,
        decipher_only=False,
    )


def _pem(certificate: x509.Certificate) -> str:
    return certificate.public_bytes(serialization.Encoding.PEM).decode()


def _private_pem(key: ec.EllipticCurvePrivateKey) -> str:
    return key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    ).decode()
