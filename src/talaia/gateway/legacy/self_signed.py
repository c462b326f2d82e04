"""A certificate of the gateway's own, for the door of founding clients."""

from __future__ import annotations

import datetime
import ipaddress
import socket

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

__all__ = ["self_signed"]


def self_signed() -> tuple[bytes, bytes]:
    """Make a certificate for this machine, good for ten years, and its key (both PEM)."""
    # P-256: every TLS library has it, and its keys are made at once.
    key = ec.generate_private_key(ec.SECP256R1())
    host = socket.gethostname()
    # A common name has at most 64 characters.
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, host[:64] or "localhost")])
    now = datetime.datetime.now(datetime.UTC)
    # Certificates hold names in ASCII only.
    names = [x509.DNSName(name) for name in dict.fromkeys(("localhost", host)) if name.isascii()]
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        # A clock that is a little behind does not make it a certificate of tomorrow.
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=3650))
        .add_extension(
            x509.SubjectAlternativeName(
                [*names, x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]
            ),
            critical=False,
        )
        # An authority that may sign nothing but itself, so that a browser can be told to trust it.
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .sign(key, hashes.SHA256())
    )
    return (
        certificate.public_bytes(serialization.Encoding.PEM),
        key.private_bytes(
            serialization.Encoding.PEM,
            serialization.PrivateFormat.PKCS8,
            # The gateway starts without a person; the file is readable by its owner only.
            serialization.NoEncryption(),
        ),
    )
