"""The one-time code by which a gateway enrols, as people read and type it. Pure.

A code is groups of five letters and digits: a secret that the hub has made, the beginning of the
SHA-256 of the hub's public key (so that the gateway knows the hub before it tells it anything),
and two characters that show a slip of the finger. Without the middle part the hub stands behind
a proxy or has a certificate of an authority, and is trusted by that.

Letters are those of Crockford's base 32: no I, L, O or U; small letters, and I, L and O for 1, 1
and 0, are understood.
"""

from __future__ import annotations

import hashlib
from typing import NamedTuple

from talaia.wire.errors import CodeMistyped

__all__ = ["SECRET_LENGTH", "EnrolmentCode", "pin_of", "read_code", "secret_of"]

_LETTERS = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
# Letters that look like digits become those; what people put between groups goes.
_AS = str.maketrans("ILO", "110", " -\t\r\n._")
_GROUP = 5
# 60 bits that live for minutes, and 105 bits of the key's hash.
SECRET_LENGTH = 12
_PIN_LENGTH = 21
# 10 bits: of a thousand slips one is not seen here, and the hub refuses that one.
_CHECK_LENGTH = 2


class EnrolmentCode(NamedTuple):
    """A code in its parts; ``pin`` is empty where the hub's key is not pinned."""

    secret: str
    pin: str = ""

    def __str__(self) -> str:
        text = self.secret + self.pin
        text += _check_letters(text)
        return "-".join(text[at : at + _GROUP] for at in range(0, len(text), _GROUP))

    def matches_key(self, key_hash: str) -> bool:
        """Tell whether a public key's SHA-256 (hexadecimal) is the one that the code names."""
        # A public key's hash is no secret, so it needs no comparison in constant time.
        return self.pin == pin_of(key_hash)


def read_code(text: str) -> EnrolmentCode:
    """Read a code as a person typed or pasted it.

    Raises:
        CodeMistyped: it is no code, or a character of it is wrong.

    """
    plain = text.strip().upper().translate(_AS)
    strange = sorted(set(plain) - set(_LETTERS))
    if strange:
        raise CodeMistyped(f"a code has no {strange[0]!r}")
    longest = SECRET_LENGTH + _PIN_LENGTH + _CHECK_LENGTH
    # With the hub's key in it or without; no other length is a code.
    if len(plain) not in {SECRET_LENGTH + _CHECK_LENGTH, longest}:
        raise CodeMistyped(f"it has {len(plain)} letters and digits, and a code has {longest}")
    said, check = plain[:-_CHECK_LENGTH], plain[-_CHECK_LENGTH:]
    if _check_letters(said) != check:
        raise CodeMistyped("one of its characters is not as it was shown")
    return EnrolmentCode(said[:SECRET_LENGTH], said[SECRET_LENGTH:])


def secret_of(number: int) -> str:
    """Write the lowest 60 bits of a random number as a code's secret."""
    return _encode_letters(number, SECRET_LENGTH)


def pin_of(key_hash: str) -> str:
    """Give the part of a code that names a public key by its SHA-256 (hexadecimal)."""
    # The first 105 of its 256 bits.
    return _encode_letters(int(key_hash, 16) >> (256 - 5 * _PIN_LENGTH), _PIN_LENGTH)


def _check_letters(text: str) -> str:
    # The words in front keep this apart from every other hash of the same text.
    digest = hashlib.sha256(b"talaia enrolment code " + text.encode()).digest()
    # Of these 16 bits the lowest ten are written.
    return _encode_letters(int.from_bytes(digest[:2], "big"), _CHECK_LENGTH)


def _encode_letters(number: int, length: int) -> str:
    # Five bits a letter, the highest first.
    return "".join(_LETTERS[number >> 5 * at & 31] for at in reversed(range(length)))
