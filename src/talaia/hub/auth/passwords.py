"""Passwords: the rules for one, its hash, and the check that takes the same time for everyone."""

from __future__ import annotations

import asyncio
import base64
import functools
import hmac
import unicodedata
from pathlib import Path

import bcrypt

from talaia.hub.errors import WeakPassword

__all__ = ["LONGEST", "SHORTEST", "Passwords", "check_name", "check_password", "name_key"]

# What NIST SP 800-63B asks of a password that a person chooses (characters).
SHORTEST = 8
LONGEST = 1024  # so that nobody makes the hub hash megabytes
_LONGEST_NAME = 64
# Not a secret: it sets our hashes apart from anyone else's. The HMAC is there for its length,
# since bcrypt reads no more than 72 bytes and none after a NUL.
_DOMAIN = b"talaia password v1"
# bcrypt keeps a core busy for each; the others are for driving and the history.
_AT_ONCE = 2
# The width of its column. NFKC can make eighteen characters of one (U+FDFA).
_LONGEST_KEY = 200
_COMMON = Path(__file__).with_name("common_passwords.txt")
_OURS = "talaia"  # the product's name, which anyone would try
# Guesses that a password has to stand by zxcvbn's estimate. A word with a year and a sign stands
# ten million; eight characters drawn at random stand a hundred million.
_FEWEST_GUESSES = 10**7.5
# Its time grows with the square of the length, and what is longer stands by its beginning.
_ESTIMATED = 64


def check_password(password: str, name: str = "") -> None:
    """Hold a new password against the rules; ``name`` is the person's.

    Raises:
        WeakPassword: it is shorter or longer than allowed, among the commonest ones, the person's
            or the product's name with little more, or guessed soon by zxcvbn's estimate (USENIX
            Security 2016), which knows 30 000 passwords, names, words, years and keyboards.

    """
    if len(password) < SHORTEST:
        raise WeakPassword(
            f"the password has {len(password)} characters",
            f"take at least {SHORTEST}; fifteen or more are better",
        )
    if len(password) > LONGEST:
        raise WeakPassword("the password is too long", f"take at most {LONGEST} characters")
    if name_key(password) in _common_passwords():
        raise WeakPassword(
            "the password is one of the commonest", "take another; three unrelated words are good"
        )
    # Digits and signs before and behind a word are what guessers add first.
    core = "".join(character for character in name_key(password) if character.isalpha())
    if core and not core.replace(_OURS, "").replace(name_key(name), ""):
        raise WeakPassword("the password is a name that anyone would try", "take another")
    if _count_guesses(password, name) < _FEWEST_GUESSES:
        raise WeakPassword(
            "the password is easy to guess", "add a word or two that have nothing to do with it"
        )


def _count_guesses(password: str, name: str) -> float:
    """Estimate after how many guesses somebody who knows the name has the password."""
    # Its lists take memory, which a hub that sets no password does without.
    from zxcvbn import zxcvbn

    found = zxcvbn(password[:_ESTIMATED], user_inputs=[name, _OURS])
    return float(found["guesses"])


def check_name(name: str) -> None:
    """Hold a new person's name against the rules.

    Raises:
        WeakPassword: it is empty, too long, or holds characters that cannot be seen.

    """
    if not name.strip() or name != name.strip() or len(name) > _LONGEST_NAME:
        raise WeakPassword(
            "the name cannot be used",
            f"take 1 to {_LONGEST_NAME} characters, without spaces at the ends",
        )
    # Control, format, surrogate, private and unassigned: two such names look the same on a page.
    if any(unicodedata.category(character)[0] == "C" for character in name):
        raise WeakPassword("the name holds characters that cannot be seen", "leave them out")
    if len(name_key(name)) > _LONGEST_KEY:
        raise WeakPassword("the name cannot be used", "take fewer compound characters")


def name_key(name: str) -> str:
    """Give a name as it is compared: normalised and without case."""
    # NFKC folds look-alikes such as full-width letters, so nobody takes a name that looks taken.
    return unicodedata.normalize("NFKC", name).casefold()


@functools.cache
def _common_passwords() -> frozenset[str]:
    # Read at the first password that is set, and kept.
    lines = _COMMON.read_text(encoding="utf-8").splitlines()
    return frozenset(line for line in lines if not line.startswith("#"))


class Passwords:
    """Hash and verify in a thread, few at once, so that a flood of sign-ins stays harmless."""

    def __init__(self, cost: int) -> None:
        """Take bcrypt's cost: 2 to the power of it rounds."""
        # For new hashes; each hash says by itself with which cost it was made.
        self._cost = cost
        # Hashes and checks at once; the others wait in the order in which they came.
        self._gate = asyncio.Semaphore(_AT_ONCE)
        # A hash that no password is checked against but those of unknown people; made when needed.
        self._nobody: str | None = None

    async def hash_password(self, password: str) -> str:
        """Give the hash to keep."""
        async with self._gate:
            return await asyncio.to_thread(_bcrypt_hash, password, self._cost)

    async def verify_password(self, password: str, kept: str | None) -> bool:
        """Tell whether ``password`` is the one that was hashed to ``kept``.

        Without ``kept`` (there is no such person) the answer is no, and takes as long.
        """
        # It cannot be right, but a quicker answer would be one that others do not get.
        if len(password) > LONGEST:
            password, kept = "", None
        if kept is None and self._nobody is None:
            self._nobody = await self.hash_password("nobody")
        async with self._gate:
            fits = await asyncio.to_thread(_bcrypt_verify, password, kept or self._nobody or "")
        # Only after the check: whoever measures must not learn whether there is such a person.
        return fits and kept is not None


def _password_digest(password: str) -> bytes:
    # NFC: keyboards differ in how they type an accent. JSON can hold a lone surrogate.
    text = unicodedata.normalize("NFC", password).encode("utf-8", "surrogatepass")
    # 48 bytes make 64 characters: below bcrypt's 72, and none of them is NUL.
    return base64.b64encode(hmac.digest(_DOMAIN, text, "sha384"))


def _bcrypt_hash(password: str, cost: int) -> str:
    return bcrypt.hashpw(_password_digest(password), bcrypt.gensalt(cost)).decode()


def _bcrypt_verify(password: str, kept: str) -> bool:
    # bcrypt compares in constant time.
    return bcrypt.checkpw(_password_digest(password), kept.encode())
