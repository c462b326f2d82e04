"""Detectors for tests: small ones made on the spot, and the real one where it has been made."""

from __future__ import annotations

import importlib.util
import os
import struct
from typing import TYPE_CHECKING

import pytest

from talaia.objects.worker import FACE_FILE, OWN_FILE

if TYPE_CHECKING:
    from pathlib import Path


def require_runtime(*more: str) -> None:
    """Skip, and say so, where detectors cannot run; fail where all is required."""
    missing = [each for each in ("onnxruntime", *more) if importlib.util.find_spec(each) is None]
    if missing:
        _without(f"needs {', '.join(missing)}: install talaia[objects,dev]")


def require_own() -> None:
    """The same for NanoDet."""
    require_runtime()
    if not OWN_FILE.exists():
        _without(f"needs {OWN_FILE.name}: python tools/make_detector.py")


def require_faces() -> None:
    """The same for CenterFace."""
    require_runtime()
    if not FACE_FILE.exists():
        _without(f"needs {FACE_FILE.name}: python tools/make_face_detector.py")


def _without(why: str) -> None:
    if os.environ.get("TALAIA_REQUIRE_ALL") == "1":
        pytest.fail(f"{why}, and TALAIA_REQUIRE_ALL=1")
    pytest.skip(why)


def red_detector(path: Path, side: int = 32) -> Path:
    """Write a detector of one class that sees a thing in the middle of every red picture.

    Its box is a quarter of the square on each side of the middle, and as sure as the picture is
    red. The file is written byte by byte (https://onnx.ai/onnx/repo-docs/IR.html), for a test
    needs no library for that.
    """
    half = side / 2
    nodes = [
        _node("ReduceMean", ["picture"], "colours", axes=[2, 3], keepdims=0),
        _node("Slice", ["colours", "zero", "one", "one"], "red"),
        _node("Concat", ["place", "red"], "row", axis=1),
        _node("Unsqueeze", ["row", "two"], "boxes"),
    ]
    constants = [
        _tensor("zero", 7, [1], struct.pack("<q", 0)),
        _tensor("one", 7, [1], struct.pack("<q", 1)),
        _tensor("two", 7, [1], struct.pack("<q", 2)),
        _tensor("place", 1, [1, 4], struct.pack("<4f", half, half, half, half)),
    ]
    graph = b"".join(
        [
            *(_bytes(1, each) for each in nodes),
            _bytes(2, b"red"),
            *(_bytes(5, each) for each in constants),
            _bytes(11, _value("picture", [1, 3, side, side])),
            _bytes(12, _value("boxes", [1, 5, 1])),
        ]
    )
    path.write_bytes(_number(1, 8) + _bytes(8, _number(2, 13)) + _bytes(7, graph))
    return path


def _varint(value: int) -> bytes:
    out = b""
    while value > 127:
        out, value = out + bytes([value & 127 | 128]), value >> 7
    return out + bytes([value])


def _number(field: int, value: int) -> bytes:
    return _varint(field << 3) + _varint(value)


def _bytes(field: int, data: bytes) -> bytes:
    return _varint(field << 3 | 2) + _varint(len(data)) + data


def _node(kind: str, inputs: list[str], output: str, **attributes: int | list[int]) -> bytes:
    said = [_bytes(1, each.encode()) for each in inputs]
    said += [_bytes(2, output.encode()), _bytes(4, kind.encode())]
    for name, value in attributes.items():
        whole = isinstance(value, int)
        numbers = _number(3, value) if whole else b"".join(_number(8, each) for each in value)
        said.append(_bytes(5, _bytes(1, name.encode()) + numbers + _number(20, 2 if whole else 7)))
    return b"".join(said)


def _tensor(name: str, kind: int, shape: list[int], data: bytes) -> bytes:
    sizes = b"".join(_number(1, each) for each in shape)
    return sizes + _number(2, kind) + _bytes(8, name.encode()) + _bytes(9, data)


def _value(name: str, shape: list[int]) -> bytes:
    sizes = b"".join(_bytes(1, _number(1, each)) for each in shape)
    return _bytes(1, name.encode()) + _bytes(2, _bytes(1, _number(1, 1) + _bytes(2, sizes)))
