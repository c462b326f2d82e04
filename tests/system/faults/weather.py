"""What a bad network does to bytes under way, decided from a seed. Pure.

A WebSocket frame stands alone (length and mask are its own), so on a plain connection whole
frames may be repeated or change places and the stream is still one that TCP could carry.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

HANDSHAKE_END = b"\r\n\r\n"


class Way(StrEnum):
    """A direction, as the gateway sees it."""

    UP = "up"
    DOWN = "down"


@dataclass(frozen=True, slots=True)
class Weather:
    """How the network is now.

    Attributes:
        delay_ms: each piece is this long under way.
        jitter_ms: and up to so much longer; what comes behind waits, as in TCP.
        rate: bytes/s at most; 0 does not throttle.
        split: how likely a piece goes out in small bits.
        duplicate: how likely a whole frame is sent twice.
        reorder: how likely a whole frame changes places with the next.
        dark: ways on which nothing arrives for now; it is kept, as TCP would, and comes late.

    """

    delay_ms: float = 0.0
    jitter_ms: float = 0.0
    rate: float = 0.0
    split: float = 0.0
    duplicate: float = 0.0
    reorder: float = 0.0
    dark: frozenset[Way] = frozenset()


CALM = Weather()


class Frames:
    """Cuts a stream into its opening (HTTP) and its WebSocket frames."""

    def __init__(self) -> None:
        """Begin before the opening."""
        self._kept = b""
        self._opened = False

    def feed(self, data: bytes) -> Iterator[tuple[bytes, bool]]:
        """Give each whole piece, and whether it is a frame that stands alone (no control frame)."""
        self._kept += data
        if not self._opened:
            end = self._kept.find(HANDSHAKE_END)
            if end < 0:
                return
            end += len(HANDSHAKE_END)
            yield self._kept[:end], False
            self._kept, self._opened = self._kept[end:], True
        while (size := _size(self._kept)) is not None and size <= len(self._kept):
            piece, self._kept = self._kept[:size], self._kept[size:]
            # FIN and text or binary: a whole message in one frame.
            yield piece, piece[0] in (0x81, 0x82)

    @property
    def rest(self) -> bytes:
        """What is no whole piece yet."""
        return self._kept


def _size(data: bytes) -> int | None:
    """Give the length of the frame that begins ``data``; none while its head is not there."""
    if len(data) < 2:
        return None
    length, head = data[1] & 0x7F, 2
    if length == 126:
        head, length = 4, int.from_bytes(data[2:4]) if len(data) >= 4 else -1
    elif length == 127:
        head, length = 10, int.from_bytes(data[2:10]) if len(data) >= 10 else -1
    if length < 0:
        return None
    return head + (4 if data[1] & 0x80 else 0) + length


class Dice:
    """The decisions of one direction of one connection: the same seed, the same decisions."""

    def __init__(self, seed: object) -> None:
        """Take what names this direction of this connection in this run."""
        self._chance = random.Random(str(seed))  # noqa: S311 - a test's weather
        self._held: bytes | None = None
        self.duplicated = self.reordered = self.cut = 0

    def deal(self, piece: bytes, whole: bool, weather: Weather) -> list[bytes]:  # noqa: FBT001
        """Give what is to go out for a piece, in order."""
        out = [piece]
        if whole and self._chance.random() < weather.duplicate:
            out.append(piece)
            self.duplicated += 1
        if self._held is not None:
            out.append(self._held)
            self._held = None
        elif whole and self._chance.random() < weather.reorder:
            self._held, out = piece, out[1:]
            self.reordered += 1
        return [bit for each in out for bit in self._bits(each, weather)]

    def last(self) -> list[bytes]:
        """Give what was held back, when the stream ends."""
        held, self._held = self._held, None
        return [held] if held is not None else []

    def _bits(self, piece: bytes, weather: Weather) -> list[bytes]:
        if len(piece) < 2 or self._chance.random() >= weather.split:
            return [piece]
        self.cut += 1
        at = sorted(self._chance.randrange(1, len(piece)) for _ in range(3))
        edges = [0, *at, len(piece)]
        return [piece[a:b] for a, b in pairwise(edges) if a < b]

    def delay_s(self, weather: Weather) -> float:
        """Give how long a piece is under way."""
        return (weather.delay_ms + self._chance.random() * weather.jitter_ms) / 1000
