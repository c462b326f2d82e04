"""What every message has in common: a tag, a closed list, limits, two encodings.

A message is a map with the key ``t`` for its kind. Fields a reader does not know are ignored,
fields it misses take their defaults, and kinds it does not know are skipped once a link stands,
so that version N talks with N-1. MessagePack is what
the programs speak; JSON (bytes as base64) says the same to a person with a console.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic, TypeVar, get_args

import msgspec

from talaia.wire.errors import PeerError, UnknownKind

if TYPE_CHECKING:
    from types import UnionType

__all__ = ["MAX_FRAME", "PROTOCOL", "Codec", "Message", "is_compatible"]

# A new field or a new kind does not raise it: who does not know them passes them over.
PROTOCOL = 1
# Of a codec that names no other.
MAX_FRAME = 4 * 1024 * 1024


def is_compatible(protocol: int) -> bool:
    """Tell whether a peer of this protocol is understood: ours, the one before, the one after."""
    return abs(protocol - PROTOCOL) <= 1


# Defaults are not sent, so that frames stay small.
class Message(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, tag_field="t"):
    """Base of every message."""


class _Tagged(msgspec.Struct, frozen=True):
    # All that is read of a frame of an unknown kind.
    t: str


M = TypeVar("M")


class Codec(Generic[M]):
    """Encode and decode one closed list of messages."""

    def __init__(self, union: UnionType | type, max_frame: int = MAX_FRAME) -> None:
        """Take the messages that may be met, as a union of `Message` classes."""
        self.max_frame = max_frame
        # By these an unknown tag is told from a wrong field: msgspec has one error for both.
        self._kinds = frozenset(
            member.__struct_config__.tag for member in (get_args(union) or (union,))
        )
        # Made once: a decoder works its types out as it is made.
        self._binary: msgspec.msgpack.Decoder[M] = msgspec.msgpack.Decoder(union)
        self._text: msgspec.json.Decoder[M] = msgspec.json.Decoder(union)
        self._pack = msgspec.msgpack.Encoder()
        self._json = msgspec.json.Encoder()

    def decode(self, data: bytes | str) -> M:
        """Read one frame: MessagePack from bytes, JSON from text.

        Raises:
            PeerError: too large, a field of the wrong type or over its limit, or too deep.
            UnknownKind: a whole message, but none of the list.

        """
        # Before it is decoded: what is too large costs no more than its receipt.
        if len(data) > self.max_frame:
            raise PeerError(
                f"a frame of {len(data)} bytes is over the limit of {self.max_frame}", 1009
            )
        try:
            if isinstance(data, str):
                return self._text.decode(data)
            return self._binary.decode(data)
        except msgspec.ValidationError as error:
            # Looked up only now, so that a good frame is read once.
            kind = self._message_kind(data)
            if kind is not None and kind not in self._kinds:
                raise UnknownKind(kind) from error
            raise PeerError(f"a frame that is not in the protocol: {error}") from error
        # `RecursionError`: nested deeper than the decoder goes.
        except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
            raise PeerError(f"a frame that is not in the protocol: {error}") from error

    @staticmethod
    def _message_kind(data: bytes | str) -> str | None:
        """Tell the tag of a frame that could not be decoded."""
        try:
            if isinstance(data, str):
                return msgspec.json.decode(data, type=_Tagged).t
            return msgspec.msgpack.decode(data, type=_Tagged).t
        except (msgspec.DecodeError, RecursionError, UnicodeDecodeError):
            # Not even a map with a tag: it is a message of no kind at all.
            return None

    def encode(self, message: M) -> bytes:
        """Write MessagePack."""
        return self._pack.encode(message)

    def encode_text(self, message: M) -> str:
        """Write JSON."""
        return self._json.encode(message).decode()
