"""Frames between the bridge and the gateway, over stdin and stdout; both ends import this.

A frame is its length (u32, of what follows), its kind (u8) and its body, little-endian. Kind 0 is
a JSON object. All others begin with the number of an entity (u32):

- 1 MESSAGE, to the gateway: when it came and when it was sent (i64, ns since the epoch), its
  publisher's number of it (u64), and the message.
- 2 ANSWER, to the gateway: the number of the call (i64) and the service's response.
- 3 PUBLISH, to the bridge: when it was handed over (i64, monotonic ns) and the message.
- 4 CALL, to the bridge: a number of the gateway's (i64) and the service's request.

Messages are bytes of CDR, as ROS has them.
"""

from __future__ import annotations

import json
import os
import struct
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import IO, Any

HEAD = struct.Struct("<IB")
MESSAGE_HEAD = struct.Struct("<IqqQ")
NUMBERED_HEAD = struct.Struct("<Iq")
JSON, MESSAGE, ANSWER, PUBLISH, CALL = range(5)
MAX_FRAME = 64 * 1024 * 1024


def frame_of(kind: int, *parts: bytes) -> bytes:
    """Write a frame."""
    return b"".join((HEAD.pack(sum(map(len, parts)) + 1, kind), *parts))


def json_frame(fields: dict[str, Any]) -> bytes:
    """Write a frame of JSON."""
    return frame_of(JSON, json.dumps(fields).encode())


def read_frames(pipe: IO[bytes]) -> Iterator[tuple[int, bytes]]:
    """Read frames until the pipe ends, or says what is no frame."""
    while True:
        head = pipe.read(HEAD.size)
        if len(head) < HEAD.size:
            return
        size, kind = HEAD.unpack(head)
        # Out of step, or nobody of ours: as good as its end, for then the zeros are published.
        if not 1 <= size <= MAX_FRAME:
            return
        body = pipe.read(size - 1)
        if len(body) < size - 1:
            return
        yield kind, body


class PipeWriter:
    """Writes whole frames from any thread."""

    def __init__(self, fd: int) -> None:
        """Take the pipe."""
        self._fd = fd
        # A pipe takes a large frame in pieces: no other may come between them.
        self._turn = threading.Lock()

    def write(self, data: bytes) -> None:
        """Write one frame or several; nothing happens when nobody reads any more."""
        rest = memoryview(data)
        with self._turn:
            try:
                while rest:
                    rest = rest[os.write(self._fd, rest) :]
            except OSError:
                # Whoever reads from the other side hears of it, too.
                return
