"""The night by itself, between gateway and hub: who armed it, what is asked, what was done.

The gateway goes on without the hub: it keeps the requests that it was given, and what it did until
the hub has taken it.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.model.observing.plan import Instrument, Plan, WhyNot
from talaia.model.observing.requests import Proposal, RequestGroup
from talaia.model.observing.states import ObservationState, SuspensionCause
from talaia.wire.gateway_messages.field_types import Count, Name, Sentence, Word
from talaia.wire.gateway_messages.relayed_fields import NightFields, NightPhase
from talaia.wire.message import Message

__all__ = [
    "NightArmRequest",
    "NightDisarmRequest",
    "NightPhase",
    "NightPlan",
    "NightState",
    "ObservationAck",
    "ObservationUpdate",
    "RequestRevision",
    "RequestSync",
]

_UnixSeconds = Annotated[float, Meta(ge=0, le=2**34)]
MAX_GROUPS = 200


class NightArmRequest(Message, frozen=True, kw_only=True, tag="night_arm"):
    """Let the night run by itself. The gateway opens a roof only while armed.

    Attributes:
        id: the asker's; acted on at most once.
        who: the account.
        until: it disarms itself then (s since the epoch, UTC); 0: until somebody disarms it.

    """

    id: Name
    who: Name
    until: _UnixSeconds = 0.0


class NightDisarmRequest(Message, frozen=True, kw_only=True, tag="night_disarm"):
    """End it: the exposure is aborted, telescope and roof park and close."""

    id: Name
    who: Name
    why: Sentence = ""


class NightState(NightFields, frozen=True, kw_only=True, tag="night_state"):
    """How the night stands. On every change, and at the start of a link.

    Attributes:
        answer_to: the id of the request to arm or disarm that this answers.
        refused: why it was not done; empty: it was.

    """

    answer_to: Word = ""
    refused: Sentence = ""


class NightPlan(Message, frozen=True, kw_only=True, tag="night_plan"):
    """The plan that the executor goes by, and why the others are not in it now."""

    plan: Plan
    why_not: Annotated[list[WhyNot], Meta(max_length=10_000)] = []
    instrument: Instrument = Instrument()


class RequestSync(Message, frozen=True, kw_only=True, tag="request_sync"):
    """What is asked of the night: all of it, in pieces of at most ``MAX_GROUPS`` groups.

    Attributes:
        revision: rises with each change; pieces of another one are forgotten.
        piece: from 0.
        pieces: all of them make the set, which then takes the former one's place.
        proposals: with the first piece.
        groups: those with a request that is pending.

    """

    revision: Count
    piece: Count = 0
    pieces: Count = 1
    proposals: Annotated[list[Proposal], Meta(max_length=1000)] = []
    groups: Annotated[list[RequestGroup], Meta(max_length=MAX_GROUPS)] = []


class RequestRevision(Message, frozen=True, kw_only=True, tag="request_revision"):
    """The revision that the gateway goes by; sent at the start of a link, too. 0: none yet."""

    revision: Count


class ObservationUpdate(Message, frozen=True, kw_only=True, tag="observation"):
    """What became of an observation. Repeated until the hub has acknowledged its number.

    Attributes:
        number: rises by one with each, over restarts of the gateway.
        id: of the observation, unique at its gateway.
        request: which it was a try at.
        state: where it stands now.
        cause: of a suspension.
        why: in words.
        time: of the change (s since the epoch, UTC).
        frames_done: of each configuration of the request, read out and kept, in all tries.
        block_s: block time that it is charged, so far (s).
        files: SHA-256 of its FITS files since the last update; the archive knows them by it.

    """

    number: Count
    id: Name
    request: Name
    state: ObservationState
    cause: SuspensionCause | None = None
    why: Sentence = ""
    time: _UnixSeconds
    frames_done: Annotated[list[Count], Meta(max_length=100)] = []
    block_s: Annotated[float, Meta(ge=0)] = 0.0
    files: Annotated[list[Word], Meta(max_length=10_000)] = []


class ObservationAck(Message, frozen=True, kw_only=True, tag="observation_ack"):
    """All updates up to this number are in the hub's database."""

    number: Count
