"""JSON bodies of client protocols; the browser's types are made from these.

Times ending in ``_us`` are microseconds since the epoch (UTC); 0 says never.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from talaia.hub.api.schemas.common import Schema

__all__ = [
    "BrokerShape",
    "ClientDriverAsk",
    "ClientDriverShape",
    "ClientProtocolAsk",
    "ClientProtocolList",
    "ClientProtocolShape",
]

_NAME = Field(min_length=1, max_length=200)
_MOST_ORIGINS = 50
_Origin = Annotated[str, Field(min_length=1, max_length=200)]


class BrokerShape(Schema):
    """A broker that the hub connects to, as the file that it was started with says.

    ``since_us`` is when it was connected or lost; ``why`` is empty while it is connected, and
    while the protocol is shut or its token is not good.
    """

    address: str
    connected: bool
    since_us: int
    why: str
    # What its access list does not let the hub do, on this connection.
    refused: list[str]


class ClientProtocolShape(Schema):
    """A protocol by which other tools connect.

    ``path`` is where it is served, with ``{site}`` for the site; ``changed_by`` is who opened or
    shut it last; ``connected`` counts the clients of now.
    """

    # Its short name, as in addresses and in the audit log.
    protocol: str
    title: str
    path: str
    # A WebSocket, else HTTP.
    socket: bool
    # Programs that speak it, for people.
    tools: str
    open: bool
    # Of pages that are let in; tools that are no pages send none.
    origins: list[str]
    changed_by: str
    changed_us: int
    # By this process, now.
    connected: int
    # Of protocols by which the hub connects; empty: it was started without any.
    brokers: list[BrokerShape]


class ClientDriverShape(Schema):
    """An account that may drive a device by such clients."""

    # Number and name of the account.
    person: str
    name: str
    site: str
    device: str
    # Which admin, and when.
    given_by: str
    given_us: int


class ClientProtocolList(Schema):
    """All protocols, and who may drive by them."""

    protocols: list[ClientProtocolShape]
    drivers: list[ClientDriverShape]


class ClientProtocolAsk(Schema):
    """Open or shut a protocol; pages of ``origins`` are let in besides tools that are no pages."""

    open: bool
    # As a browser writes them: scheme, host and port.
    origins: list[_Origin] = Field(default=[], max_length=_MOST_ORIGINS)


class ClientDriverAsk(Schema):
    """Let an account drive a device by such clients, or no more."""

    person: str = Field(min_length=1, max_length=20)
    site: str = _NAME
    device: str = _NAME
    # False takes it back, at once.
    allowed: bool
