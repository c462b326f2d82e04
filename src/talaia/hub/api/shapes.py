"""Every JSON body of the HTTP API; the browser's types are made from these.

Times ending in ``_us`` are microseconds since the epoch (UTC).
"""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

__all__ = [
    "ArgumentShape",
    "CommandShape",
    "DeviceShape",
    "DriveShape",
    "EventList",
    "EventShape",
    "GapShape",
    "Health",
    "HistoryAnswer",
    "LoginAsk",
    "Me",
    "ProblemShape",
    "SeriesShape",
    "SetupAsk",
    "SignalShape",
    "SiteShape",
    "SiteSummary",
    "StreamShape",
]


class _Shape(BaseModel):
    """A key that is not described is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class ProblemShape(_Shape):
    """What went wrong: a word for programs, a sentence for people."""

    code: str
    message: str


class Health(_Shape):
    """The hub answers."""

    ok: bool


class LoginAsk(_Shape):
    """Sign in."""

    name: str = Field(min_length=1, max_length=200)
    password: str = Field(max_length=4096)


class SetupAsk(_Shape):
    """Make the first admin, with the token of the set-up link."""

    token: str = Field(min_length=1, max_length=200)
    name: str = Field(min_length=1, max_length=200)
    password: str = Field(max_length=4096)


class Me(_Shape):
    """Who is signed in. ``admin`` holds for the whole hub."""

    name: str
    role: str
    admin: bool


class SiteSummary(_Shape):
    """A site in the list.

    ``devices`` and ``signals`` count what you may see, ``stale`` those of the signals that are
    older than their limit or have never come.
    """

    site: str
    name: str
    zone: str
    online: bool
    since_us: int
    last_seen_us: int
    why: str
    loop_ms: float
    skew_ms: float
    devices: int
    signals: int
    stale: int


class SignalShape(_Shape):
    """A signal; ``channels`` are the addresses to subscribe to. ``max_age`` is in seconds."""

    id: str
    address: str
    name: str
    type: str
    unit: str
    decimals: int
    minimum: float | None
    maximum: float | None
    states: list[str]
    frame: str
    max_age: float
    primary: bool
    channels: list[str]


class StreamShape(_Shape):
    """A camera. ``max_rate`` is in Hz."""

    id: str
    address: str
    name: str
    max_rate: float


class ArgumentShape(_Shape):
    """One argument of a command."""

    id: str
    name: str
    type: str
    unit: str
    minimum: float | None
    maximum: float | None
    max_length: int
    default: bool | int | float | str | None


class CommandShape(_Shape):
    """A one-shot command. ``timeout`` is in seconds; ``cancellable``: it can be ended early."""

    id: str
    name: str
    description: str
    confirm: bool
    timeout: float
    cancellable: bool
    arguments: list[ArgumentShape]


class DriveShape(_Shape):
    """How a device is driven: m/s, rad/s, Hz and seconds. ``stop``: it has STOP (software)."""

    max_speed: float
    max_reverse: float
    max_turn: float
    rate: float
    ttl: float
    lease: float
    picture: str
    position: str
    stop: bool


class DeviceShape(_Shape):
    """A device as far as you may see it; ``rights`` are yours: view, use, admin.

    ``link_loss`` says what its gateway does with it when the hub is out of reach.
    """

    id: str
    name: str
    kind: str
    signals: list[SignalShape]
    streams: list[StreamShape]
    commands: list[CommandShape]
    drive: DriveShape | None
    link_loss: str
    rights: list[str]


class SiteShape(_Shape):
    """A site as far as you may see it."""

    site: str
    name: str
    zone: str
    online: bool
    since_us: int
    last_seen_us: int
    catalogue: str
    devices: list[DeviceShape]


class GapShape(_Shape):
    """Samples that are lost, and why."""

    from_us: int
    to_us: int
    reason: str


class SeriesShape(_Shape):
    """One channel's samples.

    Every one (``exact``) or the least and greatest of each bucket (``minmax``). ``v`` is null
    where there is no number; ``text`` is there for texts only.
    """

    address: str
    kind: str
    t_us: list[int]
    v: list[float | None]
    text: list[str] | None = None
    gaps: list[GapShape]


class HistoryAnswer(_Shape):
    """A window of the history."""

    series: list[SeriesShape]


class EventShape(_Shape):
    """Something that happened."""

    time_us: int
    kind: str
    device: str
    who: str
    message: str
    good: bool


class EventList(_Shape):
    """The newest events first."""

    events: list[EventShape]
