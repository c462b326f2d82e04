"""JPEG files that others made: looked through before they are kept and shown to people. Pure.

A gateway may be anybody's. What is kept is a baseline or progressive JPEG of a sane size with its
end where it ends, and without what a picture does not need: no remarks, no place, no other file
behind it. By ITU-T T.81, annex B.
"""

from __future__ import annotations

__all__ = ["LARGEST_PX", "NotAPicture", "bare_jpeg"]

# A thumbnail is no wallpaper (px a side).
SMALLEST_PX, LARGEST_PX = 8, 1024
# Start and end of image, start of scan, tables, restart interval (T.81, table B.1).
_SOI, _EOI, _SOS, _DQT, _DHT, _DRI = 0xD8, 0xD9, 0xDA, 0xDB, 0xC4, 0xDD
# Baseline, extended sequential and progressive, all with Huffman coding.
_FRAMES = frozenset({0xC0, 0xC1, 0xC2})
_KEPT = frozenset({_DQT, _DHT, _DRI}) | _FRAMES
# Segments without which nothing is lost: those of applications, and remarks.
# APP0 to APP15, and COM.
_LEFT_OUT = frozenset({*range(0xE0, 0xF0), 0xFE})


class NotAPicture(ValueError):
    """What came is no JPEG that can be shown; says what is wrong."""


def bare_jpeg(data: bytes) -> bytes:
    """Give a JPEG with only what is needed to draw it.

    Raises:
        NotAPicture: it is none, or not of 8 to 1024 px a side, grey or in colour.

    """
    if data[:2] != b"\xff\xd8":
        raise NotAPicture("it does not begin like a JPEG")
    kept = [b"\xff\xd8"]
    at, sized = 2, False
    while True:
        marker, at = _marker(data, at)
        if marker == _EOI:
            raise NotAPicture("it ends before its picture begins")
        length = int.from_bytes(data[at : at + 2], "big")
        body = data[at + 2 : at + length]
        # The length counts its own two bytes.
        if length < 2 or len(body) != length - 2:
            raise NotAPicture("it is cut off")
        whole = b"\xff" + bytes([marker]) + data[at : at + length]
        at += length
        if marker in _FRAMES:
            if sized:
                raise NotAPicture("it says its size twice")
            _check_size(body)
            sized = True
        # Coded data follows this header without a length of its own.
        if marker == _SOS:
            if not sized:
                raise NotAPicture("it does not say its size")
            end = _end_of_scan(data, at)
            kept.append(whole + data[at:end])
            at = end
            # Of a progressive picture another segment may follow, and then another scan.
            if data[at : at + 2] == b"\xff\xd9":
                # Another file could hide behind the picture's end.
                if at + 2 != len(data):
                    raise NotAPicture("something follows its end")
                return b"".join([*kept, b"\xff\xd9"])
        elif marker in _KEPT:
            kept.append(whole)
        elif marker not in _LEFT_OUT:
            raise NotAPicture(f"it has a part that is not known here (0x{marker:02x})")


def _marker(data: bytes, at: int) -> tuple[int, int]:
    """Read a marker; give it and where its segment begins."""
    if data[at : at + 1] != b"\xff":
        raise NotAPicture("it is cut off, or not in order")
    # Any number of fill bytes 0xFF may stand before a marker (B.1.1.2).
    while data[at : at + 1] == b"\xff":
        at += 1
    if at >= len(data):
        raise NotAPicture("it is cut off")
    return data[at], at + 1


def _end_of_scan(data: bytes, at: int) -> int:
    """Find the marker behind a scan's data: zeros follow what only looks like one."""
    while True:
        at = data.find(b"\xff", at)
        if at < 0 or at + 1 >= len(data):
            raise NotAPicture("it is cut off")
        after = data[at + 1]
        if after == 0xFF:
            at += 1
        # A stuffed zero or a restart marker belongs to the coded data.
        elif after == 0x00 or 0xD0 <= after <= 0xD7:
            at += 2
        else:
            return at


def _check_size(body: bytes) -> None:
    # Precision, height, width, number of components, then three bytes for each.
    if len(body) < 6 or len(body) != 6 + 3 * body[5]:
        raise NotAPicture("its size cannot be read")
    height, width = int.from_bytes(body[1:3], "big"), int.from_bytes(body[3:5], "big")
    if body[0] != 8 or body[5] not in {1, 3}:
        raise NotAPicture(f"it has {body[5]} colours of {body[0]} bits; expected 1 or 3 of 8")
    # Height 0 would mean that it is told later (DNL); the least size refuses that as well.
    if not (SMALLEST_PX <= width <= LARGEST_PX and SMALLEST_PX <= height <= LARGEST_PX):
        raise NotAPicture(
            f"it is {width} × {height} px; expected {SMALLEST_PX} to {LARGEST_PX} a side"
        )
