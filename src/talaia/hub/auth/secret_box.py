"""Secrets that the hub must be able to read again, sealed by a key that is not in the database."""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import os
from typing import TYPE_CHECKING

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM

from talaia.hub.auth.key_file import read_or_make_key
from talaia.hub.errors import CannotStart

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["SEAL_FILE", "Seal", "seal_of"]

# In the data folder.
SEAL_FILE = "seal.key"
_KEY_BYTES = 32  # AES-256
_NONCE_BYTES = 12  # 96 bits, the length that GCM is made for (NIST SP 800-38D)


class Seal:
    """Seals texts (AES-256-GCM); each is bound to what it is about, so none can be moved."""

    def __init__(self, key: bytes) -> None:
        """Take a key of 32 bytes."""
        self._key = key
        self._cipher = AESGCM(key)

    def derive_key(self, purpose: str) -> bytes:
        """Give a key for something else, which tells nothing of this one."""
        # HMAC as the expanding half of HKDF (RFC 5869): ours is uniformly random already.
        return hmac.new(self._key, purpose.encode() + b"\x01", hashlib.sha256).digest()

    def seal_text(self, text: str, about: str) -> str:
        """Seal ``text``."""
        # New each time: GCM loses its secrecy where one key meets a nonce twice.
        nonce = os.urandom(_NONCE_BYTES)
        # ``about`` is authenticated and not kept: moved to another row, it does not open.
        sealed = nonce + self._cipher.encrypt(nonce, text.encode(), about.encode())
        return base64.urlsafe_b64encode(sealed).decode()

    def open_text(self, sealed: str, about: str) -> str | None:
        """Give the text; None when it was sealed by another key, or about something else."""
        try:
            raw = base64.urlsafe_b64decode(sealed.encode())
            text = self._cipher.decrypt(raw[:_NONCE_BYTES], raw[_NONCE_BYTES:], about.encode())
        except (InvalidTag, binascii.Error, ValueError):
            # A database that was restored without its key: the secret is lost, the hub is not.
            return None
        return text.decode()


def seal_of(path: Path) -> Seal:
    """Read the key in a file, or make it there, readable by its owner only.

    Raises:
        CannotStart: the file cannot be read or made, or holds no key.

    """
    try:
        key = read_or_make_key(path, os.urandom(_KEY_BYTES))
    except OSError as error:
        raise CannotStart(
            f"the key {path} cannot be read: {error.strerror}", "check who owns the data folder"
        ) from error
    # A short file may be one that a full disk cut; a new key would make all that is sealed void.
    if len(key) != _KEY_BYTES:
        raise CannotStart(
            f"{path} holds no key of {_KEY_BYTES} bytes",
            "bring back the one of your backup, or remove it; second factors must then be set anew",
        )
    return Seal(key)
