"""The planner's process: questions on standard input, answers on standard output.

A frame is four bytes of length (big-endian) and MessagePack. It ends when its input does, and so
with the gateway that began it.
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.night.planning.planner_answers import PlannerAnswers
from talaia.gateway.night.planning.planner_question import PlannerQuestion, PlannerSetup

if TYPE_CHECKING:
    from typing import BinaryIO

__all__ = ["answer_all", "main", "read_frame", "write_frame"]

_decoder: msgspec.msgpack.Decoder[PlannerSetup | PlannerQuestion] = msgspec.msgpack.Decoder(
    PlannerSetup | PlannerQuestion
)


def read_frame(stream: BinaryIO) -> bytes | None:
    """Give the next frame; none at the end."""
    head = stream.read(4)
    if len(head) < 4:
        return None
    data = stream.read(int.from_bytes(head, "big"))
    return data or None


def write_frame(stream: BinaryIO, data: bytes) -> None:
    """Write a frame and let it go."""
    stream.write(len(data).to_bytes(4, "big") + data)
    stream.flush()


def answer_all(source: BinaryIO, sink: BinaryIO) -> None:
    """Answer until the end of ``source``."""
    answers = PlannerAnswers()
    while (frame := read_frame(source)) is not None:
        asked = _decoder.decode(frame)
        if isinstance(asked, PlannerSetup):
            answers.take_setup(asked)
        else:
            write_frame(sink, msgspec.msgpack.encode(answers.answer_question(asked)))


def main() -> int:
    """Run until the gateway is gone."""
    # Behind all that drives and guards on this machine.
    os.nice(10)
    answer_all(sys.stdin.buffer, sys.stdout.buffer)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
