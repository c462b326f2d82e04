"""The sites the hub knows, and what is true of each now."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from talaia.hub.anomaly.selection import score_channels
from talaia.hub.live.last_values import Latest

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.model.site import Channel, Site
    from talaia.wire.frames import (
        ChangeState,
        CommandState,
        DriveState,
        FromHub,
        InterlockState,
        LeaseState,
        RecorderState,
        StopState,
    )

__all__ = ["LiveSite", "Pending", "SiteLink", "Sites"]


class SiteLink(Protocol):
    """The way down to a gateway that is connected now."""

    def send(self, message: FromHub) -> None:
        """Queue a message; never waits. STOP and driving overtake the rest."""
        ...

    def dismiss(self, reason: str) -> None:
        """Say good-bye and close."""
        ...


@dataclass(slots=True)
class Pending:
    """A one-shot command whose end is not known yet."""

    id: str
    device: str
    command: str
    who: str


@dataclass(slots=True)
class LiveSite:
    """One site, now.

    Attributes:
        every: what a page may subscribe to: ``channels``, and after them those of the scores of
            its detectors.
        latest: the newest sample of each of ``every``.
        since_us: when it went online or offline (UTC).
        loop_ms: hub to gateway and back, by the last beat.
        skew_ms: how far the gateway's wall clock is ahead of ours.
        link: the way down; None while the gateway is away.
        told: hash of the description's text as it came, and its catalogue; empty before the
            first hello is kept.
        boot: the run of the gateway that is or was linked; see `Gateways`.
        rivals: runs of other gateways with this identity, of which people were told.
        rival_us: when the last of them was there (UTC); 0 when none has been for a while.
        leases: by device, with the moment it was heard (monotonic ns).
        interlocks: by name, with the moment it was heard (monotonic ns).
        source: the description's text as a person wrote it; empty where it cannot be changed.
        accepts: which changes its gateway takes: ``no``, ``readings`` or ``all``.
        gateway: the number of the gateway that is or was linked; 0 before the first.
        renamed: channels that have another address now, by former ones.
        problem: what is wrong with the description's file at the gateway, if anything.
        enclosures: what the gateway has told of each on this link: why it should be closed and
            cannot be shown to be; empty: all is well.
        acting: commands by which somebody acts on a device, by id, with the moment each was heard
            (monotonic ns).
        unreached: devices that the gateway does not reach: why, and since when (µs, UTC).

    """

    description: Site
    catalogue: str
    channels: tuple[Channel, ...]
    every: tuple[Channel, ...]
    latest: Latest
    since_us: int = 0
    last_seen_us: int = 0
    why: str = ""
    loop_ms: float = 0.0
    skew_ms: float = 0.0
    link: SiteLink | None = None
    told: tuple[bytes, str] = (b"", "")
    boot: str = ""
    rivals: set[str] = field(default_factory=set)
    rival_us: int = 0
    leases: dict[str, tuple[LeaseState, int]] = field(default_factory=dict)
    stops: dict[str, StopState] = field(default_factory=dict)
    drives: dict[str, DriveState] = field(default_factory=dict)
    interlocks: dict[str, tuple[InterlockState, int]] = field(default_factory=dict)
    enclosures: dict[str, str] = field(default_factory=dict)
    unreached: dict[str, tuple[str, int]] = field(default_factory=dict)
    pending: dict[str, Pending] = field(default_factory=dict)
    acting: dict[str, tuple[CommandState, int]] = field(default_factory=dict)
    recorder: RecorderState | None = None
    source: str = ""
    accepts: str = ""
    gateway: int = 0
    renamed: dict[str, str] = field(default_factory=dict)
    problem: ChangeState | None = None

    @property
    def edition(self) -> str:
        """A name for the description as it is now: another one has another."""
        said, catalogue = self.told
        return said.hex()[:16] if said else catalogue or self.catalogue

    @property
    def name(self) -> str:
        """The site's short name."""
        return self.description.site

    @property
    def online(self) -> bool:
        """Whether its gateway is connected."""
        return self.link is not None


class Sites:
    """The sites by name; those that are away are known from the database."""

    def __init__(self) -> None:
        """Start with none."""
        self._sites: dict[str, LiveSite] = {}

    def __iter__(self) -> Iterator[LiveSite]:
        """Go through the sites in the order of their names."""
        return iter([self._sites[name] for name in sorted(self._sites)])

    def get(self, name: str) -> LiveSite | None:
        """Find a site by its short name."""
        return self._sites.get(name)

    def describe(
        self, description: Site, catalogue: str, renamed: Mapping[str, str] | None = None
    ) -> LiveSite:
        """Add a site or take its new description; newest values stay if the channels do.

        ``renamed`` are channels that have another address now, by the one before.
        """
        live = self._sites.get(description.site)
        channels = description.channels()
        every = (*channels, *score_channels(description, len(channels)))
        if live is None:
            live = LiveSite(description, catalogue, channels, every, Latest(len(every)))
            self._sites[description.site] = live
            return live
        if every != live.every:
            live.latest = _moved(live.latest, live.every, every, renamed or {})
        live.description, live.catalogue = description, catalogue
        live.channels, live.every = channels, every
        return live


def _moved(
    latest: Latest,
    before: tuple[Channel, ...],
    channels: tuple[Channel, ...],
    renamed: Mapping[str, str],
) -> Latest:
    """Carry the newest values over to another list of channels."""
    moved = Latest(len(channels))
    number = {
        renamed.get(channel.address, channel.address): at for at, channel in enumerate(before)
    }
    for at, channel in enumerate(channels):
        was = number.get(channel.address)
        if was is not None:
            latest.moved_to(moved, was, at)
    return moved
