"""The site description between gateway and hub: what it is now, and changes of it."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from talaia.wire.columns import MAX_SAMPLES
from talaia.wire.gateway_messages.field_types import (
    AskedText,
    Deflated,
    Digest,
    Name,
    Sentence,
    Word,
)
from talaia.wire.message import Message

__all__ = ["ChangePhase", "ChangeRequest", "ChangeState", "DescriptionProblem", "DescriptionUpdate"]


class ChangePhase(StrEnum):
    """Where a change of the description stands. The last two are final."""

    WAITING = "waiting"
    APPLIED = "applied"
    REFUSED = "refused"


class DescriptionUpdate(Message, frozen=True, kw_only=True, tag="described"):
    """The gateway goes by another description from here on; the link and the boot stay.

    Attributes:
        description: as in `Hello`, deflated.
        catalogue: as in `Hello`; batches with the one before may still come behind this.
        addresses: of the channels that the new catalogue names, in order.
        renamed: channels that have another address now, by the former one.
        source: as in `Hello`.
        id: of the `ChangeRequest` that brought it; empty when the file was changed at the gateway.
        who: asked for it.

    """

    description: Deflated
    catalogue: Name
    addresses: Annotated[list[Name], Meta(max_length=MAX_SAMPLES)] = []
    renamed: Annotated[dict[Name, Name], Meta(max_length=MAX_SAMPLES)] = {}
    source: Deflated = b""
    id: Word = ""
    who: Sentence = ""


class DescriptionProblem(Message, frozen=True, kw_only=True, tag="problem"):
    """What does not fit in a description: where, what, and what to do.

    Attributes:
        line, column: of the file's text, from 1; 0 where that is not known.

    """

    where: Sentence
    problem: Sentence
    remedy: Sentence = ""
    line: Annotated[int, Meta(ge=0)] = 0
    column: Annotated[int, Meta(ge=0)] = 0


class ChangeState(Message, frozen=True, kw_only=True, tag="change_state"):
    """Where a change that was asked for stands; or, without an id, one of the file's own.

    Attributes:
        message: what it waits for, or why it was refused.
        problems: what does not fit in it; not all, if there are many.

    """

    id: Word = ""
    phase: ChangePhase
    message: Sentence = ""
    problems: Annotated[list[DescriptionProblem], Meta(max_length=100)] = []


class ChangeRequest(Message, frozen=True, kw_only=True, tag="change"):
    """Go by another description. The hub has seen to the right; the gateway judges for itself.

    Attributes:
        source: the text, deflated (zlib).
        base: SHA-256 of the text that it was made from, as the hub knows it.
        seal: HMAC-SHA256 under the SHA-256 of the gateway's key, see `wire.sealing`.

    """

    id: Name
    source: AskedText
    # If the file has another one by now, somebody changed it meanwhile: the change is refused.
    base: Digest
    who: Name
    seal: Digest
