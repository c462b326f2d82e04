"""Readers of what gateways, pages and sources of alerts say."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.wire import browser, frames
from talaia.wire.alerts.read_notice import parse_notice
from talaia.wire.certificate_der import public_key_of
from talaia.wire.columns import unpack_columns
from talaia.wire.enrolment import read_code
from talaia.wire.errors import CodeMistyped, PeerError
from talaia.wire.newest import newest_of
from talaia.wire.sealing import decompress_text

from .target import FuzzTarget

if TYPE_CHECKING:
    from talaia.wire.message import Codec

_LINK = (frames.LINK_FROM_GATEWAY, frames.LINK_FROM_HUB)
_MEDIA = (frames.MEDIA_FROM_GATEWAY, frames.MEDIA_FROM_HUB)
_FILES = (frames.FILES_FROM_GATEWAY, frames.FILES_FROM_HUB)
_PAGES = (
    browser.FROM_BROWSER,
    browser.TO_BROWSER,
    browser.MEDIA_FROM_BROWSER,
    browser.MEDIA_TO_BROWSER,
    browser.TOPIC_FROM_BROWSER,
    browser.TOPIC_TO_BROWSER,
)


def _read_frame(codecs: tuple[Codec, ...], data: bytes) -> None:
    """Read a frame: the first byte says by which codec, and whether as bytes or text."""
    if not data:
        return
    codec, frame = codecs[data[0] // 2 % len(codecs)], data[1:]
    message = codec.decode(frame.decode("utf-8", "replace") if data[0] % 2 else frame)
    if isinstance(message, frames.SampleBatch):
        unpack_columns(message)
    elif isinstance(message, frames.NewestBatch):
        newest_of(message)
    # What was understood can be passed on.
    assert codec.decode(codec.encode(message)) is not None


def _read_letters(data: bytes) -> None:
    read_code(data.decode("utf-8", "replace"))


TARGETS = (
    FuzzTarget("link", partial(_read_frame, _LINK), (PeerError,)),
    FuzzTarget("media", partial(_read_frame, _MEDIA), (PeerError,)),
    FuzzTarget("files", partial(_read_frame, _FILES), (PeerError,)),
    FuzzTarget("pages", partial(_read_frame, _PAGES), (PeerError,)),
    FuzzTarget("packed_description", decompress_text, (PeerError,)),
    FuzzTarget("enrolment_code", _read_letters, (CodeMistyped,)),
    FuzzTarget("certificate", public_key_of, (ValueError,)),
    FuzzTarget("alert_notice", parse_notice, (PeerError,), longest=1024 * 1024),
)
