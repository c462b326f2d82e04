"""What a Foxglove server says as JSON; what it says in binary is written by `codec`."""

from __future__ import annotations

from msgspec import Struct

__all__ = [
    "AdvertiseChannels",
    "AdvertiseServices",
    "ConnectionGraphUpdate",
    "FoxgloveChannel",
    "FoxgloveParameter",
    "FoxgloveSchema",
    "FoxgloveService",
    "FoxgloveTime",
    "GraphProviders",
    "GraphPublishers",
    "GraphSubscribers",
    "ParameterValues",
    "RemoveStatus",
    "ServerInfo",
    "ServerMessage",
    "ServerStatus",
    "ServiceCallFailure",
    "UnadvertiseChannels",
    "UnadvertiseServices",
]

Parameter = float | int | bool | str | list[float | int | bool | str]


class _ServerSaid(
    Struct, frozen=True, kw_only=True, tag_field="op", rename="camel", omit_defaults=True
):
    """Base of what is said."""


class FoxgloveTime(Struct, frozen=True):
    """A time in JSON (UTC)."""

    sec: int
    nsec: int


class ServerInfo(_ServerSaid, frozen=True, kw_only=True, tag="serverInfo"):
    """First message: what the server can do."""

    # For people.
    name: str
    # What may be asked besides subscribing; clients hide the rest.
    capabilities: list[str]
    # In which clients may publish and call.
    supported_encodings: list[str] = []
    metadata: dict[str, str]
    # Another one after a new connection: what a client remembers by number is void then.
    session_id: str
    # The window of past data that is played; None: what comes is live.
    data_start_time: FoxgloveTime | None = None
    data_end_time: FoxgloveTime | None = None


class ServerStatus(_ServerSaid, frozen=True, kw_only=True, tag="status"):
    """Something for the person; ``level`` is 0 (info), 1 (warning) or 2 (error)."""

    level: int
    message: str
    # By which it can be taken back; None: it cannot.
    id: str | None = None


class RemoveStatus(_ServerSaid, frozen=True, kw_only=True, tag="removeStatus"):
    """These are not so any more."""

    status_ids: list[str]


class FoxgloveChannel(Struct, frozen=True, kw_only=True, rename="camel", omit_defaults=True):
    """A channel that may be subscribed to."""

    # Ours, by which it is subscribed to.
    id: int
    topic: str
    # Of the messages: ``json`` or ``cdr``.
    encoding: str
    schema_name: str
    # Of the schema: ``jsonschema`` or ``ros2msg``.
    schema_encoding: str | None = None
    schema: str


class AdvertiseChannels(_ServerSaid, frozen=True, kw_only=True, tag="advertise"):
    """These channels are there."""

    channels: list[FoxgloveChannel]


class UnadvertiseChannels(_ServerSaid, frozen=True, kw_only=True, tag="unadvertise"):
    """These channels are there no more."""

    channel_ids: list[int]


class FoxgloveSchema(Struct, frozen=True, kw_only=True, rename="camel"):
    """How a service's request or response is written."""

    encoding: str
    schema_name: str
    schema_encoding: str
    schema: str


class FoxgloveService(Struct, frozen=True, kw_only=True, rename="camel"):
    """A service that may be called."""

    id: int
    name: str
    # For people: request and response say how they are written.
    type: str
    request: FoxgloveSchema
    response: FoxgloveSchema


class AdvertiseServices(_ServerSaid, frozen=True, kw_only=True, tag="advertiseServices"):
    """These services are there."""

    services: list[FoxgloveService]


class UnadvertiseServices(_ServerSaid, frozen=True, kw_only=True, tag="unadvertiseServices"):
    """These services are there no more."""

    service_ids: list[int]


class ServiceCallFailure(_ServerSaid, frozen=True, kw_only=True, tag="serviceCallFailure"):
    """A call has come to nothing."""

    # As the call named both.
    service_id: int
    call_id: int
    # For people.
    message: str


class FoxgloveParameter(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A parameter; ``type`` is given where JSON does not tell: ``float64`` of a number."""

    name: str
    type: str | None = None
    value: Parameter


class ParameterValues(_ServerSaid, frozen=True, kw_only=True, tag="parameterValues"):
    """What parameters are; ``id`` is of the request that this answers."""

    parameters: list[FoxgloveParameter]
    id: str | None = None


class GraphPublishers(Struct, frozen=True, kw_only=True, rename="camel"):
    """Who publishes a topic."""

    name: str
    publisher_ids: list[str]


class GraphSubscribers(Struct, frozen=True, kw_only=True, rename="camel"):
    """Who subscribes to a topic."""

    name: str
    subscriber_ids: list[str]


class GraphProviders(Struct, frozen=True, kw_only=True, rename="camel"):
    """Who provides a service."""

    name: str
    provider_ids: list[str]


class ConnectionGraphUpdate(_ServerSaid, frozen=True, kw_only=True, tag="connectionGraphUpdate"):
    """What has changed of who publishes, subscribes and provides what."""

    published_topics: list[GraphPublishers]
    subscribed_topics: list[GraphSubscribers]
    advertised_services: list[GraphProviders]
    # Since the update before.
    removed_topics: list[str]
    removed_services: list[str]


ServerMessage = (
    ServerInfo
    | ServerStatus
    | RemoveStatus
    | AdvertiseChannels
    | UnadvertiseChannels
    | AdvertiseServices
    | UnadvertiseServices
    | ServiceCallFailure
    | ParameterValues
    | ConnectionGraphUpdate
)
