"""A FITS file of one picture, by the standard library alone (FITS Standard 4.0)."""

from __future__ import annotations

import sys
from array import array

__all__ = ["Card", "fits_file"]

Card = tuple[str, "str | int | float | bool", str]
# Header and data each fill whole blocks of so many bytes (3.1).
BLOCK = 2880


def fits_file(rows: list[array[int]], cards: list[Card]) -> bytes:
    """Write unsigned 16-bit rows (bottom row first) with a header.

    Stored as signed with BZERO 32768, the standard's way of unsigned numbers (5.2.5).
    """
    height, width = len(rows), len(rows[0])
    first: list[Card] = [
        ("SIMPLE", True, "conforms to FITS"),
        ("BITPIX", 16, "bits of a pixel"),
        ("NAXIS", 2, "number of axes"),
        ("NAXIS1", width, "columns"),
        ("NAXIS2", height, "rows"),
        ("BSCALE", 1.0, "value = BZERO + BSCALE * stored"),
        ("BZERO", 32768.0, "unsigned 16-bit"),
    ]
    header = "".join(_card_text(*card) for card in [*first, *cards]) + "END".ljust(80)
    pixels = array("h")
    for row in rows:
        pixels.extend(array("h", [value - 32768 for value in row]))
    # FITS has the highest byte of a number first.
    if sys.byteorder == "little":
        pixels.byteswap()
    # A header is filled up with blanks, data with zeros.
    return _padded_block(header.encode("ascii"), b" ") + _padded_block(pixels.tobytes(), b"\0")


def _padded_block(data: bytes, fill: bytes) -> bytes:
    return data + fill * (-len(data) % BLOCK)


def _card_text(key: str, value: str | float | bool, comment: str) -> str:  # noqa: FBT001 - FITS has it
    if isinstance(value, bool):
        shown = ("T" if value else "F").rjust(20)
    elif isinstance(value, str):
        # Printable ASCII only, and a quote within the text twice.
        clean = "".join(c if " " <= c <= "~" else "?" for c in value).replace("'", "''")
        # At least eight letters between its quotes, as the fixed format has it.
        shown = f"'{clean[:60]:<8}'".ljust(20)
    elif isinstance(value, int):
        shown = str(value).rjust(20)
    else:
        shown = f"{value:.12G}".rjust(20)
        # Without a point it would be read as a whole number.
        if "." not in shown and "E" not in shown:
            shown = f"{value:.1f}".rjust(20)
    return f"{key:<8}= {shown} / {comment}"[:80].ljust(80)
