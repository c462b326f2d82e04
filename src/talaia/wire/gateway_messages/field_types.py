"""Bounded types of the fields that messages between gateway and hub have in common."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.columns import MAX_SAMPLES

__all__ = [
    "MAX_PICTURE",
    "PIECE",
    "Arguments",
    "AskedText",
    "ChannelColumn",
    "Count",
    "Deflated",
    "Digest",
    "FileId",
    "FormList",
    "Forms",
    "JointSpeeds",
    "Micros",
    "Millis",
    "Name",
    "OffsetColumn",
    "Pixels",
    "Scalar",
    "Sentence",
    "Share",
    "Texts",
    "Thumbnail",
    "Units",
    "ValueColumn",
    "Word",
]

Name = Annotated[str, Meta(min_length=1, max_length=200)]
Sentence = Annotated[str, Meta(max_length=2000)]
# Half of what an i64 holds: two of them can be added or subtracted without overflow.
Count = Annotated[int, Meta(ge=0, le=2**62)]
# May be empty.
Word = Annotated[str, Meta(max_length=200)]
Micros = Annotated[int, Meta(ge=-(2**62), le=2**62)]
# Up to 34 years.
Millis = Annotated[int, Meta(ge=0, le=2**40)]
Pixels = Annotated[int, Meta(ge=0, le=16_384)]
# What a command's argument may be: no lists, no maps.
Scalar = float | int | bool | Annotated[str, Meta(max_length=10_000)]
Arguments = Annotated[dict[Name, Scalar], Meta(max_length=100)]
Units = Annotated[dict[Name, Word], Meta(max_length=100)]
# One column of a batch: so many bytes a sample; see `wire.columns`.
ChannelColumn = Annotated[bytes, Meta(max_length=2 * MAX_SAMPLES)]
OffsetColumn = Annotated[bytes, Meta(max_length=4 * MAX_SAMPLES)]
ValueColumn = Annotated[bytes, Meta(max_length=8 * MAX_SAMPLES)]
# Of the joints of an arm and its hand, in the description's order.
JointSpeeds = Annotated[list[float], Meta(max_length=32)]
Texts = Annotated[dict[int, Sentence], Meta(max_length=MAX_SAMPLES)]
FormList = Annotated[list[Word], Meta(max_length=16)]
Forms = Annotated[dict[Name, FormList], Meta(max_length=1000)]
# SHA-256 or HMAC-SHA256, as small hexadecimal letters.
Digest = Annotated[str, Meta(pattern="^[0-9a-f]{64}$")]
# It becomes part of a file's name at the hub: no dot and no slash gets in.
FileId = Annotated[str, Meta(pattern="^[0-9A-Za-z]{1,32}(-[0-9a-z]{1,16})?$")]
# A description's text, deflated (zlib), so that it stands before a driving frame for little.
Deflated = Annotated[bytes, Meta(max_length=1024 * 1024)]
Share = Annotated[float, Meta(ge=0, le=1)]
# A sighting goes over the link, where driving frames are: its picture is small.
Thumbnail = Annotated[bytes, Meta(max_length=64 * 1024)]
# Less than `Deflated`: with the rest of the message it has to fit a frame to the gateway.
AskedText = Annotated[bytes, Meta(max_length=768 * 1024)]
# Bytes of a recording that go in one frame.
PIECE = 64 * 1024
# A picture is at most this large; a link frame is far smaller.
MAX_PICTURE = 8 * 1024 * 1024
