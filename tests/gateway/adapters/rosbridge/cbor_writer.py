"""CBOR of a value, by the letter of RFC 8949, and typed arrays of RFC 8746; the tests' own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

__all__ = ["TypedArray", "head", "written"]


class TypedArray(NamedTuple):
    """Numbers as one text of bytes."""

    tag: int
    kind: str
    values: list


def head(major: int, number: int) -> bytes:
    if number < 24:
        return bytes([major << 5 | number])
    return bytes([major << 5 | 27]) + number.to_bytes(8, "big")


def written(value: object) -> bytes:
    match value:
        case bool() | None:
            return bytes([7 << 5 | {False: 20, True: 21, None: 22}[value]])
        case int():
            return head(0, value) if value >= 0 else head(1, -1 - value)
        case float():
            return b"\xfb" + np.array(value, ">f8").tobytes()
        case bytes():
            return head(2, len(value)) + value
        case str():
            return head(3, len(value.encode())) + value.encode()
        case TypedArray():
            return head(6, value.tag) + written(np.array(value.values, value.kind).tobytes())
        case list():
            return head(4, len(value)) + b"".join(map(written, value))
        case dict():
            pairs = (written(key) + written(each) for key, each in value.items())
            return head(5, len(value)) + b"".join(pairs)
    raise AssertionError(value)
