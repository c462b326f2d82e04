"""Alpaca's pictures as FITS: ImageBytes, and the JSON of servers that do not know it. Pure.

After "ASCOM Alpaca ImageBytes" (metadata version 1): 44 bytes of little-endian numbers, then pixels
as an array ``[x][y]`` or ``[x][y][colour]`` whose last index runs fastest. FITS 4.0 has rows, so
the picture is turned; its first row stays the camera's first, which ``ROWORDER`` says.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from talaia.gateway.adapters.alpaca.protocol import AlpacaRefused
from talaia.gateway.errors import FieldError
from talaia.gateway.fits.header import HeaderCard, rewrite_header

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

__all__ = ["MOST_PIXELS", "fits_of", "pixels_of"]

_METADATA = struct.Struct("<iiIIiiiiiii")
_TYPES = {
    1: "<i2",
    2: "<i4",
    3: "<f8",
    4: "<f4",
    5: "<u8",
    6: "u1",
    7: "<i8",
    8: "<u2",
    9: "<u4",
}
MOST_PIXELS = 150_000_000
_BLOCK = 2880
# FITS's number for what is written, and what is added to be without a sign.
_BITPIX = {"uint8": (8, 0), "int16": (16, 0), "uint16": (16, 32_768), "int32": (32, 0)}
_BITPIX |= {"uint32": (32, 2_147_483_648), "float32": (-32, 0), "float64": (-64, 0)}


class _JsonPicture(msgspec.Struct):
    number: int = msgspec.field(default=0, name="ErrorNumber")
    message: str | None = msgspec.field(default="", name="ErrorMessage")
    value: list[list[Any]] | None = msgspec.field(default=None, name="Value")


def pixels_of(data: bytes) -> NDArray[Any]:
    """Give a picture's pixels as rows and columns, or three planes of them.

    Raises:
        AlpacaRefused: the camera answered with an error.
        FieldError: it is no picture.

    """
    if data[:1] == b"{":
        return _rows_of(_json_pixels(data))
    if len(data) < _METADATA.size:
        raise FieldError("", f"the picture ends in its metadata: {len(data)} bytes")
    version, number, _, _, start, _, kind, rank, *sizes = _METADATA.unpack_from(data)
    if version != 1:
        raise FieldError("", f"expected ImageBytes of version 1, found {version}")
    if not _METADATA.size <= start <= len(data):
        raise FieldError("", f"its pixels begin at {start}, of {len(data)} bytes")
    if number:
        raise AlpacaRefused(number, data[start:].decode(errors="replace"))
    if kind not in _TYPES or rank not in (2, 3):
        raise FieldError("", f"pixels of type {kind} and {rank} dimensions are not known")
    shape = tuple(sizes[:rank])
    if any(size < 1 for size in shape) or (rank == 3 and shape[2] != 3):
        raise FieldError("", f"it is {' × '.join(map(str, shape))} pixels")
    count = int(np.prod([int(size) for size in shape], dtype=object))
    size = np.dtype(_TYPES[kind]).itemsize
    if count > MOST_PIXELS or len(data) - start < count * size:
        raise FieldError("", f"{count} pixels of {size} bytes, found {len(data) - start} bytes")
    return _rows_of(np.frombuffer(data, _TYPES[kind], count, start).reshape(shape))


def _json_pixels(data: bytes) -> NDArray[Any]:
    try:
        answer = msgspec.json.decode(data, type=_JsonPicture)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise FieldError("", f"it is no picture: {data[:60]!r}") from error
    if answer.number:
        raise AlpacaRefused(answer.number, answer.message or "")
    try:
        pixels: NDArray[Any] = np.asarray(answer.value)
    except ValueError as error:
        raise FieldError("", "its columns are of different lengths") from error
    if pixels.dtype.kind not in "iuf" or pixels.ndim not in (2, 3) or not pixels.size:
        raise FieldError("", "it is no array of numbers")
    if pixels.ndim == 3 and pixels.shape[2] != 3:
        raise FieldError("", f"expected three colours, found {pixels.shape[2]}")
    return pixels


def _rows_of(pixels: NDArray[Any]) -> NDArray[Any]:
    """Turn ``[x][y]`` and ``[x][y][colour]`` to rows, in planes."""
    return pixels.T if pixels.ndim == 2 else pixels.transpose(2, 1, 0)


def fits_of(pixels: NDArray[Any], cards: Iterable[HeaderCard]) -> bytes:
    """Give a FITS file of a picture, in the smallest type that holds every pixel.

    Args:
        pixels: rows and columns, or planes of them.
        cards: of its header, beside those of its form.

    """
    kept = _narrowed(pixels)
    bits, zero = _BITPIX[kept.dtype.name]
    height, width = kept.shape[-2:]
    axes = [HeaderCard("NAXIS1", width), HeaderCard("NAXIS2", height)]
    if kept.ndim == 3:
        axes.append(HeaderCard("NAXIS3", kept.shape[0], "red, green, blue"))
    form = [
        HeaderCard("SIMPLE", value=True),
        HeaderCard("BITPIX", bits),
        HeaderCard("NAXIS", kept.ndim),
        *axes,
    ]
    if zero:
        form += [HeaderCard("BZERO", zero, "pixels are without a sign"), HeaderCard("BSCALE", 1)]
    form.append(HeaderCard("ROWORDER", "TOP-DOWN", "the first row is the camera's first"))
    header = rewrite_header(b"", [*form, *cards])
    # A type without a sign is written with one, from its own middle.
    if zero:
        kept = (kept.astype(np.int64) - zero).astype(f">i{kept.dtype.itemsize}")
    body = kept.astype(kept.dtype.newbyteorder(">")).tobytes()
    return header + body + bytes(-len(body) % _BLOCK)


def _narrowed(pixels: NDArray[Any]) -> NDArray[Any]:
    """Give whole numbers in 16 bits where they fit: cameras' 32 are ASCOM's, not the sensor's."""
    if pixels.dtype.kind == "f":
        return pixels
    low, high = int(pixels.min()), int(pixels.max())
    if pixels.dtype.itemsize == 1:
        return pixels
    for kind in (np.uint16, np.int16, np.int32, np.uint32):
        limits = np.iinfo(kind)
        if limits.min <= low and high <= limits.max:
            return pixels.astype(kind)
    return pixels.astype(np.float64)
