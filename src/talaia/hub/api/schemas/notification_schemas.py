"""What the routes of ways, rules and browsers take and give. Secrets go in, and never out."""

from __future__ import annotations

import re
from typing import Annotated, Literal, Self

from pydantic import Field, StringConstraints, model_validator

from talaia.hub.api.schemas.common import Schema
from talaia.hub.store.alarms.notification_channels import WayKind  # noqa: TC001 - pydantic reads it
from talaia.model.alarms.alarm import Severity
from talaia.model.units.time_zones import known_zones

__all__ = [
    "NoticeRuleShape",
    "PushAsk",
    "PushBrowserShape",
    "PushList",
    "RuleAsk",
    "RuleList",
    "WayAsk",
    "WayChoice",
    "WayChoiceList",
    "WayList",
    "WayShape",
    "WentShape",
    "WriteOnly",
]

# No control characters: a new line in a header of mail would begin another one.
_Line = Annotated[str, StringConstraints(max_length=200, pattern=r"^[^\x00-\x1f\x7f]*$")]
_Secret = Annotated[str, StringConstraints(max_length=2000, pattern=r"^[^\x00-\x1f\x7f]*$")]
# One address and nothing else: it goes into a header.
_MAIL = re.compile(r"[^\s\x00-\x1f\x7f<>(),:;\"\\@]{1,64}@[A-Za-z0-9.\-]{1,190}\Z")
# Becomes the name of a field of the extension's keys.
_Key = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,62}$")]
_Minute = Annotated[int, Field(ge=0, le=1439)]  # of the day, from midnight


class WriteOnly(Schema):
    """Secrets of a way; what is left out stays as it is, an empty text removes it."""

    password: _Secret | None = None
    url: _Secret | None = None
    token: _Secret | None = None
    keys: Annotated[dict[_Key, _Secret], Field(max_length=50)] | None = None


class WayAsk(Schema):
    """A server that messages go to.

    Mail: ``host``, ``port``, ``security``, ``sender``, and ``user`` with the secret ``password``.
    Webhook: the secrets ``url`` and ``token`` (sent as a bearer token). Chat: the secret ``url``,
    as apprise writes it (``ntfys://…``, ``matrixs://…``, ``tgram://…``). Push: ``sender``, an
    address at which a push service may reach you. Extension: its name, and the secret ``keys``,
    all of them at once.
    """

    name: Annotated[_Line, StringConstraints(min_length=1, strip_whitespace=True)]
    kind: WayKind
    extension: Annotated[str, StringConstraints(pattern=r"^([a-z][a-z0-9_]{0,62})?$")] = ""
    host: Annotated[str, StringConstraints(max_length=200, pattern=r"^[A-Za-z0-9.\-:]*$")] = ""
    port: int = Field(default=587, ge=1, le=65535)
    security: Literal["starttls", "tls", "none"] = "starttls"
    sender: str = Field(default="", max_length=255)
    user: _Line = ""
    secrets: WriteOnly = WriteOnly()

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if self.kind in {"mail", "push"} and not _MAIL.match(self.sender):
            raise ValueError("sender: expected one mail address")
        if self.kind == "mail" and not self.host:
            raise ValueError("host: expected the name of the mail server")
        if (self.kind == "extension") != bool(self.extension):
            raise ValueError("extension: expected the name of a notifier, with that kind only")
        return self


class WayShape(Schema):
    """A way, as an admin sees it; ``secrets`` names those that are set, and no more."""

    id: str
    name: str
    kind: WayKind
    extension: str
    host: str
    port: int
    security: Literal["starttls", "tls", "none"]
    sender: str
    user: str
    secrets: list[str]


class WayList(Schema):
    """All ways."""

    ways: list[WayShape]


class WayChoice(Schema):
    """A way that you can be told by."""

    id: str
    name: str
    kind: WayKind


class WayChoiceList(Schema):
    """All ways that you can be told by."""

    ways: list[WayChoice]


class RuleAsk(Schema):
    """Tell me of alarms.

    ``site`` may be ``*``; ``target`` is where to, for mail. Quiet hours are minutes of the day in
    ``zone``; none where both are the same. ``group_s``: what follows so soon comes along.
    """

    site: str = Field(pattern=r"^(\*|[a-z][a-z0-9_]{0,62})$")
    way: str = Field(pattern=r"^[0-9]{1,18}$")
    target: _Line = ""
    least: Severity = Severity.WARNING
    over: bool = True
    quiet_from: _Minute = 0
    quiet_to: _Minute = 0
    quiet_least: Severity = Severity.CRITICAL
    zone: str = Field(default="UTC", max_length=64)
    group_s: int = Field(default=10, ge=0, le=3600)
    # Told also when a request for observations of yours is done, or has failed.
    own_requests: bool = False
    # Told also how a night that runs by itself has ended, and when it needs somebody.
    nights: bool = False

    @model_validator(mode="after")
    def _known(self) -> Self:
        if self.zone not in known_zones():
            raise ValueError("zone: there is no such time zone")
        return self


class NoticeRuleShape(RuleAsk):
    """One of your rules."""

    id: str


class RuleList(Schema):
    """Your rules."""

    rules: list[NoticeRuleShape]


class WentShape(Schema):
    """How a test went: ``sent``, or what went wrong, in the words of whoever refused it."""

    sent: bool
    problem: str


class PushAsk(Schema):
    """A browser's subscription, as its Push API gives it."""

    # The browser names where to: so only over TLS, and only to public addresses (`senders`).
    endpoint: Annotated[str, StringConstraints(max_length=1500, pattern=r"^https://[!-~]+$")]
    p256dh: str = Field(max_length=200, pattern=r"^[A-Za-z0-9_\-=]+$")
    auth: str = Field(max_length=100, pattern=r"^[A-Za-z0-9_\-=]+$")


class PushBrowserShape(Schema):
    """A browser of yours that takes messages."""

    id: str
    agent: str
    created_us: int


class PushList(Schema):
    """Your browsers; ``key`` is what a browser needs to subscribe, empty where push is not set."""

    key: str
    browsers: list[PushBrowserShape]
