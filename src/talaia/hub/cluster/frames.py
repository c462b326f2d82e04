"""What hubs send each other: a kind, whose tunnel, a number, bytes; under a key. Pure."""

from __future__ import annotations

import enum
import hashlib
import hmac
import struct
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["LARGEST_PIECE", "FrameKind", "FrameSeal", "SequenceCheck", "TunnelFrame", "cut_pieces"]

# Bytes. Below the megabyte that NATS takes unless it is told otherwise; and small enough that a
# driving frame, which has a connection of its own, waits for no copy of a long one.
LARGEST_PIECE = 128 * 1024

_HEAD = struct.Struct("<BQQ")
_MAC_BYTES = 16


class FrameKind(enum.IntEnum):
    """What a frame does."""

    OPEN = 1  # a request begins: what it is about
    PIECE = 2  # a message, and more of it follows
    LAST = 3  # a message, or the end of one that came in pieces
    CREDIT = 4  # so many bytes were taken; so many more may come
    END = 5  # nothing more comes; the reason, empty after a good end
    NOTICE = 6  # a hub is here, and how it stands
    SHARED = 7  # one message for many sockets; see `shared_frames`


class TunnelFrame(NamedTuple):
    """One frame.

    Attributes:
        tunnel: which request it belongs to; numbers rise at the hub that opens them.
        sequence: of this direction of this tunnel, from 0 on, without a hole.

    """

    kind: FrameKind
    tunnel: int
    sequence: int
    payload: bytes


class FrameSeal:
    """Writes frames and reads them back; who has not the hubs' key can make none."""

    def __init__(self, key: bytes) -> None:
        """Take the key that all hubs share."""
        # By subject: a frame that was meant for one hub fits no other one.
        self._key = key
        self._begun: dict[str, hashlib.blake2b] = {}

    def write_frame(self, subject: str, frame: TunnelFrame) -> bytes:
        """Give the bytes of a frame that goes to ``subject``."""
        body = _HEAD.pack(frame.kind, frame.tunnel, frame.sequence) + frame.payload
        return self._mac_of(subject, body) + body

    def read_frame(self, subject: str, data: bytes) -> TunnelFrame | None:
        """Read a frame that came to ``subject``; None when it is none of the hubs'."""
        mac, body = data[:_MAC_BYTES], data[_MAC_BYTES:]
        if len(body) < _HEAD.size or not hmac.compare_digest(mac, self._mac_of(subject, body)):
            return None
        kind, tunnel, sequence = _HEAD.unpack_from(body)
        try:
            known = FrameKind(kind)
        except ValueError:
            # Of a newer version; its tunnel sees the hole.
            return None
        return TunnelFrame(known, tunnel, sequence, body[_HEAD.size :])

    def _mac_of(self, subject: str, body: bytes) -> bytes:
        begun = self._begun.get(subject)
        if begun is None:
            begun = hashlib.blake2b(subject.encode() + b"\0", key=self._key, digest_size=_MAC_BYTES)
            # Subjects are few: one for each other hub and lane. A stranger's are not kept.
            if len(self._begun) < 1000:
                self._begun[subject] = begun
        mac = begun.copy()
        mac.update(body)
        return mac.digest()


class SequenceCheck:
    """Whether frames come without a hole, and none twice."""

    def __init__(self) -> None:
        """Expect the first."""
        self._next = 0

    def accept_number(self, sequence: int) -> bool:
        """Tell whether this is the one that follows; after a hole none is."""
        if sequence != self._next:
            return False
        self._next += 1
        return True


def cut_pieces(data: bytes, largest: int = LARGEST_PIECE) -> Iterator[tuple[FrameKind, bytes]]:
    """Cut a message into frames' payloads; an empty one is one frame, too."""
    end = max(1, len(data))
    for at in range(0, end, largest):
        kind = FrameKind.LAST if at + largest >= end else FrameKind.PIECE
        yield kind, data[at : at + largest]
