"""A FITS file of one picture (FITS Standard 4.0)."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Card", "fits_file"]

Card = tuple[str, "str | int | float | bool", str]
# Header and data each fill whole blocks of so many bytes (3.1).
BLOCK = 2880


def fits_file(counts: NDArray[np.uint16], cards: list[Card]) -> bytes:
    """Write unsigned 16-bit counts (bottom row first) with a header.

    Stored as signed with BZERO 32768, the standard's way of unsigned numbers (5.2.5).
    """
    height, width = counts.shape
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
    # FITS has the highest byte of a number first.
    pixels = (counts.astype("i4") - 32768).astype(">i2").tobytes()
    # A header is filled up with blanks, data with zeros.
    return _padded_block(header.encode("ascii"), b" ") + _padded_block(pixels, b"\0")


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
