"""A process that reads FITS files: ``python -m talaia.hub.archive.fits_child``.

It is asked and answers in MessagePack, each behind its length. Files are a gateway's word: one that
takes all memory or time ends this process, and the hub goes on.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Literal

import msgspec

from talaia.hub.archive.child_limits import limit_this_process
from talaia.hub.archive.child_pipes import read_question, write_answer
from talaia.hub.archive.fits_reader import Facts, Looks, NotKept, facts_of, looks_of, preview_of

__all__ = ["FitsAnswer", "FitsQuestion", "main"]

# It writes none but what Python itself may want to.
_MOST_WRITTEN = 1024 * 1024


class FitsQuestion(msgspec.Struct, frozen=True):
    """What is asked of a file."""

    what: Literal["facts", "looks", "preview"]
    path: str
    stretch: str = ""
    most_px: int = 0


class FitsAnswer(msgspec.Struct, frozen=True):
    """What was asked for, or why there is none.

    Attributes:
        refused: it is no picture in FITS.
        unreadable: it is more than can be read here.

    """

    facts: Facts | None = None
    looks: Looks | None = None
    preview: bytes = b""
    refused: str = ""
    unreadable: str = ""


def main() -> None:
    """Answer what is asked on the input, until it ends."""
    limit_this_process(most_written=_MOST_WRITTEN)
    # Whoever looks after robots on this machine goes first.
    os.nice(5)
    asked, answers = sys.stdin.buffer, sys.stdout.buffer
    while (body := read_question(asked)) is not None:
        question = msgspec.msgpack.decode(body, type=FitsQuestion)
        write_answer(answers, msgspec.msgpack.encode(answer_question(question)))


def answer_question(asked: FitsQuestion) -> FitsAnswer:
    """Read what is asked for."""
    path = Path(asked.path)
    try:
        match asked.what:
            case "facts":
                return FitsAnswer(facts=facts_of(path))
            case "looks":
                return FitsAnswer(looks=looks_of(path))
            case "preview":
                return FitsAnswer(preview=preview_of(path, asked.stretch, asked.most_px))
    except NotKept as error:
        return FitsAnswer(refused=str(error))
    except MemoryError:
        return FitsAnswer(unreadable="it takes more memory than may be had")


if __name__ == "__main__":
    main()
