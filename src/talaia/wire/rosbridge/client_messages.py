"""What a rosbridge client says: JSON with ``op``. Fields that nothing here needs are passed over.

Clients write ``null`` as well as nothing where they have no value.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Raw, Struct

__all__ = [
    "RosbridgeAdvertise",
    "RosbridgeCall",
    "RosbridgeCancel",
    "RosbridgeFragment",
    "RosbridgeGoal",
    "RosbridgeLevel",
    "RosbridgeMessage",
    "RosbridgePublish",
    "RosbridgeServe",
    "RosbridgeServeAction",
    "RosbridgeSubscribe",
    "RosbridgeUnadvertise",
    "RosbridgeUnsubscribe",
]

_RosName = Annotated[str, Meta(min_length=1, max_length=500)]
_Word = Annotated[str, Meta(max_length=500)]
_Number = int | float
_Id = Annotated[str, Meta(max_length=500)] | int
# Of a message's text; `codec` holds the whole message to less.
_Text = Annotated[str, Meta(max_length=2**24)]


class _RosbridgeSaid(Struct, frozen=True, kw_only=True, tag_field="op"):
    """Base of what is said; ``id`` comes back in what answers it."""

    id: _Id | None = None


class RosbridgeSubscribe(_RosbridgeSaid, frozen=True, kw_only=True, tag="subscribe"):
    """Send messages of a topic.

    Attributes:
        throttle_rate: at least so long between two messages (ms).
        queue_length: so many may wait for that.
        fragment_size: longer messages come in fragments of so many letters; None: whole.
        compression: ``none``, ``cbor`` or ``cbor-raw``.

    """

    topic: _RosName
    type: _Word | None = None
    throttle_rate: _Number | None = None
    queue_length: _Number | None = None
    fragment_size: _Number | None = None
    compression: _Word | None = None


class RosbridgeUnsubscribe(_RosbridgeSaid, frozen=True, kw_only=True, tag="unsubscribe"):
    """Send no more by this ``id``; without one, nothing more of the topic."""

    topic: _RosName


class RosbridgeAdvertise(_RosbridgeSaid, frozen=True, kw_only=True, tag="advertise"):
    """The client is going to publish."""

    topic: _RosName
    type: _Word


class RosbridgeUnadvertise(_RosbridgeSaid, frozen=True, kw_only=True, tag="unadvertise"):
    """It publishes no more."""

    topic: _RosName


class RosbridgePublish(_RosbridgeSaid, frozen=True, kw_only=True, tag="publish"):
    """A message of a topic."""

    topic: _RosName
    msg: Raw = Raw(b"{}")


class RosbridgeCall(_RosbridgeSaid, frozen=True, kw_only=True, tag="call_service"):
    """Call a service; ``args`` is an object, or a list in the order of the request's fields.

    Attributes:
        timeout: how long its answer may take (s); None: as long as it does.

    """

    service: _RosName
    args: Raw = Raw(b"{}")
    fragment_size: _Number | None = None
    compression: _Word | None = None
    timeout: _Number | None = None


class RosbridgeGoal(_RosbridgeSaid, frozen=True, kw_only=True, tag="send_action_goal"):
    """Send a goal to an action; ``feedback`` tells that its progress is wanted."""

    action: _RosName
    args: Raw = Raw(b"{}")
    feedback: bool | None = None
    fragment_size: _Number | None = None


class RosbridgeCancel(_RosbridgeSaid, frozen=True, kw_only=True, tag="cancel_action_goal"):
    """End the goal that was sent with this ``id``."""

    action: _RosName


class RosbridgeServe(_RosbridgeSaid, frozen=True, kw_only=True, tag="advertise_service"):
    """The client offers a service of its own."""

    service: _RosName


class RosbridgeServeAction(_RosbridgeSaid, frozen=True, kw_only=True, tag="advertise_action"):
    """The client offers an action of its own."""

    action: _RosName


class RosbridgeLevel(_RosbridgeSaid, frozen=True, kw_only=True, tag="set_level"):
    """From which level on the client wants status messages."""

    level: _Word


class RosbridgeFragment(_RosbridgeSaid, frozen=True, kw_only=True, tag="fragment"):
    """A part of a message; ``id`` is the same in all of its parts."""

    data: _Text
    num: Annotated[int, Meta(ge=0, le=2**31)]
    total: Annotated[int, Meta(ge=1, le=2**31)]


RosbridgeMessage = (
    RosbridgeSubscribe
    | RosbridgeUnsubscribe
    | RosbridgeAdvertise
    | RosbridgeUnadvertise
    | RosbridgePublish
    | RosbridgeCall
    | RosbridgeGoal
    | RosbridgeCancel
    | RosbridgeServe
    | RosbridgeServeAction
    | RosbridgeLevel
    | RosbridgeFragment
)
