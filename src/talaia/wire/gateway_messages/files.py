"""Recordings and files for the archive, from a gateway to its hub."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import (
    PIECE,
    Count,
    Digest,
    FileId,
    Micros,
    Millis,
    Name,
    Sentence,
    Word,
)
from talaia.wire.message import Message

__all__ = [
    "ArchiveOffer",
    "FileOffer",
    "FilePiece",
    "FileProgress",
    "FilmOffer",
    "RecorderState",
    "RecordingRequest",
]


class RecorderState(Message, frozen=True, kw_only=True, tag="record_state"):
    """Whether raw topics are being recorded. Sent on every change and at the start of a link.

    Attributes:
        id: the recording's own name; empty while there is none.
        since_us: its earliest message.
        ends_ms: it ends by itself after so long.
        problem: why the last one failed, or nothing can be recorded.
        films: cameras that are being filmed.
        can_film: whether this gateway can film at all.

    """

    on: bool
    id: Word = ""
    why: Sentence = ""
    who: Sentence = ""
    since_us: Micros = 0
    ends_ms: Millis = 0
    problem: Sentence = ""
    films: Annotated[list[Name], Meta(max_length=1000)] = []
    can_film: bool = False


class FileOffer(Message, frozen=True, kw_only=True, tag="file_offer"):
    """A recording that the gateway has, and hands over if the hub says how much of it it has.

    Attributes:
        id: the recording's own name, never used twice by a site.
        size: bytes.
        digest: SHA-256 of all of it.
        why: what began it.

    """

    id: FileId
    size: Count
    digest: Digest
    begin_us: Micros
    end_us: Micros
    why: Sentence = ""
    who: Sentence = ""
    # What is in it, so that lists need not open the file.
    messages: Count = 0
    topics: Annotated[list[Name], Meta(max_length=1000)] = []
    note: Sentence = ""


class FilmOffer(Message, frozen=True, kw_only=True, tag="film_offer"):
    """The gateway has a film of a camera (MP4); answered and taken as a `FileOffer` is.

    The time of a picture is ``begin_us`` and its time in the film.

    Attributes:
        id: the film's own name, never used twice by a site, nor for a recording.
        digest: SHA-256 of all of it.
        begin_us: when its first picture came.
        end_us: when its last one did.
        why: what began it.

    """

    id: FileId
    stream: Name
    size: Count
    digest: Digest
    begin_us: Micros
    end_us: Micros
    pictures: Count = 0
    why: Sentence = ""
    who: Sentence = ""
    note: Sentence = ""


class FilePiece(Message, frozen=True, kw_only=True, tag="file_piece"):
    """The bytes of the offered file from ``at`` on, with their CRC-32."""

    id: FileId
    at: Count
    check: Annotated[int, Meta(ge=0, lt=2**32)]
    data: Annotated[bytes, Meta(max_length=PIECE)]


class ArchiveOffer(Message, frozen=True, kw_only=True, tag="archive_offer"):
    """The gateway has a file for the hub's archive; answered and taken as a `FileOffer` is.

    Attributes:
        id: the gateway's own name for it, never used twice.
        kind: what it is and so where it goes: ``fits``; ``mesh``, if the hub has asked for it.
        device: whose it is.
        digest: SHA-256 of the whole.
        time_us: when it was made.

    """

    id: FileId
    kind: Name
    device: Word = ""
    size: Count
    digest: Digest
    time_us: Micros = 0


class RecordingRequest(Message, frozen=True, kw_only=True, tag="record"):
    """Begin or end a recording of raw topics. The hub has seen to the right.

    Attributes:
        stream: only the film of this camera is meant.
        alarm: an alarm begins it, not a person: it goes on as long as one that began by itself,
            if the description wants that.

    """

    on: bool
    who: Name
    why: Sentence = ""
    alarm: bool = False
    stream: Name = ""


class FileProgress(Message, frozen=True, kw_only=True, tag="file_have"):
    """How much of an offered file the hub has; the answer to each offer and piece.

    Attributes:
        have: bytes, from the beginning.
        done: all of it is there and its digest is right: the gateway may forget it.
        refused: why the hub does not take it; it is not offered again soon.

    """

    id: FileId
    have: Count = 0
    done: bool = False
    refused: Sentence = ""
