"""What a ``sensor_msgs/Image`` holds, checked, and the same as RGB. Pure.

Long, because one table has every encoding, with how each is read.

Encodings are those of ROS 2's ``sensor_msgs/image_encodings.hpp``. Colours of the YUV kinds are
ITU-R BT.601 in limited range, as OpenCV reads them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol, cast

import numpy as np

from talaia.gateway.errors import FieldError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Bytes = NDArray[np.uint8]

__all__ = ["ENCODINGS", "MOST_PIXELS", "Image", "Pixels", "pixels_of", "rgb_of", "thin_pixels"]

# 8192 x 8192: more is a mistake, or meant ill.
MOST_PIXELS = 8192 * 8192


class Image(Protocol):
    """The fields of a ``sensor_msgs/Image`` that are read here."""

    height: int
    width: int
    encoding: str
    step: int
    data: Bytes


class Pixels(NamedTuple):
    """A picture as it lies in memory, no padding.

    Attributes:
        layout: one of ``RGB BGR RGBA BGRA GRAY`` (rows, columns, bytes a pixel), ``YUYV UYVY``
            (rows, columns, 2), ``NV12 NV21 NV24 I420`` (rows of bytes, all planes below each
            other).
        width: in pixels.
        height: in pixels.
        data: see ``layout``.

    """

    layout: str
    width: int
    height: int
    data: Bytes


class _Kind(NamedTuple):
    """How one encoding lies: bytes a row of ``width``, rows of bytes for ``height``, and more."""

    layout: str
    row: Callable[[int], int]
    rows: Callable[[int], int]
    read: Callable[[Bytes, int, int, bool], Bytes]


def pixels_of(message: object) -> Pixels:
    """Check a ``sensor_msgs/Image`` and give its pixels; 16 bits and floats become 8.

    Raises:
        FieldError: an encoding we do not know, no pixels, too many, or fewer bytes than its size
            asks for.

    """
    image = cast("Image", message)
    kind = ENCODINGS.get(image.encoding)
    if kind is None:
        raise FieldError(
            "encoding",
            # Cut: of a peer's words no more goes into a log or to a page.
            f"{image.encoding[:40]!r} is not known here; publish one of {len(ENCODINGS)} others, "
            "as rgb8, mono16, bayer_rggb8, yuyv, nv12 or 16UC1",
        )
    width, height = image.width, image.height
    if width <= 0 or height <= 0:
        raise FieldError("width", f"the picture is empty ({width}x{height})")
    # Before anything is made of that size: a few bytes must not ask for gigabytes.
    if width * height > MOST_PIXELS:
        raise FieldError("width", f"{width}x{height} pixels are more than {MOST_PIXELS}")
    # Neighbours share their colour, so a row (and for planes a column) has an even number.
    if kind.layout in ("YUYV", "UYVY", "NV12", "NV21", "I420") and (
        width % 2 or (height % 2 and kind.layout[0] in "NI")
    ):
        raise FieldError("width", f"{image.encoding} of the odd size {width}x{height}")
    data = np.frombuffer(cast("bytes", image.data), np.uint8)
    row, rows = kind.row(width), kind.rows(height)
    # 0: not told, so rows lie without padding.
    step = image.step or row
    if step < row:
        raise FieldError("step", f"rows of {step} bytes are too short for {width} pixels ({row})")
    # The last row may lack its padding.
    if data.size < step * (rows - 1) + row:
        raise FieldError(
            "data",
            f"{data.size} bytes are too few for {width}x{height} {image.encoding} "
            f"({step * rows}); the picture is cut off",
        )
    if data.size < step * rows:
        # A view, for the last row has no padding to reshape with; it stays within the size checked
        # above.
        lines = np.lib.stride_tricks.as_strided(data, (rows, row), (step, 1))
    else:
        lines = data[: step * rows].reshape(rows, step)[:, :row]
    big = bool(getattr(image, "is_bigendian", False))
    return Pixels(kind.layout, width, height, kind.read(lines, width, height, big))


def rgb_of(pixels: Pixels) -> Bytes:
    """Give a picture as RGB: rows, columns, 3; contiguous, and a view where it is that already."""
    data = pixels.data
    match pixels.layout:
        case "RGB":
            out = data
        case "BGR":
            # A view with the channels turned round; `ascontiguousarray` below copies it.
            out = data[:, :, ::-1]
        case "RGBA":
            out = data[:, :, :3]
        case "BGRA":
            out = data[:, :, 2::-1]
        case "GRAY":
            out = np.repeat(data, 3, axis=2)
        case "YUYV":
            out = _of_yuv(data[:, :, 0], data[:, 0::2, 1], data[:, 1::2, 1])
        case "UYVY":
            out = _of_yuv(data[:, :, 1], data[:, 0::2, 0], data[:, 1::2, 0])
        case "NV24":
            pairs = data[pixels.height :].reshape(pixels.height, pixels.width, 2)
            out = _of_yuv(data[: pixels.height], pairs[:, :, 0], pairs[:, :, 1])
        case "I420":
            quarter = data[pixels.height :].reshape(2, pixels.height // 2, pixels.width // 2)
            out = _of_yuv(data[: pixels.height], quarter[0], quarter[1])
        case _:
            pairs = data[pixels.height :].reshape(pixels.height // 2, pixels.width // 2, 2)
            # The two kinds differ only in which colour comes first.
            first = 0 if pixels.layout == "NV12" else 1
            out = _of_yuv(data[: pixels.height], pairs[:, :, first], pairs[:, :, 1 - first])
    return np.ascontiguousarray(out)


def thin_pixels(pixels: Pixels, width: int) -> Pixels:
    """Make a picture no wider than ``width`` (0: as it is), by leaving out pixels.

    What is thinned is in one of the layouts with whole pixels, or becomes RGB.
    """
    if not width or pixels.width <= width:
        return pixels
    # Rounded up, so that it is never wider.
    by = -(-pixels.width // width)
    layout, data = pixels.layout, pixels.data
    # Pixels that share their colour cannot be left out one by one.
    if layout not in ("RGB", "BGR", "RGBA", "BGRA", "GRAY"):
        layout, data = "RGB", rgb_of(pixels)
    data = np.ascontiguousarray(data[::by, ::by])
    return Pixels(layout, data.shape[1], data.shape[0], data)


# ── to 8 bits ──


def _to_words(lines: Bytes, big: bool) -> NDArray[np.uint16]:  # noqa: FBT001
    # View and not `astype`: the bytes lie as the sender's machine had them.
    return np.ascontiguousarray(lines).view(">u2" if big else "<u2")


def _plain(depth: int) -> Callable[[Bytes, int, int, bool], Bytes]:
    def read(lines: Bytes, width: int, height: int, _big: bool) -> Bytes:  # noqa: FBT001
        return np.ascontiguousarray(lines).reshape(height, width, depth)

    return read


def _make_high(depth: int) -> Callable[[Bytes, int, int, bool], Bytes]:
    """Take the upper 8 of 16 bits."""

    def read(lines: Bytes, width: int, height: int, big: bool) -> Bytes:  # noqa: FBT001
        return (_to_words(lines, big) >> 8).astype(np.uint8).reshape(height, width, depth)

    return read


def _read_planes(lines: Bytes, _width: int, _height: int, _big: bool) -> Bytes:  # noqa: FBT001
    return np.ascontiguousarray(lines)


# Two bytes a pixel: its own brightness, and one of the two colours in turn.
def _read_pairs(lines: Bytes, width: int, height: int, _big: bool) -> Bytes:  # noqa: FBT001
    return np.ascontiguousarray(lines).reshape(height, width, 2)


# 16UC1 is a depth picture in millimetres (REP 118); 0 is no reading.
def _read_millimetres(lines: Bytes, width: int, height: int, big: bool) -> Bytes:  # noqa: FBT001
    return _near_is_bright(_to_words(lines, big).astype(np.float32) * 1e-3, width, height)


# 32FC1 is a depth picture in metres (REP 118); NaN is no reading.
def _read_metres(lines: Bytes, width: int, height: int, big: bool) -> Bytes:  # noqa: FBT001
    read = np.ascontiguousarray(lines).view(">f4" if big else "<f4")
    return _near_is_bright(read.astype(np.float32), width, height)


def _near_is_bright(distance: NDArray[np.float32], width: int, height: int) -> Bytes:
    """Draw distances (m): white is near, dark is far, black is nowhere (0, NaN, infinite).

    The far end is the smallest power of two metres that holds 98 of 100 readings, so that it
    does not change from picture to picture.
    """
    seen = np.isfinite(distance) & (distance > 0)
    # Every seventh row and column is enough for a percentile.
    some = distance[::7, ::7][seen[::7, ::7]]
    reach = float(np.percentile(some, 98)) if some.size else 1.0
    # At least about a millimetre, however near all of it seems to be.
    far = 2.0 ** np.ceil(np.log2(max(reach, 2.0**-10)))
    near = np.where(seen, np.minimum(distance, far), far) / far
    # From 255 near to 32 far, so that far is still told from nowhere.
    grey = np.where(seen, 255 - 223 * near, 0).astype(np.uint8)
    return grey.reshape(height, width, 1)


# ── Bayer: each cell of two by two has one red, two green, one blue ──

# Where red is in the cell: row, column.
_RED = {"rggb": (0, 0), "bggr": (1, 1), "gbrg": (1, 0), "grbg": (0, 1)}


def _bayer(pattern: str, depth: int) -> Callable[[Bytes, int, int, bool], Bytes]:
    def read(lines: Bytes, width: int, height: int, big: bool) -> Bytes:  # noqa: FBT001
        if width < 2 or height < 2:
            raise FieldError("width", f"{width}x{height} is no Bayer pattern")
        plane = lines if depth == 1 else (_to_words(lines, big) >> 8).astype(np.uint8)
        return _demosaic_plane(plane.reshape(height, width), *_RED[pattern])

    return read


def _demosaic_plane(plane: Bytes, red_row: int, red_column: int) -> Bytes:
    """Fill in the two missing colours of each pixel by the mean of its neighbours (bilinear)."""
    height, width = plane.shape
    # Mirrored without the edge itself, so that the pattern goes on beyond it; 16 bits for the sums.
    wide = np.pad(plane, 1, mode="reflect").astype(np.uint16)

    def at(row: int, column: int, dy: int, dx: int) -> NDArray[np.uint16]:
        return wide[1 + row + dy : 1 + dy + height : 2, 1 + column + dx : 1 + dx + width : 2]

    out = np.empty((height, width, 3), np.uint8)
    for row in (0, 1):
        for column in (0, 1):
            own = at(row, column, 0, 0)
            beside = (at(row, column, 0, -1) + at(row, column, 0, 1)) // 2
            above = (at(row, column, -1, 0) + at(row, column, 1, 0)) // 2
            corners = sum(
                (at(row, column, dy, dx) for dy in (-1, 1) for dx in (-1, 1)), np.uint16(0)
            )
            cell = out[row::2, column::2]
            in_red_row, in_red_column = row == red_row, column == red_column
            # A red or a blue pixel; on the others green is their own.
            if in_red_row == in_red_column:
                first, last = (0, 2) if in_red_row else (2, 0)
                cell[..., first], cell[..., last] = own, corners // 4
                cell[..., 1] = (beside + above) // 2
            else:
                cell[..., 1] = own
                cell[..., 0], cell[..., 2] = (beside, above) if in_red_row else (above, beside)
    return out


def _of_yuv(luma: Bytes, blue: Bytes, red: Bytes) -> Bytes:
    """Turn planes into RGB; the two of colour may be half as wide and high."""
    down, across = luma.shape[0] // blue.shape[0], luma.shape[1] // blue.shape[1]
    # BT.601 in limited range, times 256: 298 is 1.164, and 128 rounds.
    y = (luma.astype(np.int32) - 16) * 298 + 128
    u, v = blue.astype(np.int32) - 128, red.astype(np.int32) - 128

    def spread(plane: NDArray[np.int32]) -> NDArray[np.int32]:
        tall = np.repeat(plane, down, axis=0) if down > 1 else plane
        return np.repeat(tall, across, axis=1) if across > 1 else tall

    out = np.empty((*luma.shape, 3), np.uint8)
    # Red, green and blue: 1.596 V; -0.391 U and -0.813 V; 2.018 U.
    for channel, part in enumerate((409 * v, -100 * u - 208 * v, 516 * u)):
        out[..., channel] = np.clip((y + spread(part)) >> 8, 0, 255)
    return out


# Encodings of one byte a channel, by the number of channels; see `Pixels.layout`.
_BYTES = {
    1: {"mono8": "GRAY", "8UC1": "GRAY"},
    # OpenCV's kinds say nothing of colours; its own order is BGR.
    3: {"rgb8": "RGB", "bgr8": "BGR", "8UC3": "BGR"},
    4: {"rgba8": "RGBA", "bgra8": "BGRA", "8UC4": "BGRA"},
}
# Of two bytes a channel; only the higher one is used.
_WORDS = {
    1: {"mono16": "GRAY"},
    3: {"rgb16": "RGB", "bgr16": "BGR"},
    4: {"rgba16": "RGBA", "bgra16": "BGRA"},
}
# Of two bytes a pixel, where neighbours share their colour; ROS has two names for each.
_PAIRS = {"yuv422": "UYVY", "uyvy": "UYVY", "yuv422_yuy2": "YUYV", "yuyv": "YUYV"}


def _known_encodings() -> dict[str, _Kind]:
    """List the encodings that are known."""

    def same(height: int) -> int:
        return height

    def times(by: int) -> Callable[[int], int]:
        return lambda width: width * by

    kinds: dict[str, _Kind] = {}
    for depth, layouts in _BYTES.items():
        for name, layout in layouts.items():
            kinds[name] = _Kind(layout, times(depth), same, _plain(depth))
    for depth, layouts in _WORDS.items():
        for name, layout in layouts.items():
            kinds[name] = _Kind(layout, times(2 * depth), same, _make_high(depth))
    kinds["16UC1"] = _Kind("GRAY", times(2), same, _read_millimetres)
    kinds["32FC1"] = _Kind("GRAY", times(4), same, _read_metres)
    for name, layout in _PAIRS.items():
        kinds[name] = _Kind(layout, times(2), same, _read_pairs)
    for name, layout in (("nv12", "NV12"), ("nv21", "NV21"), ("i420", "I420")):
        # A full plane of brightness, and two of colour with a quarter each.
        kinds[name] = _Kind(layout, times(1), lambda height: height * 3 // 2, _read_planes)
    # A full plane of brightness, and a pair of colours for every pixel.
    kinds["nv24"] = _Kind("NV24", times(1), times(3), _read_planes)
    for pattern in _RED:
        kinds[f"bayer_{pattern}8"] = _Kind("RGB", times(1), same, _bayer(pattern, 1))
        kinds[f"bayer_{pattern}16"] = _Kind("RGB", times(2), same, _bayer(pattern, 2))
    return kinds


ENCODINGS = _known_encodings()
