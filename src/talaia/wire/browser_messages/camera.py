"""Messages of a camera's own socket, both ways."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import (
    MAX_PICTURE,
    Count,
    Micros,
    Name,
    Pixels,
    Word,
)
from talaia.wire.gateway_messages.model_overlays import OverlayLayer
from talaia.wire.gateway_messages.pictures import DetectedObject
from talaia.wire.message import Message

__all__ = [
    "BoxesRequest",
    "CameraPicture",
    "CameraPictureBoxes",
    "CameraPictureOverlay",
    "PictureShown",
    "ViewerAttention",
]


class CameraPicture(Message, frozen=True, kw_only=True, tag="shot"):
    """One picture. ``hub_us`` is the moment of capture on the hub's monotonic clock.

    Attributes:
        format: ``jpeg`` or ``h264``; see `talaia.wire.frames.PictureFrame`.
        key: it needs no picture before it.
        codec: of ``h264``: as WebCodecs names it.
        small: it is smaller than the camera's own, since the connection is slow.

    """

    seq: Count
    time_us: Micros
    hub_us: Micros
    width: Pixels
    height: Pixels
    format: Word
    key: bool = True
    codec: Word = ""
    small: bool = False
    data: Annotated[bytes, Meta(max_length=MAX_PICTURE)]


class PictureShown(Message, frozen=True, kw_only=True, tag="shown"):
    """The page has drawn picture ``seq``; the hub may send another. At most two are under way."""

    seq: Count


class ViewerAttention(Message, frozen=True, kw_only=True, tag="glance"):
    """The page is not looked at closely now (hidden): a picture a second will do, or no more."""

    still: bool


class CameraPictureBoxes(Message, frozen=True, kw_only=True, tag="shot_boxes"):
    """What is seen on the picture ``seq``, which may be shown already, or never come.

    Attributes:
        time_us: when that picture was taken.
        things: the surest first.

    """

    seq: Count
    time_us: Micros
    things: Annotated[list[DetectedObject], Meta(max_length=100)]


class CameraPictureOverlay(Message, frozen=True, kw_only=True, tag="shot_overlay"):
    """What a model tells of the picture ``seq``, which may be shown already, or never come.

    Attributes:
        time_us: when that picture was taken.
        model: its name in the description.

    """

    seq: Count
    time_us: Micros
    model: Name
    layer: OverlayLayer


class BoxesRequest(Message, frozen=True, kw_only=True, tag="boxes_ask"):
    """The page wants `CameraPictureBoxes` from here on, or no more.

    Attributes:
        overlays: it wants `CameraPictureOverlay`s.

    """

    on: bool
    overlays: bool = False
