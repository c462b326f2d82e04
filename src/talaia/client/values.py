"""What a script gets to see of a hub: sites and what is in them, values, results, recordings.

They are read from the hub's own JSON. What a newer hub says more is passed over.
"""

from __future__ import annotations

from datetime import UTC, datetime
from typing import NamedTuple

import msgspec

from talaia.client.errors import CommandNotDone

__all__ = [
    "ArgumentInfo",
    "CommandInfo",
    "CommandProgress",
    "CommandResult",
    "DeviceInfo",
    "DriveInfo",
    "DriveReport",
    "Reading",
    "RecordedFile",
    "RecorderInfo",
    "RecordingOverview",
    "SignalInfo",
    "SiteInfo",
    "SiteOverview",
    "time_of",
]


class SiteOverview(msgspec.Struct, frozen=True, kw_only=True):
    """A site in the list of all.

    Attributes:
        zone: the site's time zone, by its name in the IANA database.
        why: why it is away, in words; empty while it is connected.
        stale: how many of the signals are older than their limit.

    """

    site: str
    name: str
    zone: str = "UTC"
    online: bool = False
    why: str = ""
    devices: int = 0
    signals: int = 0
    stale: int = 0


class SignalInfo(msgspec.Struct, frozen=True, kw_only=True):
    """A signal: ``max_age`` in seconds; a position has several ``channels``."""

    address: str
    name: str
    type: str
    unit: str = ""
    states: list[str] = []
    max_age: float = 1e9
    channels: list[str] = []


class ArgumentInfo(msgspec.Struct, frozen=True, kw_only=True):
    """One argument of a command."""

    id: str
    name: str
    type: str
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    default: bool | int | float | str | None = None


class CommandInfo(msgspec.Struct, frozen=True, kw_only=True):
    """A command: ``timeout`` in seconds; ``confirm``: people are asked whether it is meant."""

    id: str
    name: str
    description: str = ""
    confirm: bool = False
    timeout: float = 60.0
    cancellable: bool = False
    arguments: list[ArgumentInfo] = []


class DriveInfo(msgspec.Struct, frozen=True, kw_only=True):
    """How a device is driven (m/s, rad/s)."""

    max_speed: float
    max_reverse: float = 0.0
    max_turn: float = 0.0


class DeviceInfo(msgspec.Struct, frozen=True, kw_only=True):
    """A device as far as the token may see it; ``rights`` are what it may do with it."""

    id: str
    name: str
    kind: str = ""
    signals: list[SignalInfo] = []
    commands: list[CommandInfo] = []
    drive: DriveInfo | None = None
    rights: list[str] = []


class SiteInfo(msgspec.Struct, frozen=True, kw_only=True):
    """A site as far as the token may see it; ``catalogue`` names its description of now."""

    site: str
    name: str
    zone: str = "UTC"
    online: bool = False
    catalogue: str = ""
    devices: list[DeviceInfo] = []


class Reading(NamedTuple):
    """The newest known value of a channel.

    Attributes:
        address: ``site/device/signal``, with ``.x`` and the like for a part of a position.
        value: a number, a text, or the word of a state; NaN where the robot said so.
        unit: of the number; empty where it has none.
        time: when it was read (UTC).
        age_s: how old it is, by clocks that nobody sets.
        stale: why it is not to be taken for what is so now; empty where it is.

    """

    address: str
    value: float | str
    unit: str
    time: datetime
    age_s: float
    stale: str = ""


class CommandProgress(NamedTuple):
    """A command under way: its phase, how far (0 to 1), the robot's words."""

    phase: str
    progress: float
    message: str


class CommandResult(NamedTuple):
    """What has become of a command.

    Attributes:
        command: ``site/device/command``.
        id: by which it stands in the site's logbook.
        phase: ``succeeded``, ``failed``, ``refused``, ``cancelled`` or ``unknown``: it may have
            been done and it may not, so look at the device before you ask again.
        message: the robot's words, or why it was refused.
        blocked_by: refused because of this command of somebody else, which is under way.

    """

    command: str
    id: str
    phase: str
    message: str = ""
    blocked_by: str = ""

    @property
    def succeeded(self) -> bool:
        """Whether it was done."""
        return self.phase == "succeeded"

    def raise_unless_succeeded(self) -> CommandResult:
        """Give the result back if it was done.

        Raises:
            CommandNotDone: it was not.

        """
        if not self.succeeded:
            raise CommandNotDone(self)
        return self


class DriveReport(NamedTuple):
    """What a driven device is being told.

    Attributes:
        linear: forward (m/s), after all limits.
        angular: counter-clockwise (rad/s).
        cap: part of the greatest speed that is allowed now (0 to 1).
        why: why the newest velocity was refused; empty where it was not.
        stopped: STOP (software) is on, and somebody at a page has to reset it.

    """

    linear: float = 0.0
    angular: float = 0.0
    cap: float = 1.0
    why: str = ""
    stopped: bool = False


class RecordedFile(msgspec.Struct, frozen=True, kw_only=True):
    """A recording at the hub: raw topics as MCAP, or the film of a camera (``stream``) as MP4.

    Attributes:
        state: ``complete`` when the whole of it is at the hub.
        begin_us: time of the first message (µs since the epoch, UTC).
        have: bytes of its ``size`` that are at the hub.

    """

    id: str
    state: str
    why: str = ""
    who: str = ""
    note: str = ""
    begin_us: int = 0
    end_us: int = 0
    size: int = 0
    have: int = 0
    messages: int = 0
    topics: list[str] = []
    stream: str = ""


class RecorderInfo(msgspec.Struct, frozen=True, kw_only=True):
    """How the gateway's recorder stands; ``problem`` says why the last recording failed."""

    described: bool = False
    online: bool = False
    on: bool = False
    id: str = ""
    why: str = ""
    problem: str = ""
    filming: list[str] = []
    can_film: bool = False


class RecordingOverview(msgspec.Struct, frozen=True, kw_only=True):
    """A site's recorder, and what was recorded, the newest first."""

    recorder: RecorderInfo
    recordings: list[RecordedFile] = []


def time_of(time_us: int) -> datetime:
    """Give the moment of so many microseconds since the epoch."""
    # Whole seconds and the rest apart: a float does not hold all microseconds of this century.
    seconds, rest = divmod(time_us, 1_000_000)
    return datetime.fromtimestamp(seconds, UTC).replace(microsecond=rest)
