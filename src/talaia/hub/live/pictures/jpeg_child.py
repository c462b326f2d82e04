"""A process that reads JPEG pictures: ``python -m talaia.hub.live.pictures.jpeg_child``.

It is given a picture and answers with its pixels, or why there are none. A hostile picture costs
this process and nobody else anything.
"""

from __future__ import annotations

import os
import struct
import sys

from talaia.hub.archive.child_limits import limit_this_process
from talaia.hub.archive.child_pipes import read_question, write_answer
from talaia.hub.live.pictures.jpeg_decoder import Unreadable, decode_pixels

__all__ = ["FORM", "main"]

# Height and width of the pixels that follow; 0 × 0: a text follows that says why there are none.
FORM = struct.Struct(">HH")
# It writes none but what Python itself may want to.
_MOST_WRITTEN = 1024 * 1024


def main() -> None:
    """Read the pictures that come on the input, until it ends."""
    limit_this_process(most_written=_MOST_WRITTEN)
    # Whoever looks after robots on this machine goes first.
    os.nice(5)
    asked, answers = sys.stdin.buffer, sys.stdout.buffer
    while (data := read_question(asked)) is not None:
        try:
            rgb = decode_pixels(data)
        except (Unreadable, MemoryError) as error:
            write_answer(answers, FORM.pack(0, 0), (str(error) or "too large").encode()[:500])
        else:
            write_answer(answers, FORM.pack(*rgb.shape[:2]), rgb.tobytes())


if __name__ == "__main__":
    main()
