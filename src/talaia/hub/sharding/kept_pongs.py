"""Answers to a page's pings while the main shard, whose clock they tell, is away."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.sharding.page_frames import data_of, is_pong
from talaia.wire.browser import FROM_BROWSER, TO_BROWSER, PagePing, PagePong
from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from starlette.types import Message

    from talaia.clock import Clock

__all__ = ["KeptPongs"]


class KeptPongs:
    """One page's pings; without answers it would leave, though other shards go on."""

    def __init__(self, clock: Clock) -> None:
        """Go on with the main shard's clock by ``clock``."""
        self._clock = clock
        # How far that one is ahead (monotonic, µs); None: it has not answered yet.
        self._ahead_us: int | None = None

    def hear(self, data: bytes | str) -> None:
        """Take what the main shard has told the page."""
        if is_pong(data) and isinstance(pong := TO_BROWSER.decode(data), PagePong):
            self._ahead_us = pong.hub_us - self._now_us()

    def answer_ping(self, message: Message) -> PagePong | None:
        """Answer a ping in the main shard's place; None: it is none."""
        try:
            ping = FROM_BROWSER.decode(data_of(message))
        except PeerError:
            return None
        if self._ahead_us is None or not isinstance(ping, PagePing):
            return None
        return PagePong(n=ping.n, at_ms=ping.at_ms, hub_us=max(0, self._now_us() + self._ahead_us))

    def _now_us(self) -> int:
        return self._clock.monotonic_ns() // 1000
