"""Signed heads of the audit log: what its newest row was at a moment, said outside the database.

Whoever has the database can chain all rows anew. A head that was signed with a key that is not in
it, and that lies elsewhere (a file, a log server), names the hash that the chain must still pass.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import os
from typing import TYPE_CHECKING

import msgspec
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

from talaia.hub.auth.key_file import read_or_make_key
from talaia.hub.errors import CannotStart

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["KEY_FILE", "AuditHead", "HeadKey", "head_key", "key_name", "read_head"]

# In the data folder; what it signs is to be kept elsewhere.
KEY_FILE = "audit.key"
_KEY_BYTES = 32
# Before the head itself, so that no line of a log is taken for one.
_MARK = "talaia-audit-head"


class AuditHead(msgspec.Struct, frozen=True):
    """The newest row at a moment.

    Attributes:
        row: its number.
        hash: its hash; every row before it follows from it.
        time_us: when it was so (UTC).
        lost: notes that were never written, since the hub began.

    """

    row: int
    hash: str
    time_us: int
    lost: int = 0


class HeadKey:
    """Signs heads."""

    def __init__(self, key: bytes) -> None:
        """Take a key of 32 bytes (Ed25519)."""
        self._key = Ed25519PrivateKey.from_private_bytes(key)

    @property
    def public(self) -> str:
        """Give what verifies its heads (base64)."""
        return base64.b64encode(self._key.public_key().public_bytes_raw()).decode()

    def sign_head(self, head: AuditHead) -> str:
        """Write a head as a line."""
        said = msgspec.json.encode(head)
        signature = base64.b64encode(self._key.sign(said)).decode()
        return f"{_MARK} {key_name(self.public)} {signature} {said.decode()}"


def key_name(public: str) -> str:
    """Give a short name of a key, by which a line says whose it is."""
    return hashlib.sha256(base64.b64decode(public)).hexdigest()[:16]


def read_head(line: str, public: str) -> AuditHead | None:
    """Read a line; None where it holds no head of this key.

    A log server writes its own words before it, which are left out.

    Raises:
        ValueError: it says that it is one, and its signature is wrong.

    """
    at = line.find(_MARK)
    if at < 0:
        return None
    parts = line[at:].strip().split(" ", 3)
    if len(parts) != 4 or parts[1] != key_name(public):
        return None
    said = parts[3].encode()
    try:
        key = Ed25519PublicKey.from_public_bytes(base64.b64decode(public, validate=True))
        key.verify(base64.b64decode(parts[2], validate=True), said)
        return msgspec.json.decode(said, type=AuditHead)
    except (InvalidSignature, binascii.Error, msgspec.MsgspecError) as error:
        raise ValueError(f"a head with a wrong signature: {line.strip()[:200]}") from error


def head_key(data: Path) -> HeadKey:
    """Read the key in a data folder, or make it there, readable by its owner only.

    Raises:
        CannotStart: the file cannot be read or made, or holds no key.

    """
    path = data / KEY_FILE
    try:
        key = read_or_make_key(path, os.urandom(_KEY_BYTES))
    except OSError as error:
        raise CannotStart(
            f"the key {path} cannot be read: {error.strerror}", "check who owns the data folder"
        ) from error
    if len(key) != _KEY_BYTES:
        raise CannotStart(
            f"{path} holds no key of {_KEY_BYTES} bytes",
            "bring back the one of your backup; without it earlier heads are verified by no hub",
        )
    return HeadKey(key)
