"""JSON of the rosbridge protocol to values and back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.wire.errors import PeerError
from talaia.wire.rosbridge.cbor import encode_cbor
from talaia.wire.rosbridge.client_messages import RosbridgeMessage
from talaia.wire.rosbridge.fragments import LEAST_FRAGMENT, split_text

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["MAX_ROSBRIDGE_FRAME", "RosbridgeMistake", "decode_rosbridge", "encode_rosbridge"]

# Of a client (bytes); what is put together of fragments is held to it, too.
MAX_ROSBRIDGE_FRAME = 1024 * 1024

_DECODER: msgspec.json.Decoder[RosbridgeMessage] = msgspec.json.Decoder(RosbridgeMessage)
_KINDS = frozenset(member.__struct_config__.tag for member in RosbridgeMessage.__args__)


class RosbridgeMistake(PeerError):
    """A message that is told to its sender and passed over: this protocol goes on after it.

    Attributes:
        id: of the message, as far as it could be read.

    """

    def __init__(self, problem: str, message_id: str | int | None = None) -> None:
        """Keep the sentence and the message's ``id``."""
        super().__init__(problem)
        self.id = message_id


class _Head(msgspec.Struct, frozen=True):
    # All that is read of a message that is wrong elsewhere.
    op: str = ""
    id: str | int | None = None


def decode_rosbridge(text: str) -> RosbridgeMessage:
    """Read what a client said.

    Raises:
        PeerError: too large (code 1009).
        RosbridgeMistake: not of the protocol, or of an ``op`` that is not known here.

    """
    if len(text) > MAX_ROSBRIDGE_FRAME:
        raise PeerError(
            f"a message of {len(text)} letters is over the limit of {MAX_ROSBRIDGE_FRAME}", 1009
        )
    try:
        return _DECODER.decode(text)
    except msgspec.ValidationError as error:
        head = _head_of(text)
        if head.op not in _KINDS:
            raise RosbridgeMistake(f"unknown operation {head.op[:100]!r}", head.id) from error
        raise RosbridgeMistake(f"{head.op}: {str(error)[:500]}", head.id) from error
    except RecursionError as error:
        raise RosbridgeMistake("a message that is nested too deeply") from error
    except (msgspec.DecodeError, UnicodeError) as error:
        raise RosbridgeMistake(f"a message that is no JSON: {str(error)[:500]}") from error


def encode_rosbridge(
    message: Mapping[str, object], *, fragment_size: int = 0, fragment_id: str = "", cbor: bool
) -> list[str | bytes]:
    """Write a message of the server as the frames that carry it.

    Numbers that are none (NaN) and infinite ones are ``null`` in JSON, as rosbridge writes them.

    Args:
        message: numbers, texts, bytes, lists, numpy arrays and mappings of these; in JSON bytes
            are base64.
        fragment_size: a longer JSON text goes in fragments of so many letters; 0: whole.
        fragment_id: of its fragments, not used twice.
        cbor: as CBOR in one binary frame, instead of JSON.

    """
    if cbor:
        return [encode_cbor(message)]
    text = msgspec.json.encode(message, enc_hook=_plain_value).decode()
    if not fragment_size or len(text) <= max(fragment_size, LEAST_FRAGMENT):
        return [text]
    return list(split_text(text, fragment_size, fragment_id))


def _plain_value(value: object) -> object:
    """Make lists and numbers of numpy's."""
    if isinstance(value, np.ndarray):
        # As bytes, which are base64 in JSON.
        return value.tobytes() if value.dtype == np.uint8 else value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} has no JSON")


def _head_of(text: str) -> _Head:
    try:
        return msgspec.json.decode(text, type=_Head)
    except (msgspec.DecodeError, RecursionError, UnicodeError):
        return _Head()
