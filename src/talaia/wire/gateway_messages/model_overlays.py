"""What a model tells of a picture beside boxes, drawn over it: small, and only for viewers."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import Count, Micros, Name, Share
from talaia.wire.message import Message

__all__ = [
    "MAX_OVERLAY_RUNS",
    "ClassLikelihood",
    "DetectedPose",
    "ModelOverlay",
    "OverlayLayer",
]

# Bytes of a map: one that would be larger is told more coarsely.
MAX_OVERLAY_RUNS = 16 * 1024
Cells = Annotated[int, Meta(ge=0, le=160)]


class DetectedPose(Message, frozen=True, kw_only=True, tag="pose"):
    """A thing with its points; places are parts of the picture, from the upper left.

    Attributes:
        points: each by its place and how sure it is, in the order of the model's names.

    """

    score: Share
    left: Share
    top: Share
    right: Share
    bottom: Share
    points: Annotated[list[tuple[Share, Share, Share]], Meta(max_length=64)]


class ClassLikelihood(Message, frozen=True, kw_only=True, tag="likelihood"):
    """How likely a class is of the whole picture."""

    label: Name
    share: Share


class OverlayLayer(Message, frozen=True, kw_only=True, tag="layer"):
    """What is drawn: a map, things with points, or words; by the model's kind.

    Attributes:
        rows, columns: cells of the map, which is of all the picture.
        runs: the map row by row, as pairs of bytes: so many cells (1 to 255), and of what. Of a
            segmentation that is the class's number, of depth how near it is (0 to 15); 255 is
            nothing.
        near, far: of depth in metres: what 15 and 0 are.
        poses: the surest first.
        likely: the likeliest classes, first the likeliest.

    """

    # None has a default: pages fill in those of whole messages only.

    rows: Cells
    columns: Cells
    runs: Annotated[bytes, Meta(max_length=MAX_OVERLAY_RUNS)]
    near: float | None
    far: float | None
    poses: Annotated[list[DetectedPose], Meta(max_length=50)]
    likely: Annotated[list[ClassLikelihood], Meta(max_length=5)]


class ModelOverlay(Message, frozen=True, kw_only=True, tag="overlay"):
    """What a model tells of one picture of a stream; only for those whom a page looks at.

    Attributes:
        seq: of the `PictureFrame` that it is told of.
        time_us: when that picture was taken.
        model: its name in the description.

    """

    stream: Name
    seq: Count
    time_us: Micros
    model: Name
    layer: OverlayLayer
