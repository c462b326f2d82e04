"""How a description goes over the link: deflated, bounded, and under a seal. Pure."""

from __future__ import annotations

import hashlib
import hmac
import zlib

from talaia.wire.errors import PeerError

__all__ = ["MAX_TEXT", "compress_text", "decompress_text", "digest_of", "seal_of"]

# Bytes of a description's text: what `model.yaml_text.load` reads.
MAX_TEXT = 4 * 1024 * 1024


def digest_of(text: str) -> str:
    """Name a text: its SHA-256, hex."""
    return hashlib.sha256(text.encode()).hexdigest()


def compress_text(text: str) -> bytes:
    """Give a text as it is sent."""
    return zlib.compress(text.encode(), 6)


def decompress_text(data: bytes) -> str:
    """Give back a text that was sent; never more than `MAX_TEXT` bytes are unpacked.

    Raises:
        PeerError: it is no deflated text, or too long.

    """
    reader = zlib.decompressobj()
    # Bounded while it is unpacked: a kilobyte can stand for megabytes.
    try:
        text = reader.decompress(data, MAX_TEXT)
        # A rest that was not unpacked, or no end: neither is the whole text.
        if reader.unconsumed_tail or not reader.eof:
            raise PeerError(f"a description of more than {MAX_TEXT} bytes, or cut short", 1009)
        return text.decode()
    except (zlib.error, UnicodeDecodeError) as error:
        raise PeerError(f"a description that cannot be unpacked: {error}") from error


def seal_of(key_hash: str, *, change_id: str, who: str, base: str, text: str) -> str:
    """Give the seal of a change: who holds the hash of the gateway's key has asked for just this.

    The hub keeps no more of the key than that hash, and the gateway can make it.

    Args:
        key_hash: SHA-256 of the gateway's key, hex.
        change_id: see `ChangeRequest`.
        who: see `ChangeRequest`.
        base: see `ChangeRequest`.
        text: the description.

    """
    parts = [change_id, who, base, digest_of(text)]
    # Each with its length before it, so that no two changes say the same bytes.
    said = b"".join(b"%d:%s" % (len(part.encode()), part.encode()) for part in parts)
    return hmac.new(bytes.fromhex(key_hash), said, hashlib.sha256).hexdigest()
