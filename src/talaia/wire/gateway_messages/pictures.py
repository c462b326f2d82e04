"""Pictures of cameras, and what is detected on them, from a gateway to its hub."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import (
    MAX_PICTURE,
    Count,
    FormList,
    Forms,
    Micros,
    Name,
    Pixels,
    Sentence,
    Share,
    Thumbnail,
    Word,
)
from talaia.wire.message import Message

__all__ = [
    "DetectedBoxes",
    "DetectedObject",
    "KeyframeRequest",
    "LineCrossing",
    "PictureForm",
    "PictureFrame",
    "SightingReport",
    "StreamError",
    "StreamSubscription",
    "ZoneStay",
    "camera_address",
    "unblurred_address",
]

# Of a sighting (s): longer than anything is in sight.
Seconds = Annotated[float, Meta(ge=0, le=1e9)]
# On the floor (m/s); a wrong calibration may give anything.
Speed = Annotated[float, Meta(ge=0, le=1e6)]
# Behind a camera's address: its pictures as they are, where others get them blurred. It is a
# stream of its own, which a hub asks for only while somebody looks who may.
_UNBLURRED = "!unblurred"


def unblurred_address(camera: str) -> str:
    """Give the address of a camera's pictures as they are (``device/stream!unblurred``)."""
    return camera_address(camera) + _UNBLURRED


def camera_address(stream: str) -> str:
    """Give the camera's own address (``device/stream``) of any of its streams."""
    return stream.partition("!")[0]


class PictureForm(StrEnum):
    """How a picture travels: two sizes of each of two encodings, and now and then one picture.

    On the wire it is a plain word, so that a peer may know more of them than we do.
    """

    H264 = "h264"
    H264_SMALL = "h264_small"
    JPEG = "jpeg"
    JPEG_SMALL = "jpeg_small"
    STILL = "still"


class StreamSubscription(Message, frozen=True, kw_only=True, tag="watch"):
    """The streams (``device/stream``) that anyone looks at now; all others rest.

    A camera that is blurred has another one, ``device/stream!unblurred``, of its pictures as they
    are.

    Attributes:
        forms: by stream: the `PictureForm`s that are wanted; a stream that is not in it is wanted
            as JPEG, by a hub that knows nothing else.
        boxes: of which the `DetectedBoxes` are wanted, too.
        overlays: of which the `ModelOverlay`s are.

    """

    streams: Annotated[list[Name], Meta(max_length=1000)]
    forms: Forms = {}
    boxes: Annotated[list[Name], Meta(max_length=1000)] = []
    overlays: Annotated[list[Name], Meta(max_length=1000)] = []


class KeyframeRequest(Message, frozen=True, kw_only=True, tag="key"):
    """Make the next picture of a stream, in this form, one that needs none before it."""

    stream: Name
    form: Word


class PictureFrame(Message, frozen=True, kw_only=True, tag="picture"):
    """One picture of a stream, stamped at the gateway.

    Attributes:
        seq: the picture's number, the same in all forms; pictures may be left out.
        format: ``jpeg`` or ``h264`` (Annex B, no reordering).
        forms: which of the forms asked for this serves; none from a gateway that knows none.
        key: it needs no picture before it.
        codec: of ``h264``: as WebCodecs names it (``avc1.42C01E``).
        data: the encoded picture.

    """

    stream: Name
    seq: Count
    time_us: Micros
    # The hub makes it a time of its own clock by the beats; wall clocks may be wrong.
    mono_us: Micros
    width: Pixels
    height: Pixels
    format: Name = "jpeg"
    forms: FormList = []
    key: bool = True
    codec: Word = ""
    data: Annotated[bytes, Meta(max_length=MAX_PICTURE)]


class StreamError(Message, frozen=True, kw_only=True, tag="trouble"):
    """A camera's pictures cannot be shown, and why; sent once, only to a hub that names forms."""

    stream: Name
    why: Sentence


class DetectedObject(Message, frozen=True, kw_only=True, tag="thing"):
    """One thing on a picture; places are parts of its width and height, from the upper left."""

    label: Name
    score: Share
    left: Share
    top: Share
    right: Share
    bottom: Share


class DetectedBoxes(Message, frozen=True, kw_only=True, tag="boxes"):
    """What is seen on one picture of a stream; sent only for those that `StreamSubscription` names.

    Attributes:
        seq: of the `PictureFrame` that it was seen on.
        time_us: when that picture was taken.
        things: the surest first; also those that do not count (`talaia.model.detection.Detect`).

    """

    stream: Name
    seq: Count
    time_us: Micros
    things: Annotated[list[DetectedObject], Meta(max_length=100)]


class ZoneStay(Message, frozen=True, kw_only=True, tag="stay"):
    """That something was in a zone of a camera's picture: how often it came, and how long (s)."""

    zone: Name
    entries: Count
    dwell_s: Seconds


class LineCrossing(Message, frozen=True, kw_only=True, tag="crossing"):
    """That something crossed a line on a camera's picture: how often to each side."""

    line: Name
    left: Count
    right: Count


class SightingReport(Message, frozen=True, kw_only=True, tag="seen"):
    """A thing came into sight, is seen surer or with more of its class, or is gone.

    On the link, to a hub that takes it (`Welcome`). ``stream``, ``label`` and ``began_us`` tell
    sightings apart; the same one may be told again, and what is told last counts.

    Attributes:
        many: how many of the class at once meanwhile, at the most so far.
        confidence: of the surest so far.
        began_us: when it was seen first.
        ended_us: when it was seen last; 0 while it is in sight.
        thumbnail: JPEG of a moment of it; empty while there is none, or as it was told before.
        path: where it stood, so far: time (µs), and parts of the picture's width and height.
        stays: in the camera's zones.
        crossings: of the camera's lines.
        speed: its mean on the floor (m/s); none where that is not known.

    """

    stream: Name
    label: Name
    many: Count
    confidence: Share
    began_us: Micros
    ended_us: Micros = 0
    thumbnail: Thumbnail = b""
    path: Annotated[list[tuple[Micros, Share, Share]], Meta(max_length=64)] = []
    stays: Annotated[list[ZoneStay], Meta(max_length=32)] = []
    crossings: Annotated[list[LineCrossing], Meta(max_length=32)] = []
    speed: Speed | None = None
