"""FITS headers as bytes: read the first one, set cards in it, write it anew. Pure.

From the FITS standard 4.0: a header is 80-character cards in blocks of 2880 bytes, ended by
``END``. Only what a gateway needs is here, so that it needs no astropy: the hub checks the file.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.errors import GatewayError

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = [
    "BLOCK",
    "HeaderCard",
    "NotFits",
    "Value",
    "cards_of",
    "length_of",
    "rewrite_header",
    "values_of",
]

BLOCK = 2880
_CARD = 80
# A camera's header has some tens of cards; a thousand blocks are an attack or another format.
MAX_BLOCKS = 200
_KEY = re.compile(r"[A-Z0-9_-]{1,8}\Z")
_TEXT = re.compile(r"'((?:[^']|'')*)'")
_LONGEST_TEXT = 66

Value = str | float | int | bool | None


class NotFits(GatewayError):
    """The bytes are not a FITS file."""


class HeaderCard(NamedTuple):
    """One keyword with its value and what it means; a value of none is written as undefined."""

    key: str
    value: Value
    comment: str = ""


def length_of(data: bytes) -> int | None:
    """Give the length of the first header, whole blocks; none while its end has not come.

    Raises:
        NotFits: it does not begin as FITS does, or has no end within `MAX_BLOCKS`.

    """
    if data[:30].ljust(30)[:9] != b"SIMPLE  =" and len(data) >= 9:
        raise NotFits("the picture is not FITS: it does not begin with SIMPLE")
    for at in range(0, len(data) - _CARD + 1, _CARD):
        if data[at : at + _CARD].rstrip() == b"END":
            return (at // BLOCK + 1) * BLOCK
    if len(data) > MAX_BLOCKS * BLOCK:
        raise NotFits("the picture is not FITS: its header has no end")
    return None


def cards_of(header: bytes) -> list[bytes]:
    """Cut a header into its cards, without ``END`` and what is behind it."""
    cards = []
    for at in range(0, len(header), _CARD):
        card = header[at : at + _CARD]
        if card.rstrip() == b"END":
            break
        cards.append(card)
    return cards


def values_of(header: bytes) -> dict[str, Value]:
    """Read the values of a header; of a keyword that comes twice the first counts."""
    found: dict[str, Value] = {}
    for card in cards_of(header):
        text = card.decode("ascii", "replace")
        if text[8:10] == "= ":
            found.setdefault(text[:8].strip(), _read_value(text[10:]))
    return found


def _read_value(text: str) -> Value:
    match = _TEXT.match(text.strip())
    if match:
        return match[1].replace("''", "'").rstrip()
    word = text.split("/", 1)[0].strip()
    if word in ("T", "F"):
        return word == "T"
    try:
        return int(word)
    except ValueError:
        pass
    try:
        value = float(word.replace("D", "E"))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def rewrite_header(header: bytes, cards: Iterable[HeaderCard]) -> bytes:
    """Give the header with these cards: in the place of their keyword, or at its end."""
    lines = cards_of(header)
    places = {line[:8].decode("ascii", "replace").strip(): at for at, line in enumerate(lines)}
    for card in cards:
        line = write_card(card)
        at = places.get(card.key)
        if at is None:
            places[card.key] = len(lines)
            lines.append(line)
        else:
            lines[at] = line
    whole = b"".join([*lines, b"END".ljust(_CARD)])
    return whole + b" " * (-len(whole) % BLOCK)


def write_card(card: HeaderCard) -> bytes:
    """Write one card.

    Raises:
        ValueError: the keyword is not one of FITS.

    """
    if not _KEY.match(card.key):
        raise ValueError(f"{card.key!r} is not a FITS keyword")
    text = f"{card.key:<8}= {_format_value(card.value):>20}"
    if isinstance(card.value, str):
        text = f"{card.key:<8}= {_format_value(card.value):<20}"
    comment = _plain_ascii(card.comment)
    if comment:
        text = f"{text} / {comment}"
    return text[:_CARD].ljust(_CARD).encode("ascii")


def _format_value(value: Value) -> str:
    match value:
        case None:
            return ""
        case bool():
            return "T" if value else "F"
        case str():
            plain = _plain_ascii(value)
            # A quote counts twice; what would not fit is cut, never split.
            while len(plain.replace("'", "''")) > _LONGEST_TEXT:
                plain = plain[:-1]
            return f"'{plain.replace(chr(39), chr(39) * 2):<8}'"
        case int():
            return str(value)
        case float():
            if not math.isfinite(value):
                return ""
            shown = f"{value:.12G}"
            return shown if "." in shown or "E" in shown else f"{shown}."


def _plain_ascii(text: str) -> str:
    """Only the characters that FITS allows: printable ASCII."""
    spelled = text.replace("°", "deg").replace("²", "2").replace("µ", "u")
    return "".join(letter if " " <= letter <= "~" else "?" for letter in spelled)
