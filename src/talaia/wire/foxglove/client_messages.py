"""What a Foxglove client says: JSON with ``op``, and two binary messages."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Raw, Struct

__all__ = [
    "FoxgloveAdvertise",
    "FoxgloveCall",
    "FoxgloveClientChannel",
    "FoxgloveFetchAsset",
    "FoxgloveGetParameters",
    "FoxgloveMessage",
    "FoxgloveParameterWish",
    "FoxglovePlayback",
    "FoxglovePublish",
    "FoxgloveSetParameters",
    "FoxgloveSubscribe",
    "FoxgloveSubscribeGraph",
    "FoxgloveSubscribeParameters",
    "FoxgloveSubscription",
    "FoxgloveUnadvertise",
    "FoxgloveUnsubscribe",
    "FoxgloveUnsubscribeGraph",
    "FoxgloveUnsubscribeParameters",
]

_Id = Annotated[int, Meta(ge=0, le=2**32 - 1)]
# Ids of our channels are small, but the protocol gives them 64 bits.
_ChannelId = Annotated[int, Meta(ge=0, le=2**63 - 1)]
_Word = Annotated[str, Meta(max_length=500)]
_Words = Annotated[list[_Word], Meta(max_length=10_000)]
_Ids = Annotated[list[_Id], Meta(max_length=10_000)]


class _ClientSaid(Struct, frozen=True, kw_only=True, tag_field="op", rename="camel"):
    """Base of what is said as JSON."""


class FoxgloveSubscription(Struct, frozen=True, kw_only=True, rename="camel"):
    """One subscription: the client's number for it, and ours of the channel."""

    id: _Id
    channel_id: _ChannelId


class FoxgloveSubscribe(_ClientSaid, frozen=True, kw_only=True, tag="subscribe"):
    """Send messages of these channels."""

    subscriptions: Annotated[list[FoxgloveSubscription], Meta(max_length=10_000)]


class FoxgloveUnsubscribe(_ClientSaid, frozen=True, kw_only=True, tag="unsubscribe"):
    """Send no more, by the client's numbers."""

    # One that is not there is no fault.
    subscription_ids: _Ids


class FoxgloveClientChannel(Struct, frozen=True, kw_only=True, rename="camel"):
    """A channel that the client is going to publish on."""

    id: _Id
    # Any name: whether anything listens to it is seen later.
    topic: _Word
    encoding: _Word
    schema_name: _Word = ""


class FoxgloveAdvertise(_ClientSaid, frozen=True, kw_only=True, tag="advertise"):
    """The client is going to publish on these."""

    channels: Annotated[list[FoxgloveClientChannel], Meta(max_length=1000)]


class FoxgloveUnadvertise(_ClientSaid, frozen=True, kw_only=True, tag="unadvertise"):
    """It publishes on these no more."""

    channel_ids: _Ids


class FoxgloveGetParameters(_ClientSaid, frozen=True, kw_only=True, tag="getParameters"):
    """Give parameters; all of them when no name is given."""

    # Empty: all.
    parameter_names: _Words = []
    # Handed back with the answer.
    id: _Word | None = None


class FoxgloveParameterWish(Struct, frozen=True, kw_only=True):
    """What a parameter is to be; without a value it is to be none."""

    name: _Word
    # Of any type: whether it fits is seen by who sets it.
    value: Raw = Raw(b"null")


class FoxgloveSetParameters(_ClientSaid, frozen=True, kw_only=True, tag="setParameters"):
    """Set parameters."""

    parameters: Annotated[list[FoxgloveParameterWish], Meta(max_length=10_000)] = []
    id: _Word | None = None


class FoxgloveSubscribeParameters(
    _ClientSaid, frozen=True, kw_only=True, tag="subscribeParameterUpdates"
):
    """Tell when these parameters change."""

    parameter_names: _Words = []


class FoxgloveUnsubscribeParameters(
    _ClientSaid, frozen=True, kw_only=True, tag="unsubscribeParameterUpdates"
):
    """Tell it no more."""

    parameter_names: _Words = []


class FoxgloveSubscribeGraph(
    _ClientSaid, frozen=True, kw_only=True, tag="subscribeConnectionGraph"
):
    """Tell who publishes, subscribes and provides what."""


class FoxgloveUnsubscribeGraph(
    _ClientSaid, frozen=True, kw_only=True, tag="unsubscribeConnectionGraph"
):
    """Tell it no more."""


class FoxgloveFetchAsset(_ClientSaid, frozen=True, kw_only=True, tag="fetchAsset"):
    """Send a file, such as a robot's mesh."""

    # Such as ``package://robot/mesh.stl``.
    uri: Annotated[str, Meta(max_length=2000)]
    request_id: _Id


class FoxglovePublish(Struct, frozen=True, kw_only=True):
    """A message on one of the client's own channels (binary)."""

    channel_id: int
    data: bytes


class FoxgloveCall(Struct, frozen=True, kw_only=True):
    """A call of a service (binary)."""

    service_id: int
    call_id: int
    encoding: str
    data: bytes


class FoxglovePlayback(Struct, frozen=True, kw_only=True):
    """How past data are to be played (binary, ``foxglove.sdk.v1`` alone).

    Attributes:
        play: go on; else stand still.
        speed: as a factor of real time; whatever number the client wrote.
        seek_ns: go to this time (ns, UTC) first; None: stay.
        request_id: comes back in the state that answers.

    """

    play: bool
    speed: float
    seek_ns: int | None
    request_id: str


FoxgloveText = (
    FoxgloveSubscribe
    | FoxgloveUnsubscribe
    | FoxgloveAdvertise
    | FoxgloveUnadvertise
    | FoxgloveGetParameters
    | FoxgloveSetParameters
    | FoxgloveSubscribeParameters
    | FoxgloveUnsubscribeParameters
    | FoxgloveSubscribeGraph
    | FoxgloveUnsubscribeGraph
    | FoxgloveFetchAsset
)
FoxgloveMessage = FoxgloveText | FoxglovePublish | FoxgloveCall | FoxglovePlayback
