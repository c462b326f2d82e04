"""Write an ONNX file: the few messages of its protocol buffers that a graph needs.

The numbers are those of https://github.com/onnx/onnx/blob/main/onnx/onnx.proto, the encoding is
https://protobuf.dev/programming-guides/encoding. ONNX's own package would be 20 MB more to install
for everybody who starts the product from its sources.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

IR_VERSION = 8
OPSET = 18
FLOAT = 1
TYPES = {np.dtype("<f4"): FLOAT, np.dtype("<i4"): 6, np.dtype("<i8"): 7}

Attribute = int | float | str | Sequence[int]


def varint(number: int) -> bytes:
    """Give a whole number; a negative one as its 64-bit complement."""
    number &= 0xFFFFFFFFFFFFFFFF
    out = bytearray()
    while number > 0x7F:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    out.append(number)
    return bytes(out)


def whole(field: int, number: int) -> bytes:
    """Give a field that holds a whole number."""
    return varint(field << 3) + varint(number)


def block(field: int, content: bytes | str) -> bytes:
    """Give a field that holds bytes, a text or a message."""
    data = content.encode() if isinstance(content, str) else content
    return varint(field << 3 | 2) + varint(len(data)) + data


def attribute(name: str, value: Attribute) -> bytes:
    """Give an AttributeProto."""
    if isinstance(value, float):
        return block(1, name) + varint(2 << 3 | 5) + struct.pack("<f", value) + whole(20, 1)
    if isinstance(value, int):
        return block(1, name) + whole(3, value) + whole(20, 2)
    if isinstance(value, str):
        return block(1, name) + block(4, value) + whole(20, 3)
    return block(1, name) + b"".join(whole(8, each) for each in value) + whole(20, 7)


def value_info(name: str, shape: Sequence[int | str], kind: int = FLOAT) -> bytes:
    """Give a ValueInfoProto, of 32-bit floats usually; a side that is a word may be of any size."""
    sides = b"".join(
        block(1, whole(1, each) if isinstance(each, int) else block(2, each)) for each in shape
    )
    return block(1, name) + block(2, block(1, whole(1, kind) + block(2, sides)))


def tensor(name: str, values: NDArray[Any]) -> bytes:
    """Give a TensorProto."""
    sides = b"".join(whole(1, each) for each in values.shape)
    data = np.ascontiguousarray(values).tobytes()
    return sides + whole(2, TYPES[values.dtype]) + block(8, name) + block(9, data)


class Graph:
    """A graph, in the order in which its nodes are told."""

    def __init__(self, name: str) -> None:
        """Begin with none."""
        self._name = name
        self._nodes: list[bytes] = []
        self._constants: dict[str, bytes] = {}
        self._sides: list[bytes] = []

    def node(
        self,
        kind: str,
        inputs: Sequence[str],
        outputs: Sequence[str],
        **attributes: Attribute,
    ) -> None:
        """Add a node; all that it needs has been told before."""
        names = [block(1, each) for each in inputs] + [block(2, each) for each in outputs]
        about = [block(5, attribute(*each)) for each in _sorted(attributes)]
        self._nodes.append(
            b"".join(names) + block(3, outputs[0]) + block(4, kind) + b"".join(about)
        )

    def constant(self, name: str, values: NDArray[Any]) -> str:
        """Add an array that nodes read by its name, and give the name."""
        self._constants[name] = tensor(name, values)
        return name

    def input(self, name: str, shape: Sequence[int | str]) -> None:
        """Name what goes in."""
        self._sides.append(block(11, value_info(name, shape)))

    def output(self, name: str, shape: Sequence[int | str], kind: int = FLOAT) -> None:
        """Name what comes out, of a kind of `TYPES`."""
        self._sides.append(block(12, value_info(name, shape, kind)))

    def file(self) -> bytes:
        """Give the ModelProto."""
        graph = b"".join(
            [
                *(block(1, each) for each in self._nodes),
                block(2, self._name),
                *(block(5, each) for each in self._constants.values()),
                *self._sides,
            ]
        )
        return whole(1, IR_VERSION) + block(7, graph) + block(8, block(1, "") + whole(2, OPSET))


def _sorted(attributes: Mapping[str, Attribute]) -> list[tuple[str, Attribute]]:
    return sorted(attributes.items())
