"""INDI's wire: bytes of a server to events, and words to bytes. Pure, and bounded everywhere.

From the INDI white paper (protocol 1.7) and what indiserver 1.9.9 sends. A connection is an endless
row of XML elements without a root, so the parser is given one. Expat is used as it is, not through
a tree: a picture then passes in pieces and is never in memory whole. Entities and document types
have no place in INDI and are refused before they can expand.

Long, because what is read and what is written are two sides of one table of elements.
"""

from __future__ import annotations

import binascii
import codecs
import re
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

from talaia.gateway.adapters.indi.errors import IndiError
from talaia.gateway.adapters.indi.numbers import parse_number, write_number

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "BlobEnd",
    "BlobHead",
    "BlobPart",
    "Deleted",
    "DriverMessage",
    "Element",
    "Event",
    "IndiParser",
    "PropertyPermission",
    "PropertyState",
    "SwitchRule",
    "Value",
    "Vector",
    "VectorKind",
    "ask_blobs",
    "ask_properties",
    "new_vector",
]

Value = float | bool | str

# What one server may say. A real observatory with fifty drivers stays far below each.
MAX_NAME = 200
MAX_TEXT = 16_384
MAX_ELEMENTS = 4_000
MAX_PENDING = 1024 * 1024
MAX_BLOB = 1024 * 1024 * 1024


class VectorKind(StrEnum):
    """What a vector holds."""

    NUMBER = "Number"
    SWITCH = "Switch"
    TEXT = "Text"
    LIGHT = "Light"
    BLOB = "BLOB"


class PropertyState(StrEnum):
    """What a driver says of a vector (and of each light). Not a verdict on a command."""

    IDLE = "Idle"
    OK = "Ok"
    BUSY = "Busy"
    ALERT = "Alert"


class PropertyPermission(StrEnum):
    """What a client may do with a vector."""

    READ = "ro"
    WRITE = "wo"
    BOTH = "rw"


class SwitchRule(StrEnum):
    """How many switches of a vector may be on."""

    ONE = "OneOfMany"
    AT_MOST_ONE = "AtMostOne"
    ANY = "AnyOfMany"


class Element(NamedTuple):
    """One member of a vector.

    Attributes:
        value: a number (NaN where the driver's text is none), a switch as a truth, a text, or a
            light's state as its word; for a BLOB the empty text.
        minimum: of a number; equal to ``maximum`` where there is no limit (the protocol's way).
        format: of a number, see `numbers.format_number`.

    """

    name: str
    value: Value
    label: str = ""
    format: str = ""
    minimum: float = 0.0
    maximum: float = 0.0
    step: float = 0.0


class Vector(NamedTuple):
    """One ``def…Vector`` or ``set…Vector`` element.

    Attributes:
        new: it defines the vector; else it sets values of one that was defined.
        state: none where a set leaves it as it was.
        timeout: the driver's own guess how long a change takes (s); 0 is unknown.
        timestamp: when its driver says that it was so (ISO 8601, UTC), if it says.

    """

    new: bool
    kind: VectorKind
    device: str
    name: str
    elements: tuple[Element, ...]
    state: PropertyState | None = None
    label: str = ""
    group: str = ""
    perm: PropertyPermission = PropertyPermission.READ
    rule: SwitchRule = SwitchRule.ANY
    timeout: float = 0.0
    message: str = ""
    timestamp: str = ""


class Deleted(NamedTuple):
    """A property that is gone; with an empty name the whole device, with both empty all."""

    device: str
    name: str = ""
    message: str = ""


class DriverMessage(NamedTuple):
    """A sentence of a driver for people."""

    device: str
    message: str


class BlobHead(NamedTuple):
    """A picture begins.

    Attributes:
        format: ``.fits``, with ``.z`` behind where it is zlib-compressed.
        size: bytes after decoding and decompression, as the driver says.

    """

    device: str
    name: str
    element: str
    format: str
    size: int


class BlobPart(NamedTuple):
    """Decoded bytes of the picture that has begun."""

    data: bytes


class BlobEnd(NamedTuple):
    """The picture is over; ``problem`` says why it is of no use, if so."""

    problem: str = ""


Event = Vector | Deleted | DriverMessage | BlobHead | BlobPart | BlobEnd

# Control characters that XML does not allow but drivers of serial devices let through.
_UNSEEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
_VECTOR = re.compile(r"(def|set)(Number|Switch|Text|Light|BLOB)Vector\Z")
_MEMBER = re.compile(r"(?:def|one)(Number|Switch|Text|Light|BLOB)\Z")
_WHITE = re.compile(r"\s+")


