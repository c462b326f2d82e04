"""Pictures to JPEG and back. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, cast

import numpy as np
import simplejpeg

from talaia.gateway.errors import FieldError
from talaia.gateway.video.pixels import MOST_PIXELS, Pixels, pixels_of, rgb_of, thin_pixels

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["CompressedImageFields", "encode_jpeg", "jpeg_of", "jpeg_size", "pixels_in"]

# Layouts that the codec takes as they are.
_WHOLE = ("RGB", "BGR", "RGBA", "BGRA", "GRAY")
# JPEG's mark of its end.
_END = b"\xff\xd9"


class CompressedImageFields(Protocol):
    """The fields of a ``sensor_msgs/CompressedImage`` that are read here."""

    format: str
    data: NDArray[np.uint8]


def encode_jpeg(pixels: Pixels, quality: int) -> bytes:
    """Encode pixels."""
    data, layout = pixels.data, pixels.layout
    if layout not in _WHOLE:
        data, layout = rgb_of(pixels), "RGB"
    # Half as many colours in both directions, as in films.
    subsampling = "Gray" if layout == "GRAY" else "420"
    jpeg: bytes = simplejpeg.encode_jpeg(
        np.ascontiguousarray(data), quality, layout, subsampling, fastdct=True
    )
    return jpeg


def jpeg_of(message: object, quality: int, width: int) -> tuple[bytes, int, int]:
    """Encode a ``sensor_msgs/Image``: JPEG bytes, width and height.

    Wider pictures than ``width`` (0: no limit) are thinned by a whole number.

    Raises:
        FieldError: an encoding we do not know, or fewer bytes than the size asks for.

    """
    pixels = thin_pixels(pixels_of(message), width)
    return encode_jpeg(pixels, quality), pixels.width, pixels.height


def jpeg_size(message: object) -> tuple[bytes, int, int]:
    """Take the bytes of a ``sensor_msgs/CompressedImage`` that is a JPEG, with width and height.

    Raises:
        FieldError: it is no JPEG, or is cut off.

    """
    data = bytes(cast("CompressedImageFields", message).data)
    try:
        # The header alone: nothing is made of that size before it is checked.
        height, width, _, _ = simplejpeg.decode_jpeg_header(data)
    except ValueError as error:
        shown = cast("CompressedImageFields", message).format[:40]
        raise FieldError("data", f"format {shown!r} is no JPEG ({error})") from error
    if width * height > MOST_PIXELS:
        raise FieldError("data", f"{width}x{height} pixels are more than {MOST_PIXELS}")
    # Some cameras fill up behind the end.
    if _END not in data[-64:] and _END not in data[-4096:].rstrip(b"\0")[-2:]:
        raise FieldError("data", f"the JPEG of {len(data)} bytes is cut off")
    return data, width, height


def pixels_in(jpeg: bytes) -> Pixels:
    """Decode a JPEG.

    Raises:
        FieldError: it cannot be decoded.

    """
    try:
        # Fast and a little less exact: these are looked at, not measured.
        rgb = simplejpeg.decode_jpeg(jpeg, "RGB", fastdct=True, fastupsample=True)
    except ValueError as error:
        raise FieldError("data", f"the JPEG cannot be decoded ({error})") from error
    return Pixels("RGB", rgb.shape[1], rgb.shape[0], rgb)
