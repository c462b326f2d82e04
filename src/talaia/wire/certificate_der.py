"""As much of a certificate's encoding (DER, X.509) as it takes to find its public key. Pure."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["public_key_of"]

# Tags of X.690: SEQUENCE, and the [0] that wraps a certificate's version.
_SEQUENCE, _VERSION = 0x30, 0xA0
# Serial number, signature's algorithm, issuer, validity, subject: what stands before the key.
_BEFORE = 5


class _Part(NamedTuple):
    """One encoded value: its tag, where its content begins, and where it ends."""

    tag: int
    content: int
    end: int


def public_key_of(certificate: bytes) -> bytes:
    """Give the encoded SubjectPublicKeyInfo of a certificate.

    Raises:
        ValueError: it is no certificate.

    """
    body = _part(certificate, _part(certificate, 0, _SEQUENCE).content, _SEQUENCE)
    at = body.content
    first = _part(certificate, at)
    # Version 1 certificates leave the version out (RFC 5280, 4.1.2.1).
    if first.tag == _VERSION:
        at = first.end
    for _ in range(_BEFORE):
        at = _part(certificate, at).end
    # subjectPublicKeyInfo follows the subject; its hash is what HPKP (RFC 7469) used to pin.
    key = _part(certificate, at, _SEQUENCE)
    if key.end > body.end:
        raise ValueError("the key does not lie in the certificate")
    return certificate[at : key.end]


def _part(data: bytes, at: int, tag: int | None = None) -> _Part:
    head = data[at : at + 2]
    if len(head) < 2 or (tag is not None and head[0] != tag):
        raise ValueError("this is no certificate")
    length, content = head[1], at + 2
    # Long form of a length (X.690, 8.1.3.5): the low bits say how many bytes it has.
    if length & 0x80:
        size = length & 0x7F
        length = int.from_bytes(data[content : content + size], "big")
        content += size
    if content + length > len(data):
        raise ValueError("the certificate is cut")
    return _Part(head[0], content, content + length)