class IndiParser:
    """Bytes in, events out. After an error it is of no more use."""

    def __init__(self, max_blob: int = MAX_BLOB) -> None:
        """Start before the first byte; pictures over ``max_blob`` bytes are passed over."""
        self._max_blob = max_blob
        # A character may be cut in two by the socket; drivers that write Latin-1 are read all the
        # same, with a mark for each byte that is no UTF-8.
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")
        # What the bytes of this call have completed.
        self._events: list[Event] = []
        # How deep expat stands: 1 is the root that we gave, 2 a vector, 3 a member of it.
        self._depth = 0
        self._pending = 0
        self._top: tuple[str, dict[str, str]] | None = None
        self._members: list[Element] = []
        self._member: tuple[str, dict[str, str]] | None = None
        self._text: list[str] = []
        # Of the text of the member so far: it comes in pieces, so their sum is what is bounded.
        self._length = 0
        # The picture that is coming in; its bytes go on as parts and are not kept.
        self._blob: _Base64 | None = None
        self._parser = _make_parser(self)
        self._parser.Parse("<indi>")

    def parse_data(self, data: bytes) -> list[Event]:
        """Take the next bytes, cut anywhere, and give what they complete.

        Raises:
            IndiError: not INDI, or beyond the limits above.

        """
        text = _UNSEEN.sub("\ufffd", self._decoder.decode(data))
        self._pending += len(text)
        try:
            self._parser.Parse(text)
        except expat.ExpatError as error:
            raise IndiError(f"the INDI server sends what is not INDI: {error}") from error
        if self._pending > MAX_PENDING:
            raise IndiError(f"the INDI server sends a word of more than {MAX_PENDING} bytes")
        events, self._events = self._events, []
        return events

    # ── called by expat ──

    def start_element(self, name: str, attributes: dict[str, str]) -> None:
        """Note the beginning of an element."""
        self._pending = 0
        self._depth += 1
        if self._depth == 2:
            self._top, self._members = (name, attributes), []
        elif self._depth == 3 and self._top is not None:
            if len(self._members) >= MAX_ELEMENTS:
                raise IndiError(f"the INDI server sends a vector of more than {MAX_ELEMENTS}")
            self._member, self._text, self._length = (name, attributes), [], 0
            if name == "oneBLOB" and self._top[0] == "setBLOBVector":
                self._begin_blob(attributes)
        elif self._depth > 3:
            raise IndiError(f"the INDI server nests {name[:40]!r} deeper than INDI does")

    def add_characters(self, text: str) -> None:
        """Take text inside a member; elsewhere it is white space."""
        self._pending = 0
        if self._depth != 3:
            return
        if self._blob is not None:
            part = self._blob.decode_chunk(text)
            if part:
                self._events.append(BlobPart(part))
            return
        self._length += len(text)
        if self._length > MAX_TEXT:
            raise IndiError(f"the INDI server sends a text of more than {MAX_TEXT} characters")
        self._text.append(text)

    def end_element(self, name: str) -> None:
        """Close an element; a top one becomes an event."""
        self._pending = 0
        self._depth -= 1
        if self._depth == 2:
            if self._blob is not None:
                self._events.append(BlobEnd(self._blob.finish_decoding()))
                self._blob = None
            if self._member is not None:
                element = _make_element(*self._member, "".join(self._text))
                if element is not None:
                    self._members.append(element)
            self._member = None
        elif self._depth == 1 and self._top is not None:
            event = _make_event(*self._top, tuple(self._members))
            if event is not None:
                self._events.append(event)
            self._top = None
        # The root is ours and is never closed by us, so this is a stray end tag of the server.
        elif self._depth == 0:
            raise IndiError(f"the INDI server closes {name[:40]!r}, which it did not open")

    def _begin_blob(self, attributes: dict[str, str]) -> None:
        assert self._top is not None  # noqa: S101 - asked by the caller
        size = parse_number(attributes.get("size", ""))
        head = BlobHead(
            _read_name(self._top[1], "device"),
            _read_name(self._top[1], "name"),
            _read_name(attributes, "name"),
            attributes.get("format", "").strip()[:40],
            # NaN, where the attribute is missing or no number, fails both comparisons.
            int(size) if 0 <= size < 2**53 else 0,
        )
        self._blob = _Base64(self._max_blob)
        self._events.append(head)


def _make_parser(reader: IndiParser) -> expat.XMLParserType:
    parser = expat.ParserCreate()
    # Expat may wait for more before it looks again at a token that was cut; a command's answer
    # must not wait, and our own bound keeps the cost down.
    defer = getattr(parser, "SetReparseDeferralEnabled", None)
    if defer is not None:
        defer(0)
    parser.StartElementHandler = reader.start_element
    parser.EndElementHandler = reader.end_element
    parser.CharacterDataHandler = reader.add_characters
    parser.StartDoctypeDeclHandler = _refuse_doctype
    parser.EntityDeclHandler = _refuse_doctype
    return parser


def _refuse_doctype(*_: object) -> None:
    raise IndiError("the INDI server declares a document type or an entity; INDI has none")


