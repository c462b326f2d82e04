"""Point clouds with fewer points, as bytes: what a page's screen and its line bear. Pure."""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np

__all__ = ["CLOUD_TYPE", "thin_cloud"]

CLOUD_TYPE = "sensor_msgs/msg/PointCloud2"
_MOST_FIELDS = 100


class _Layout(NamedTuple):
    """Where what matters stands in the bytes of a cloud.

    Attributes:
        order: of bytes: struct's sign.
        size_at: of height and width, behind one another.
        steps_at: of point_step and row_step, behind one another.
        data_at: of the length of the data.

    """

    order: str
    size_at: int
    steps_at: int
    data_at: int


def thin_cloud(data: bytes, most: int, *, ros1: bool = False) -> tuple[bytes, int]:
    """Leave each n-th point, so that at most ``most`` are left; give the bytes and n.

    Bytes that are no such cloud, or one whose sizes do not fit, stay as they are (and n is 1):
    whoever reads them finds that out.

    Args:
        data: a `CLOUD_TYPE`, with the encapsulation's header of CDR.
        most: points.
        ros1: as ROS 1 serializes it.

    """
    try:
        layout = _find_layout(data, ros1=ros1)
        height, width = struct.unpack_from(f"{layout.order}II", data, layout.size_at)
        step, row = struct.unpack_from(f"{layout.order}II", data, layout.steps_at)
        (length,) = struct.unpack_from(f"{layout.order}I", data, layout.data_at)
    except struct.error:
        return data, 1
    begin = layout.data_at + 4
    end = begin + length
    if height * width <= most or step < 1 or row < width * step or height * row > length:
        return data, 1
    if end > len(data):
        return data, 1
    every = -(-height * width // most)
    cells = np.frombuffer(data, np.uint8, height * row, begin).reshape(height, row)
    # A row may be padded behind its points.
    points = cells[:, : width * step].reshape(height * width, step)[::every]
    count = len(points)
    head = bytearray(data[:begin])
    struct.pack_into(f"{layout.order}II", head, layout.size_at, 1, count)
    struct.pack_into(f"{layout.order}I", head, layout.steps_at + 4, count * step)
    struct.pack_into(f"{layout.order}I", head, layout.data_at, count * step)
    # `is_dense` is one byte, wherever it stands.
    return bytes(head) + points.tobytes() + data[end:], every


def _find_layout(data: bytes, *, ros1: bool) -> _Layout:
    """Go through a cloud's bytes.

    Raises:
        struct.error: they are none.

    """
    order = "<" if ros1 or data[1:2] == b"\1" else ">"
    at = 0 if ros1 else 4

    def skip_aligned(to: int) -> int:
        # CDR counts from behind its header of four bytes, so that multiples of four stay such.
        return to if ros1 else to + -to % 4

    def text_end(begin: int) -> int:
        (size,) = struct.unpack_from(f"{order}I", data, begin)
        return begin + 4 + int(size)

    # ROS 1 has a sequence number there.
    at = skip_aligned(text_end(at + (12 if ros1 else 8)))
    size_at = at
    (fields,) = struct.unpack_from(f"{order}I", data, at + 8)
    if fields > _MOST_FIELDS:
        raise struct.error
    at += 12
    for _ in range(fields):
        # Name; offset, one byte of type, count.
        at = skip_aligned(text_end(skip_aligned(at))) + 4
        at = skip_aligned(at + 1) + 4
    steps_at = skip_aligned(at + 1)
    return _Layout(order, size_at, steps_at, steps_at + 8)
