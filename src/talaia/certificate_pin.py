"""A server that is known by the hash of its certificate, or of the key in it (decision 10)."""

from __future__ import annotations

import contextlib
import hashlib
import ssl

from talaia.wire.certificate_der import public_key_of

__all__ = ["has_fingerprint", "hash_of_key", "trust_only"]


def has_fingerprint(certificate: bytes, fingerprint: str) -> bool:
    """Tell whether a certificate (DER) is the one that is known.

    Args:
        certificate: as the server shows it.
        fingerprint: SHA-256 (hex) of the certificate, or of its public key: a server that renews
            its certificate keeps its key.

    """
    known = {hashlib.sha256(certificate).hexdigest()}
    # One that we cannot read must be known by its own hash.
    with contextlib.suppress(ValueError):
        known.add(hash_of_key(certificate))
    return fingerprint in known


def hash_of_key(certificate: bytes) -> str:
    """Give the SHA-256 (hex) of the public key in a certificate (DER).

    Raises:
        ValueError: it cannot be read.

    """
    return hashlib.sha256(public_key_of(certificate)).hexdigest()


def trust_only(certificate: bytes) -> ssl.SSLContext:
    """Make a context that takes this certificate (DER) and no other."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    # The name is not compared: the certificate itself is known, whatever name it bears.
    context.check_hostname = False
    # It need not be signed by a root that we know.
    context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
    context.load_verify_locations(cadata=certificate)
    return context
