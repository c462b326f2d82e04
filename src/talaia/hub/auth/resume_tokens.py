"""What a gateway is handed down on a link, by which it is known on the next one.

The hub keeps none of it: what it hands down it can make again by a key of its own, that stands in
no database. So nobody but the hub makes one, and it is good over restarts of the hub.
"""

from __future__ import annotations

import hashlib
import hmac
from typing import TYPE_CHECKING

from talaia.wire.gateway_proof import ResumeToken, resume_answer

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.wire.gateway_proof import KeyProof

__all__ = ["ResumeTokens"]


class ResumeTokens:
    """Makes them, and knows its own again."""

    def __init__(self, key: Callable[[], bytes], clock: Clock) -> None:
        """Make them by ``key``, which is asked for when it is needed; ``clock`` numbers them."""
        self._key = key
        self._clock = clock
        self._last = 0

    def issue_token(self, lineage: int = 0) -> ResumeToken:
        """Number the next link; of no ``lineage``: it begins one."""
        # By time, so that they rise over restarts; and always, so that no two are the same.
        self._last = max(self._last + 1, self._clock.wall_ns() // 1000)
        return ResumeToken(lineage or self._last, self._last)

    def write_token(self, gateway: int, token: ResumeToken) -> str:
        """Write what a gateway is handed down: its numbers, and the secret."""
        return f"{token.lineage}.{token.serial}.{self._secret_of(gateway, token).hex()}"

    def read_token(self, gateway: int, said: KeyProof, path: str) -> ResumeToken | None:
        """Give which place a gateway has shown that it had; None: it has shown none."""
        if not said.resume:
            return None
        # Made again from the numbers that it says: nothing is kept, so nothing can be lost.
        secret = self._secret_of(gateway, said.place)
        right = resume_answer(secret, nonce=said.nonce, site=said.site, path=path)
        # In constant time, or an answer could be guessed digit by digit.
        return said.place if hmac.compare_digest(right, said.resume) else None

    def _secret_of(self, gateway: int, token: ResumeToken) -> bytes:
        # The gateway's number is in it: with another key everything begins anew.
        said = b"%d.%d.%d" % (gateway, token.lineage, token.serial)
        return hmac.new(self._key(), said, hashlib.sha256).digest()