class _Base64:
    """Decodes base64 that comes in pieces, with white space anywhere."""

    def __init__(self, most: int) -> None:
        self._rest = ""
        self._room = most
        self._problem = ""

    def decode_chunk(self, text: str) -> bytes:
        if self._problem:
            return b""
        text = self._rest + _WHITE.sub("", text)
        # Four characters are three bytes: what is left over waits for the next piece.
        whole = len(text) - len(text) % 4
        self._rest = text[whole:]
        try:
            data = binascii.a2b_base64(text[:whole], strict_mode=False)
        except (binascii.Error, ValueError) as error:
            self._problem = f"its base64 is damaged: {error}"
            return b""
        self._room -= len(data)
        # The rest of it is still read to its end, so that what follows is understood.
        if self._room < 0:
            self._problem = "it is larger than this gateway takes"
            return b""
        return data

    def finish_decoding(self) -> str:
        if self._rest and not self._problem:
            return "its base64 is cut short"
        return self._problem


def _read_name(attributes: dict[str, str], key: str) -> str:
    return attributes.get(key, "")[:MAX_NAME]


def _make_element(tag: str, attributes: dict[str, str], text: str) -> Element | None:
    match = _MEMBER.match(tag)
    name = _read_name(attributes, "name")
    if match is None or not name:
        return None
    text = text.strip()
    value: Value = text
    limits = (0.0, 0.0, 0.0)
    match VectorKind(match[1]):
        case VectorKind.NUMBER:
            value = parse_number(text)
            limits = (
                parse_number(attributes.get("min", "0")),
                parse_number(attributes.get("max", "0")),
                parse_number(attributes.get("step", "0")),
            )
        case VectorKind.SWITCH:
            value = text == "On"
        case VectorKind.LIGHT:
            value = text if text in _STATES else ""
        case VectorKind.TEXT | VectorKind.BLOB:
            pass
    label = attributes.get("label", "").strip()[:MAX_NAME]
    return Element(name, value, label, attributes.get("format", "")[:MAX_NAME], *limits)


_STATES = frozenset(state.value for state in PropertyState)
_PERMS = frozenset(permission.value for permission in PropertyPermission)
_RULES = frozenset(rule.value for rule in SwitchRule)


def _make_event(tag: str, attributes: dict[str, str], members: tuple[Element, ...]) -> Event | None:
    """Give the event of a top element, or none for one that is not known (or not for clients)."""
    message = attributes.get("message", "").strip()[:MAX_TEXT]
    device = _read_name(attributes, "device")
    if tag == "message":
        return DriverMessage(device, message) if message else None
    if tag == "delProperty":
        return Deleted(device, _read_name(attributes, "name"), message)
    match = _VECTOR.match(tag)
    name = _read_name(attributes, "name")
    if match is None or not device or not name:
        return None
    # Words that the protocol does not have count as not said: a driver with one odd word is still
    # of use, and what nobody allowed stays read-only.
    state, perm, rule = (attributes.get(key, "") for key in ("state", "perm", "rule"))
    timeout = parse_number(attributes.get("timeout", "0"))
    return Vector(
        match[1] == "def",
        VectorKind(match[2]),
        device,
        name,
        members,
        PropertyState(state) if state in _STATES else None,
        attributes.get("label", "").strip()[:MAX_NAME],
        attributes.get("group", "").strip()[:MAX_NAME],
        PropertyPermission(perm) if perm in _PERMS else PropertyPermission.READ,
        SwitchRule(rule) if rule in _RULES else SwitchRule.ANY,
        timeout if timeout > 0 else 0.0,
        message,
        attributes.get("timestamp", "")[:40],
    )


# ── what a client says ──


def ask_properties(device: str = "", name: str = "") -> bytes:
    """Ask for all properties, or those of a device, or one."""
    given = "".join(
        f" {key}={_quote_word(value)}"
        for key, value in (("device", device), ("name", name))
        if value
    )
    return f'<getProperties version="1.7"{given}/>\n'.encode()


def ask_blobs(device: str, *, wanted: bool = True) -> bytes:
    """Ask for the pictures of a device beside everything else, or for none."""
    word = "Also" if wanted else "Never"
    return f"<enableBLOB device={_quote_word(device)}>{word}</enableBLOB>\n".encode()


def new_vector(kind: VectorKind, device: str, name: str, values: Mapping[str, Value]) -> bytes:
    """Ask a device for new values.

    Raises:
        ValueError: a number that is not finite, or a kind that cannot be sent.

    """
    if kind not in (VectorKind.NUMBER, VectorKind.SWITCH, VectorKind.TEXT):
        raise ValueError(f"a {kind} cannot be sent")
    members = "".join(
        f"<one{kind} name={_quote_word(element)}>{escape(_value_text(kind, value))}</one{kind}>"
        for element, value in values.items()
    )
    head = f"<new{kind}Vector device={_quote_word(device)} name={_quote_word(name)}>"
    return f"{head}{members}</new{kind}Vector>\n".encode("utf-8", "replace")


def _value_text(kind: VectorKind, value: Value) -> str:
    if kind is VectorKind.SWITCH:
        return "On" if value else "Off"
    if kind is VectorKind.NUMBER:
        return write_number(float(value))
    return _UNSEEN.sub("\ufffd", str(value))


def _quote_word(word: str) -> str:
    return quoteattr(_UNSEEN.sub("\ufffd", word))
