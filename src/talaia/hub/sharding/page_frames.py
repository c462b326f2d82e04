"""What of a page's messages says where they go. Pure.

Nothing is decoded that need not be: of what a page says three fields, and of what it is told the
beginning, which for nearly all messages is enough.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import msgspec

from talaia.wire.browser import FROM_BROWSER

if TYPE_CHECKING:
    from starlette.types import Message

__all__ = ["AskedAbout", "ToldAbout", "data_of", "is_pong", "read_asked", "read_told"]


class AskedAbout(msgspec.Struct, frozen=True):
    """What a page's message is about.

    Attributes:
        t: its kind.
        site: empty: no site.
        sub: of a subscription; -1: of none.

    """

    t: str
    site: str = ""
    sub: Annotated[int, msgspec.Meta(ge=0, le=65_535)] = -1


class ToldAbout(msgspec.Struct, frozen=True):
    """What a page is told about; see `AskedAbout`.

    Attributes:
        catalogue: names the site's description.

    """

    t: str
    site: str = ""
    sub: int = -1
    catalogue: str = ""


_ASKED = msgspec.msgpack.Decoder(AskedAbout)
_ASKED_TEXT = msgspec.json.Decoder(AskedAbout)
_TOLD = msgspec.msgpack.Decoder(ToldAbout)
_TOLD_TEXT = msgspec.json.Decoder(ToldAbout)
# Hubs write a message's kind first. Of those of which a page hears once though each shard says
# them, or that tell of a site, bytes 1 to 4: the key ``t``, the length and the first letter. (A map
# of more than fifteen entries begins otherwise, and none of these has so many.) Of a text letters 6
# to 8, after ``{"t":"``.
_KINDS = ("greeting", "pong", "session", "ended", "site")
_NUMBERED_KINDS = ("values", "subscribed")


def _beginnings(kinds: tuple[str, ...]) -> frozenset[bytes | str]:
    binary = {b"\xa1t" + bytes([0xA0 | len(kind)]) + kind[:1].encode() for kind in kinds}
    return frozenset({*binary, *(kind[:3] for kind in kinds)})


_SEEN = _beginnings(_KINDS)
_SEEN_NUMBERED = _beginnings(_KINDS + _NUMBERED_KINDS)


def data_of(message: Message) -> bytes | str:
    """Give what an ASGI message of a socket carries."""
    data: bytes | None = message.get("bytes")
    return str(message.get("text", "")) if data is None else data


def is_pong(data: bytes | str) -> bool:
    """Tell whether what a hub has written is the answer to a ping."""
    return (data[6:10] == "pong") if isinstance(data, str) else (data[1:8] == b"\xa1t\xa4pong")


def read_asked(data: bytes | str) -> AskedAbout | None:
    """Tell what a page's message is about; None: it cannot be read, or is too long."""
    if len(data) > FROM_BROWSER.max_frame:
        return None
    try:
        if isinstance(data, str):
            return _ASKED_TEXT.decode(data)
        return _ASKED.decode(data)
    except (msgspec.DecodeError, RecursionError, UnicodeError):
        return None


def read_told(data: bytes | str, *, numbered: bool) -> ToldAbout | None:
    """Tell what a page is told about, if it is not simply to be handed on; else None.

    Args:
        data: the message, as a hub writes it.
        numbered: messages of subscriptions are asked for, too.

    """
    begins = data[6:9] if isinstance(data, str) else data[1:5]
    if begins not in (_SEEN_NUMBERED if numbered else _SEEN):
        return None
    try:
        if isinstance(data, str):
            return _TOLD_TEXT.decode(data)
        return _TOLD.decode(data)
    except (msgspec.DecodeError, UnicodeError):
        # No hub writes such a thing; the page sees for itself.
        return None
