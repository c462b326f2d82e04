"""Interlocks, enclosures and overrides between gateway and hub."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import Millis, Name, Sentence, Word
from talaia.wire.message import Message

__all__ = ["EnclosureState", "InterlockState", "OverrideRequest"]


class EnclosureState(Message, frozen=True, kw_only=True, tag="enclosure"):
    """An enclosure that people are to look at. Only to hubs that take it.

    Sent on every change, and of all at the start of a link.

    Attributes:
        why: it should be closed and cannot be shown to be, or its sensors disagree; empty when
            neither is so.

    """

    enclosure: Name
    why: Sentence = ""


class InterlockState(Message, frozen=True, kw_only=True, tag="interlock"):
    """How an interlock stands. Sent on every change, and of all at the start of a link.

    Attributes:
        locked: it refuses what it guards, unless overridden.
        unsafe: its conditions hold now; not so while it only waits for its dwell time.
        for_ms: locked for so long.
        clears_ms: it is released after so long, if nothing unsafe comes between.
        override_ms: overridden for so long yet, by whom and why.
        condition: the condition that is overridden, or else the one that locks.
        no_override: why that may not be overridden now, if so.
        unknown: the conditions of which nothing is known now, however fresh their values are:
            out of range, frozen, with an old stamp. Each as ``<device>/<signal>``; what compares
            several signals names them all, with ``+`` between.

    """

    interlock: Name
    locked: bool
    unsafe: bool = False
    why: Sentence = ""
    for_ms: Millis = 0
    clears_ms: Millis = 0
    overridden_by: Sentence = ""
    reason: Sentence = ""
    override_ms: Millis = 0
    condition: Word = ""
    no_override: Sentence = ""
    unknown: Annotated[list[Sentence], Meta(max_length=1000)] = []


class OverrideRequest(Message, frozen=True, kw_only=True, tag="override"):
    """Override a condition of an interlock for so many seconds; 0 ends that.

    The hub has seen to the right.

    Attributes:
        condition: which, as `InterlockState` names it; empty for the one that locks.

    """

    interlock: Name
    who: Name
    reason: Sentence = ""
    seconds: Annotated[float, Meta(ge=0, le=86_400)]
    condition: Word = ""
