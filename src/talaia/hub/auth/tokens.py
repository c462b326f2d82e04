"""Secrets that open something: made at random, kept as a hash."""

from __future__ import annotations

import hashlib
import secrets

__all__ = ["hash_token", "new_token"]


def new_token() -> str:
    """Make a secret of 256 random bits, in characters that fit a header, a URL and a cookie."""
    # 32 bytes are 256 bits.
    return secrets.token_urlsafe(32)


def hash_token(token: str) -> str:
    """Give what is kept of a secret. It has 256 random bits: a plain hash cannot be guessed."""
    # Quick on purpose: it is made at every request, and there is nothing to guess.
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()
