"""Releases of a gateway's own software, which its hub offers and it fetches if it trusts them."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import PIECE, Count, Digest, Name, Sentence, Word
from talaia.wire.message import Message

__all__ = ["ReleaseOffer", "ReleasePiece", "ReleaseRequest", "ReleaseState"]

_Version = Annotated[str, Meta(max_length=40)]


class ReleaseOffer(Message, frozen=True, kw_only=True, tag="release_offer"):
    """The hub has a release that an admin wants on this gateway.

    Only to gateways that have sent a `ReleaseState`. It is fetched on the connection for files, and
    installed only if somebody whom the gateway trusts has signed it.

    Attributes:
        id: of the admin's wish: a release that is offered again has another.
        version: of the release.
        size: bytes.
        digest: SHA-256 of all of it.

    """

    id: Name
    version: Annotated[_Version, Meta(min_length=1)]
    size: Count
    digest: Digest


class ReleaseState(Message, frozen=True, kw_only=True, tag="release_state"):
    """How releases stand at a gateway. Sent on every change and at the start of a link.

    Only to hubs whose welcome takes it, by gateways that take releases from their hub.

    Attributes:
        current: the release that is known to work.
        phase: ``idle``, ``fetching``, ``installing``, ``waiting`` for rest, ``allowed`` or
            ``trying``.
        candidate: the release that is fetched, installed or tried; empty when idle.
        waits: why the candidate is not tried yet.
        fetched: bytes of it that are there.
        answered: the ``id`` of the offer that the gateway last came to an end with without a trial.
        failed: releases that were left, and why.

    """

    current: _Version
    phase: Word = "idle"
    candidate: _Version = ""
    waits: Sentence = ""
    fetched: Count = 0
    answered: Word = ""
    failed: Annotated[dict[_Version, Sentence], Meta(max_length=100)] = {}


class ReleaseRequest(Message, frozen=True, kw_only=True, tag="release_request"):
    """The gateway asks for the bytes of an offered release from ``at`` on."""

    version: _Version
    at: Count


class ReleasePiece(Message, frozen=True, kw_only=True, tag="release_piece"):
    """Those bytes, with their CRC-32.

    Attributes:
        refused: why there are none.

    """

    version: _Version
    at: Count
    check: Annotated[int, Meta(ge=0, lt=2**32)] = 0
    data: Annotated[bytes, Meta(max_length=PIECE)] = b""
    refused: Sentence = ""
