"""A camera's JPEG as pixels, whoever sent it; in the process of `jpeg_child` only."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.objects.errors import DetectorError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["MOST_PIXELS", "Unreadable", "decode_pixels"]

# Larger ones are not read (px).
MOST_PIXELS = 4096 * 2304
_MISSING = "pictures cannot be read: simplejpeg is missing; install talaia[objects]"


class Unreadable(DetectorError):
    """A picture that cannot be read; the detectors know nothing of it."""


def decode_pixels(data: bytes) -> NDArray[np.uint8]:
    """Read a JPEG: rows × columns × 3, RGB.

    Raises:
        Unreadable: it is none, too large, or cannot be read here.

    """
    try:
        import simplejpeg
    except ImportError as error:
        raise Unreadable(_MISSING) from error
    try:
        height, width, *_ = simplejpeg.decode_jpeg_header(data)
        # By the header alone, before any memory is given to it: a small file can claim a huge
        # picture.
        if height * width > MOST_PIXELS:
            raise Unreadable(f"a picture of {width} × {height} pixels is too large to be read")
        rgb: NDArray[np.uint8] = simplejpeg.decode_jpeg(data, colorspace="RGB")
    except ValueError as error:
        raise Unreadable(f"a picture cannot be read: {error}") from error
    return rgb
