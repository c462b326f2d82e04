"""Read one picture of a FITS file into numbers, without astropy. Pure.

From the FITS standard 4.0: blocks of 2880 bytes, cards of 80. For solving and focusing on the way;
the archive reads with astropy, which knows every form. A file that is compressed within, or that
has its picture in an extension, is refused here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from talaia.imaging.errors import UnreadableFrame

__all__ = ["Frame", "read_frame"]

BLOCK, CARD = 2880, 80
# A camera's header has some tens of cards.
_MOST_CARDS = 7200
_TYPES = {8: ">u1", 16: ">i2", 32: ">i4", -32: ">f4", -64: ">f8"}
# No camera has more; a header that says so is wrong or wants to fill the memory.
_MOST_PIXELS = 200_000_000

Value = str | float | bool


class Frame(NamedTuple):
    """A picture.

    Attributes:
        header: values by keyword; of one that comes twice the first.
        pixels: the bottom row first, shape (rows, columns), 32-bit floating point.

    """

    header: dict[str, Value]
    pixels: np.ndarray[tuple[int, int], np.dtype[np.float32]]

    def number(self, *keys: str) -> float | None:
        """Give the first of these keywords that has a finite number."""
        for key in keys:
            value = self.header.get(key)
            if isinstance(value, (int, float)) and not isinstance(value, bool):
                return float(value)
        return None


def read_frame(data: bytes) -> Frame:
    """Read a file's first picture.

    Raises:
        UnreadableFrame: it is not FITS, is cut off, or its picture is not in the first part.

    """
    header, at = _read_header(data)
    bits, axes = header.get("BITPIX"), header.get("NAXIS")
    kind = _TYPES.get(int(bits)) if isinstance(bits, (int, float)) else None
    if kind is None or axes != 2:
        raise UnreadableFrame("its first part has no picture of two axes")
    width, height = (header.get(key) for key in ("NAXIS1", "NAXIS2"))
    if not isinstance(width, (int, float)) or not isinstance(height, (int, float)):
        raise UnreadableFrame("it does not say how large its picture is")
    columns, rows = int(width), int(height)
    if columns < 1 or rows < 1 or columns * rows > _MOST_PIXELS:
        raise UnreadableFrame(f"its picture of {columns} by {rows} pixels has no sense")
    size = np.dtype(kind).itemsize * columns * rows
    if len(data) < at + size:
        raise UnreadableFrame(f"it ends {at + size - len(data)} bytes too soon")
    stored = np.frombuffer(data, kind, columns * rows, at).reshape(rows, columns)
    scale, zero = header.get("BSCALE", 1.0), header.get("BZERO", 0.0)
    # What is too large for 32 bits is infinite, and no reason to warn of each picture.
    with np.errstate(over="ignore", invalid="ignore"):
        pixels = stored.astype(np.float32)
        if isinstance(scale, (int, float)) and isinstance(zero, (int, float)):
            pixels = pixels * np.float32(scale) + np.float32(zero)
    return Frame(header, pixels)


def _read_header(data: bytes) -> tuple[dict[str, Value], int]:
    if data[:9] != b"SIMPLE  =":
        raise UnreadableFrame("it is not FITS: it does not begin with SIMPLE")
    found: dict[str, Value] = {}
    for number in range(min(_MOST_CARDS, len(data) // CARD)):
        card = data[number * CARD : (number + 1) * CARD].decode("ascii", "replace")
        if card.rstrip() == "END":
            return found, ((number + 1) * CARD + BLOCK - 1) // BLOCK * BLOCK
        if card[8:10] == "= ":
            value = _read_value(card[10:].strip())
            if value is not None:
                found.setdefault(card[:8].strip(), value)
    raise UnreadableFrame("its header has no end")


def _read_value(text: str) -> Value | None:
    if text.startswith("'"):
        # A quote within a text stands twice.
        end = text.replace("''", "\0\0").find("'", 1)
        return text[1:end].replace("''", "'").rstrip() if end > 0 else None
    word = text.split("/", 1)[0].strip()
    if word in ("T", "F"):
        return word == "T"
    try:
        value = float(word.replace("D", "E"))
    except ValueError:
        return None
    return value if math.isfinite(value) else None
