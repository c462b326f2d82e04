"""XML of strangers as plain nodes: bounded, without document types, entities or instructions. Pure.

Prefixes of name spaces are the sender's own choice, so elements are told by their local names.
Whether a prefix is bound is not asked: some cameras forget it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.parsers import expat

from talaia.gateway.errors import GatewayError

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["UnreadableXml", "XmlNode", "parse_xml"]

# A camera with dozens of profiles answers with some hundred kilobytes, nested a dozen deep.
MOST_BYTES = 1024 * 1024
MOST_NODES = 20_000
MOST_DEPTH = 40
MOST_ATTRIBUTES = 64


class UnreadableXml(GatewayError):
    """It is no XML, or more of it than an answer needs."""


class XmlNode:
    """One element.

    Attributes:
        name: local, without its name space.
        attributes: by local name.
        children: elements inside, in order.
        text: all text directly inside, without the space around.

    """

    __slots__ = ("attributes", "children", "name", "text")

    def __init__(self, name: str, attributes: dict[str, str]) -> None:
        """Begin with nothing inside."""
        self.name, self.attributes = name, attributes
        self.children: list[XmlNode] = []
        self.text = ""

    def walk_nodes(self) -> Iterator[XmlNode]:
        """Give this element and all inside it, outer ones first."""
        waiting = [self]
        while waiting:
            node = waiting.pop()
            yield node
            waiting += reversed(node.children)

    def find_node(self, *path: str) -> XmlNode | None:
        """Find the first element by the names that lead to it from here."""
        node: XmlNode | None = self
        for name in path:
            assert node is not None  # noqa: S101 - `next` below has given one
            node = next((child for child in node.children if child.name == name), None)
            if node is None:
                return None
        return node

    def text_at(self, *path: str) -> str:
        """Give the text of an element; empty where there is none."""
        node = self.find_node(*path)
        return "" if node is None else node.text

    def all_named(self, name: str) -> list[XmlNode]:
        """Give the elements directly inside that are called so."""
        return [child for child in self.children if child.name == name]


def parse_xml(data: bytes) -> XmlNode:
    """Read a document; give its outermost element.

    Raises:
        UnreadableXml: it is none, declares a type or entities, or is too large.

    """
    if len(data) > MOST_BYTES:
        raise UnreadableXml(f"{len(data)} bytes of XML are too many")
    reader = _Reader()
    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = reader.begin_element
    parser.EndElementHandler = reader.end_element
    parser.CharacterDataHandler = reader.add_text
    # SOAP 1.2 (part 1, 5) has neither, and each is a way into the reader's memory or files.
    parser.StartDoctypeDeclHandler = _refuse_declaration
    parser.EntityDeclHandler = _refuse_declaration
    parser.ExternalEntityRefHandler = _refuse_declaration
    parser.ProcessingInstructionHandler = _refuse_declaration
    try:
        parser.Parse(data, True)  # noqa: FBT003 - expat takes it by place
    except (expat.ExpatError, ValueError, LookupError) as error:
        raise UnreadableXml(f"it is no XML: {error}") from error
    assert reader.root is not None  # noqa: S101 - expat refuses a document without an element
    return reader.root


def _refuse_declaration(*_: object) -> int:
    raise UnreadableXml("it declares a document type, entities or instructions")


def _local_name(name: str) -> str:
    return name.rpartition(":")[2]


class _Reader:
    """Takes what expat finds."""

    def __init__(self) -> None:
        self.root: XmlNode | None = None
        self._open: list[tuple[XmlNode, list[str]]] = []
        self._count = 0

    def begin_element(self, name: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if self._count > MOST_NODES or len(self._open) >= MOST_DEPTH:
            raise UnreadableXml("it has more elements than an answer needs")
        if len(attributes) > MOST_ATTRIBUTES:
            raise UnreadableXml("an element has more attributes than an answer needs")
        node = XmlNode(
            _local_name(name),
            {
                _local_name(key): value
                for key, value in attributes.items()
                if not key.startswith("xmlns")
            },
        )
        if self._open:
            self._open[-1][0].children.append(node)
        else:
            self.root = node
        self._open.append((node, []))

    def end_element(self, _name: str) -> None:
        node, pieces = self._open.pop()
        node.text = "".join(pieces).strip()

    def add_text(self, text: str) -> None:
        # Between elements there is only space, which is stripped with the rest.
        self._open[-1][1].append(text)
