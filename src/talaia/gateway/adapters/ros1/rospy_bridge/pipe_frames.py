"""Frames between the node and the gateway, over stdin and stdout.

The form is told in `talaia.gateway.adapters.ros1.frames`, which has the other end and cannot be
imported here; a test holds the two together by talking through both.
"""

# ruff: noqa: ANN401 - frames are JSON: anything
from __future__ import annotations

import json
import os
import struct
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import Any, BinaryIO

HEAD = struct.Struct("<IB")
STAMP = struct.Struct("<Hq")
PIECE = struct.Struct("<IHqII")
JSON, MESSAGE, TAPPED = 0, 1, 2
MAX_FRAME = 16 * 1024 * 1024


class FrameWriter:
    """Writes whole frames; rospy calls from many threads."""

    def __init__(self, fd: int) -> None:
        """Take the pipe."""
        self._fd = fd
        # A pipe takes a large frame in pieces: no other may come between them.
        self._turn = threading.Lock()

    def send_frame(self, **fields: Any) -> None:
        """Write a JSON frame."""
        self.write_frame(JSON, json.dumps(fields).encode())

    def write_frame(self, kind: int, body: bytes) -> None:
        """Write a frame; nothing happens when nobody reads any more."""
        data = memoryview(HEAD.pack(len(body) + 1, kind) + body)
        with self._turn:
            try:
                while data:
                    data = data[os.write(self._fd, data) :]
            except OSError:
                # The reader of stdin hears of it, too, and says the zeros.
                return


def read_frames(pipe: BinaryIO) -> Iterator[dict[str, Any]]:
    """Read JSON frames until the pipe ends."""
    while True:
        head = pipe.read(HEAD.size)
        if len(head) < HEAD.size:
            return
        size, _ = HEAD.unpack(head)
        # Out of step, or not the gateway: as good as its end, for then the zeros are said.
        if not 1 <= size <= MAX_FRAME:
            return
        body = pipe.read(size - 1)
        if len(body) < size - 1:
            return
        yield json.loads(body.decode())
