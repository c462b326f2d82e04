"""Messages read for pages one after another, so that all together leave the hub its time."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import msgspec

from talaia.clock import SECOND
from talaia.hub.live.taps.type_texts import MessageUnreadable
from talaia.wire.browser import MAX_TREE

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock

__all__ = ["TreeLane"]

# Bytes of a message that is read at once, and of one that is read beside the event loop.
_SMALL, _LARGE = 1024, 16 * 1024
# After each there is a rest so many times as long: all pages together take a third of a core.
_REST = 2


class TreeLane:
    """One for a hub."""

    def __init__(self, clock: Clock) -> None:
        """Measure by ``clock`` (monotonic)."""
        self._clock = clock
        self._turn = asyncio.Lock()
        self._free_ns = 0

    async def encode_tree(self, read: Callable[[bytes], dict[str, object]], data: bytes) -> str:
        """Give a message as JSON; see `message_tree.tree_reader`.

        Raises:
            MessageUnreadable: it is none of its type, or too large as a tree.

        """
        if len(data) <= _SMALL:
            return _encode(read, data)
        async with self._turn:
            rest_ns = self._free_ns - self._clock.monotonic_ns()
            if rest_ns > 0:
                await asyncio.sleep(rest_ns / SECOND)
            began_ns = self._clock.monotonic_ns()
            try:
                if len(data) <= _LARGE:
                    return _encode(read, data)
                return await asyncio.to_thread(_encode, read, data)
            finally:
                now_ns = self._clock.monotonic_ns()
                self._free_ns = now_ns + _REST * (now_ns - began_ns)


def _encode(read: Callable[[bytes], dict[str, object]], data: bytes) -> str:
    tree = msgspec.json.encode(read(data)).decode()
    # Only by names of fields that no robot has.
    if len(tree) > MAX_TREE:
        raise MessageUnreadable(f"a message of {len(tree)} characters is too large to be shown")
    return tree
