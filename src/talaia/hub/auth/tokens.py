"""Secrets that open something: made at random, kept as a hash."""

from __future__ import annotations

import hashlib
import re
import secrets

__all__ = ["TOKEN_MARK", "hash_token", "mask_tokens", "new_token"]

# By this a leaked API token is recognised, in a log or by a scanner.
TOKEN_MARK = "tal_"  # noqa: S105
# Shorter ones are words of a text about tokens.
_TOKEN = re.compile(rf"{TOKEN_MARK}[A-Za-z0-9_\-]{{8,}}")


def new_token() -> str:
    """Make a secret of 256 random bits, in characters that fit a header, a URL and a cookie."""
    # 32 bytes are 256 bits.
    return secrets.token_urlsafe(32)


def hash_token(token: str) -> str:
    """Give what is kept of a secret. It has 256 random bits: a plain hash cannot be guessed."""
    # Quick on purpose: it is made at every request, and there is nothing to guess.
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()


def mask_tokens(text: str) -> str:
    """Give a text without the API tokens in it, for logs."""
    return _TOKEN.sub(f"{TOKEN_MARK}***", text) if TOKEN_MARK in text else text
