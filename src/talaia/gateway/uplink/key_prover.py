"""Proves this gateway to its hub: that it has its key, and that it was linked before.

The key itself goes over the line only to a hub of before, which asks for no proof. A hub that has
ever handed down a place asks for one, so from then on it is never told the key again.
"""

from __future__ import annotations

import hashlib
import logging
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.persistence import write_whole
from talaia.wire.gateway_proof import (
    KeyProof,
    ResumeToken,
    cover_key,
    proof_words,
    read_challenge,
    read_next_nonce,
    resume_answer,
)

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping
    from pathlib import Path

__all__ = ["RESUME_FILE", "KeyProver", "read_resume"]

log = logging.getLogger(__name__)
# In the data folder.
RESUME_FILE = "place.json"


class _SavedPlace(msgspec.Struct):
    # Of which key it is: another key begins anew.
    key: str
    resume: str


def read_resume(text: str) -> tuple[ResumeToken, bytes] | None:
    """Read what a hub handed down: two numbers and a secret; None: it is nothing of that kind."""
    try:
        lineage, serial, secret = text.split(".")
        return ResumeToken(int(lineage), int(serial)), bytes.fromhex(secret)
    except ValueError:
        return None


class KeyProver:
    """Writes what a dial says of who we are, and keeps what the hub hands down for the next."""

    def __init__(
        self,
        *,
        key: str,
        site: str,
        path: Path,
        on_disk: Callable[[Callable[[], None]], Awaitable[None]],
    ) -> None:
        """Read what the last run has left.

        Args:
            key: the gateway's.
            site: for which it is.
            path: file of what the hub handed down.
            on_disk: runs a blocking write.

        """
        self._key, self._site = key, site
        self._path, self._on_disk = path, on_disk
        self._mark = hashlib.sha256(b"talaia place " + key.encode()).hexdigest()[:16]
        self._resume = self._read()
        # For the next dial, where the hub has told one already.
        self._nonce = ""
        # This hub asks for no proof.
        self._says_key = False

    def forget_hub(self) -> None:
        """Begin anew with a hub: it may be of another version than the one before."""
        self._says_key = False

    def make_header(self, path: str) -> str:
        """Give what the dial of a path says as `Authorization`."""
        if self._says_key:
            return f"Bearer {self._key}"
        # Used once, by whichever of our connections is dialled next.
        nonce, self._nonce = self._nonce, ""
        if not nonce:
            return proof_words(KeyProof(self._site))
        said = KeyProof(
            self._site, nonce, cover_key(self._key, nonce=nonce, site=self._site, path=path)
        )
        held = read_resume(self._resume)
        if held is not None:
            place, secret = held
            resume = resume_answer(secret, nonce=nonce, site=self._site, path=path)
            said = said._replace(place=place, resume=resume)
        return proof_words(said)

    def hear_refusal(self, headers: Mapping[str, str]) -> bool:
        """Take what a hub says that did not let us in; give whether to dial again at once."""
        self._nonce = read_challenge(headers.get("WWW-Authenticate", ""))
        if self._nonce:
            return True
        if self._says_key:
            return False
        if self._resume:
            # Whoever stands between could pretend this, to be told the key.
            log.error(
                "the hub asks for this gateway's key itself, as it did not before; it is not told. "
                "If the hub was set back to an earlier version, remove %s",
                self._path,
            )
            return False
        self._says_key = True
        return True

    def hear_welcome(self, headers: Mapping[str, str]) -> None:
        """Take what a hub says that has let us in."""
        self._nonce = read_next_nonce(headers.get("Authentication-Info", ""))

    async def save_resume(self, text: str) -> int | None:
        """Keep what the hub handed down; give its number once it is on the disk, else None."""
        held = read_resume(text)
        if held is None:
            return None
        # At once: the connections for pictures and files show it, too.
        self._resume = text
        data = msgspec.json.encode(_SavedPlace(self._mark, text))
        try:
            await self._on_disk(lambda: write_whole(self._path, data))
        # The hub goes on to take the one before, too.
        except OSError as error:
            log.warning("%s cannot be written: %s", self._path, error)
            return None
        return held[0].serial

    def _read(self) -> str:
        try:
            saved = msgspec.json.decode(self._path.read_bytes(), type=_SavedPlace)
        except FileNotFoundError:
            return ""
        # It guards nothing on this side: without it a hub takes us for a new one.
        except (OSError, msgspec.DecodeError) as error:
            log.warning("%s cannot be read: %s; the hub will know us by our key", self._path, error)
            return ""
        return saved.resume if saved.key == self._mark and read_resume(saved.resume) else ""
