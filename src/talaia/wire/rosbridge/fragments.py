"""Messages that go in fragments, each way."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.wire.rosbridge.client_messages import RosbridgeFragment

__all__ = ["LEAST_FRAGMENT", "FragmentAssembly", "split_text"]

# Letters: smaller ones would make more of the fragments' heads than of what they carry.
LEAST_FRAGMENT = 256
# Messages of one client that are not whole yet; the oldest gives way.
_MOST_OPEN = 8


class _OpenMessage:
    """The fragments of one message that have come."""

    __slots__ = ("parts", "size", "total")

    def __init__(self, total: int) -> None:
        self.parts: dict[int, str] = {}
        self.total = total
        self.size = 0


class FragmentAssembly:
    """What one client has sent in fragments, bounded whatever it sends."""

    def __init__(self, most: int) -> None:
        """Hold at most ``most`` letters of all messages that are under way."""
        self._most = most
        # By the message's id, the oldest first.
        self._open: dict[str | int | None, _OpenMessage] = {}
        self._size = 0

    @property
    def size(self) -> int:
        """How many letters are held."""
        return self._size

    def add_fragment(self, fragment: RosbridgeFragment) -> str | None:
        """Take a fragment; give the whole message when this was its last.

        Raises:
            PeerError: fragments that do not fit together, or too many letters (code 1009).

        """
        message = self._open.get(fragment.id)
        if message is None:
            while len(self._open) >= _MOST_OPEN:
                self._forget_message(next(iter(self._open)))
            message = self._open.setdefault(fragment.id, _OpenMessage(fragment.total))
        fits = fragment.total == message.total and fragment.num < message.total
        if not fits or not fragment.data or fragment.num in message.parts:
            self._forget_message(fragment.id)
            raise PeerError(f"fragment {fragment.num} of {fragment.total} fits no message")
        if self._size + len(fragment.data) > self._most:
            self._forget_message(fragment.id)
            raise PeerError(f"fragments of over {self._most} letters wait for their rest", 1009)
        message.parts[fragment.num] = fragment.data
        message.size += len(fragment.data)
        self._size += len(fragment.data)
        if len(message.parts) < message.total:
            return None
        self._forget_message(fragment.id)
        return "".join(message.parts[at] for at in range(message.total))

    def _forget_message(self, message_id: str | int | None) -> None:
        message = self._open.pop(message_id, None)
        if message is not None:
            self._size -= message.size


def split_text(text: str, size: int, message_id: str) -> Iterator[str]:
    """Give the JSON of each fragment of a message's text, ``size`` letters in each."""
    size = max(size, LEAST_FRAGMENT)
    total = (len(text) + size - 1) // size
    for number in range(total):
        fragment = {
            "op": "fragment",
            "id": message_id,
            "data": text[number * size : (number + 1) * size],
            "num": number,
            "total": total,
        }
        yield msgspec.json.encode(fragment).decode()
