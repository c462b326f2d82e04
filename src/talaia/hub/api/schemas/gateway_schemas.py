"""Gateways: those that have a key, the codes for new ones, and a second one that waits."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from talaia.hub.api.schemas.common import Schema

__all__ = [
    "CodeAsk",
    "CodeShape",
    "EnrolAnswer",
    "EnrolAsk",
    "GatewayList",
    "GatewayShape",
    "HeldGatewayShape",
    "OpenCodeShape",
    "ReconnectAsk",
    "SecondGatewayAsk",
]


class HeldGatewayShape(Schema):
    """A second gateway with a site's key, which waits since ``since_us``."""

    address: str
    version: str
    since_us: int


class SecondGatewayAsk(Schema):
    """Which one of two gateways with one key stays: the ``linked`` one, or the ``held`` one."""

    stays: Literal["linked", "held"]


class GatewayShape(Schema):
    """A gateway that has, or had, a key.

    ``revoked_us`` is 0 while the key is good, ``seen_us`` 0 before its first link; address and
    version are those of its last link. ``held`` are others with its key, that wait.
    """

    id: str
    site: str
    name: str
    created_us: int
    revoked_us: int
    seen_us: int
    address: str
    version: str
    online: bool
    held: list[HeldGatewayShape]


class OpenCodeShape(Schema):
    """A one-time code that can still be used. What it says was shown once and is not kept."""

    id: str
    site: str
    created_us: int
    expires_us: int


class GatewayList(Schema):
    """All gateways, and the codes by which others may enrol."""

    gateways: list[GatewayShape]
    codes: list[OpenCodeShape]


class CodeAsk(Schema):
    """Make a one-time code for the gateway of a site; ``name`` is what people call it."""

    site: str = Field(pattern=r"^[a-z][a-z0-9_]{0,62}$")
    name: str = Field(default="", max_length=100)


class CodeShape(Schema):
    """A one-time code, shown once.

    ``command`` is what to run beside the robot, ``qr`` the same as an SVG picture, and
    ``fingerprint`` that of the hub's certificate (empty where a proxy holds it).
    """

    id: str
    code: str
    expires_us: int
    command: str
    fingerprint: str
    qr: str


class EnrolAsk(Schema):
    """Use a one-time code; ``name`` is what the gateway calls itself."""

    code: str = Field(min_length=1, max_length=200)
    name: str = Field(default="", max_length=100)


class EnrolAnswer(Schema):
    """The gateway's own key, told once; ``fingerprint`` is that of the hub's certificate."""

    site: str
    gateway: str
    key: str
    fingerprint: str


class ReconnectAsk(Schema):
    """Dial again (no device), or let the gateway connect anew to one device."""

    device: str = Field(default="", max_length=200)
