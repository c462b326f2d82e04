"""The planner's process: questions on standard input, answers on standard output.

A frame is four bytes of length (big-endian) and MessagePack. While nobody asks it improves its
plan, a bounded number of times after each answer, and gives way as soon as something is on its
input. It ends when its input does, and so with the gateway that began it.
"""

from __future__ import annotations

import os
import select
import sys
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.night.planning.planner_answers import PlannerAnswers
from talaia.gateway.night.planning.planner_question import PlannerQuestion, PlannerSetup

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import BinaryIO

__all__ = ["answer_all", "main", "read_frame", "write_frame"]

_decoder: msgspec.msgpack.Decoder[PlannerSetup | PlannerQuestion] = msgspec.msgpack.Decoder(
    PlannerSetup | PlannerQuestion
)


def read_frame(stream: BinaryIO) -> bytes | None:
    """Give the next frame; none at the end."""
    head = _read_exactly(stream, 4)
    if len(head) < 4:
        return None
    data = _read_exactly(stream, int.from_bytes(head, "big"))
    return data or None


def _read_exactly(stream: BinaryIO, size: int) -> bytes:
    """Read so much, in pieces where a pipe without a buffer gives it so; less at the end."""
    data = bytearray()
    while len(data) < size and (piece := stream.read(size - len(data))):
        data += piece
    return bytes(data)


def write_frame(stream: BinaryIO, data: bytes) -> None:
    """Write a frame and let it go."""
    stream.write(len(data).to_bytes(4, "big") + data)
    stream.flush()


def answer_all(
    source: BinaryIO, sink: BinaryIO, *, waits: Callable[[], bool] = lambda: True
) -> None:
    """Answer until the end of ``source``; improve while nothing ``waits`` to be read there."""
    answers = PlannerAnswers()
    more = False
    while True:
        # A round ends as soon as something waits, and begins again after the answer.
        while more and not waits():
            more = answers.improve_plan(waits)
        if (frame := read_frame(source)) is None:
            return
        asked = _decoder.decode(frame)
        if isinstance(asked, PlannerSetup):
            answers.take_setup(asked)
        else:
            write_frame(sink, msgspec.msgpack.encode(answers.answer_question(asked)))
            more = True


def main() -> int:
    """Run until the gateway is gone."""
    # Behind all that drives and guards on this machine.
    os.nice(10)
    # Without a buffer: what has been read is not seen to wait.
    with open(0, "rb", buffering=0, closefd=False) as source:
        answer_all(source, sys.stdout.buffer, waits=lambda: _is_readable(0))
    return 0


def _is_readable(number: int) -> bool:
    """Tell whether something, or the end, can be read."""
    return bool(select.select([number], [], [], 0.0)[0])


if __name__ == "__main__":
    raise SystemExit(main())
