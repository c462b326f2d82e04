"""What a camera on the wall sees of the dome's inside. Drawn by spans of colour; pure."""

from __future__ import annotations

import math
from typing import NamedTuple

__all__ = ["HEIGHT", "WIDTH", "View", "draw_view"]

WIDTH, HEIGHT = 320, 240
# The row at which the dome stands on its wall.
FOOT = 170
Colour = tuple[int, int, int]


class View(NamedTuple):
    """What there is to be seen.

    Attributes:
        shutter: 0 closed to 1 open.
        slit: azimuth of the slit (°).
        alt: of the telescope (°).
        az: of the telescope (°).
        light: of the sky, 0 night to 1 day.
        lamp: the lamp inside is on.
        shells: of a clamshell, which has no slit: east and west, each 0 closed to 1 open.

    """

    shutter: float
    slit: float
    alt: float
    az: float
    light: float
    lamp: bool = False
    shells: tuple[float, float] | None = None


def draw_view(view: View) -> bytes:
    """Draw one picture, ``rgb8``, top row first, as seen from the north wall to the south."""
    # Never quite dark, so that something is seen at night.
    inside = max(0.12, 0.9 * view.light * view.shutter, 0.8 if view.lamp else 0.0)
    sky = _mixed_colour((6, 8, 22), (126, 178, 235), view.light)
    rows: list[bytes] = []
    # The slit is seen where it stands in front of the camera, 60° to either side of south.
    aside = (view.slit - 180.0 + 180.0) % 360.0 - 180.0
    centre = WIDTH / 2 + aside / 60.0 * WIDTH / 2
    half = 26.0 * view.shutter
    for y in range(HEIGHT):
        row = bytearray(_row_bytes((58, 60, 66), inside) * WIDTH)
        dome = _dome_half(y)
        if dome > 0:
            _fill_span(row, WIDTH / 2 - dome, WIDTH / 2 + dome, _row_bytes((178, 176, 168), inside))
            if view.shells is not None:
                east, west = (min(dome, _shell_edge(y, shell)) for shell in view.shells)
                _fill_span(row, WIDTH / 2 - east, WIDTH / 2 + west, _row_bytes(sky, 1.0))
            elif half > 0 and y < 150:
                left = max(WIDTH / 2 - dome, centre - half)
                right = min(WIDTH / 2 + dome, centre + half)
                _fill_span(row, left, right, _row_bytes(sky, 1.0))
        if y > 200:
            row = bytearray(_row_bytes((86, 78, 70), inside) * WIDTH)
        rows.append(bytes(row))
    _draw_telescope(rows, view, inside)
    return b"".join(rows)


def _draw_telescope(rows: list[bytes], view: View, inside: float) -> None:
    dark, tube = _row_bytes((40, 42, 48), inside), _row_bytes((30, 58, 120), inside)
    for y in range(150, 215):
        row = bytearray(rows[y])
        _fill_span(row, WIDTH / 2 - 12, WIDTH / 2 + 12, dark)
        rows[y] = bytes(row)
    # Seen from the north: east is at the left.
    alt, az = math.radians(view.alt), math.radians(view.az - 180.0)
    dx, dy = math.cos(alt) * math.sin(az), -math.sin(alt)
    length, radius = 58.0, 11.0
    for step in range(int(length)):
        x, high = WIDTH / 2 + dx * (step - 18), 150 + dy * (step - 18)
        for line in range(max(0, int(high - radius)), min(HEIGHT, int(high + radius))):
            reach = math.sqrt(max(0.0, radius**2 - (line - high) ** 2))
            row = bytearray(rows[line])
            _fill_span(row, x - reach, x + reach, tube)
            rows[line] = bytes(row)


def _shell_edge(y: int, shell: float) -> float:
    """Give how far aside the edge of a shell stands in a row; it turns about the foot's middle."""
    angle = min(1.0, max(0.0, shell)) * math.pi / 2
    # Short of a right angle, where the tangent has no end.
    return 0.0 if y >= FOOT else (FOOT - y) * math.tan(min(angle, 1.57))


def _dome_half(y: int) -> float:
    if y > FOOT:
        return 0.0 if y > 200 else 150.0
    return math.sqrt(max(0.0, 1.0 - ((FOOT - y) / 165.0) ** 2)) * 150.0


def _fill_span(row: bytearray, left: float, right: float, colour: bytes) -> None:
    first, last = max(0, round(left)), min(WIDTH, round(right))
    if last > first:
        row[first * 3 : last * 3] = colour * (last - first)


def _row_bytes(colour: Colour, light: float) -> bytes:
    return bytes(min(255, round(part * light)) for part in colour)


def _mixed_colour(one: Colour, other: Colour, part: float) -> Colour:
    red, green, blue = (round(a + (b - a) * part) for a, b in zip(one, other, strict=True))
    return red, green, blue
