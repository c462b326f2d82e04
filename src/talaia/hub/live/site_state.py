"""What is known of one site now, in parts by how long each part holds.

A part is replaced as a whole when it holds no longer, so a field added to it cannot be forgotten.
"""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol, TypeVar

from talaia.wire.gateway_proof import NO_PLACE

if TYPE_CHECKING:
    from collections.abc import Collection

    from talaia.model.site import Site
    from talaia.wire.frames import (
        ChangeState,
        CommandState,
        DriveState,
        FromHub,
        InterlockState,
        LeaseState,
        RecorderState,
        ReleaseState,
        StopState,
        TwinState,
    )
    from talaia.wire.gateway_proof import ResumeToken

__all__ = [
    "CurrentState",
    "HeldGateway",
    "LinkedGateway",
    "Pending",
    "RetainedState",
    "RivalGateways",
    "SiteLink",
    "SitePresence",
]

_Known = TypeVar("_Known")

# A gateway that starts in a loop has a new run each time: names of so many are remembered.
_MOST_RIVALS = 100
_MOST_VOID = 1_000


class SiteLink(Protocol):
    """The way down to a gateway that is connected now."""

    def send(self, message: FromHub) -> None:
        """Queue a message; never waits. STOP and driving overtake the rest."""
        ...

    def dismiss_gateway(self, reason: str) -> None:
        """Say good-bye and close."""
        ...


@dataclass(slots=True)
class Pending:
    """A one-shot command whose end is not known yet."""

    id: str
    device: str
    command: str
    # Kept here, for the answer to a lost link comes from nobody who could name them.
    who: str


@dataclass(slots=True)
class SitePresence:
    """Whether a site's gateway is connected, since when, and how far away it is.

    Attributes:
        link: the way down; None while the gateway is away.
        since_us: when it went online or offline (UTC).
        last_seen_us: when its last link ended (UTC); 0 before the first has.
        why: it is away, in words for people; empty while it is connected.
        loop_ms: hub to gateway and back, by the last beat; after a loss, by the last one before.
        skew_ms: how far the gateway's wall clock is ahead of ours.

    """

    link: SiteLink | None = None
    since_us: int = 0
    last_seen_us: int = 0
    why: str = ""
    loop_ms: float = 0.0
    skew_ms: float = 0.0

    def mark_online(self, link: SiteLink, now_us: int) -> None:
        """Be online by ``link`` from ``now_us`` on (UTC)."""
        self.link, self.since_us, self.why = link, now_us, ""

    def measure_skew(self, told_us: int, wall_ns: int) -> None:
        """Note how far the gateway's wall clock is ahead; 0: it does not say."""
        # The clock of a gateway that does not say may be right or wrong: the last word stays.
        if told_us:
            self.skew_ms = round(told_us / 1000 - wall_ns / 1e6, 1)

    def mark_offline(self, now_us: int) -> None:
        """Be away from ``now_us`` on (UTC)."""
        self.link, self.why = None, "the connection to its gateway was lost"
        self.since_us = self.last_seen_us = now_us


@dataclass(slots=True)
class LinkedGateway:
    """What the gateway that is or was linked has said of itself; the next hello replaces it.

    It outlives the link: sightings of a run are closed by its name, and a gateway that comes back
    with the same description need not have it read again.

    Attributes:
        id: the number of the gateway; 0 before the first.
        boot: the run of the gateway; names of runs rise with time.
        fingerprint: hash of the description's text as it came, and its catalogue; empty before
            the first hello is kept.
        source: the description's text as a person wrote it; empty where it cannot be changed.
        digest: of the text that is kept as the site's newest version; empty: it is not known.
        accepts: which changes it takes: ``no``, ``readings`` or ``all``.
        takes: messages that may be sent to it, and not to older ones.
        problem: what is wrong with the description's file at the gateway, if anything.
        challenged: it proved its key by our challenge; one of before says the key.
        proven: which place it showed that it had as it was linked; none: it showed none.
        issued: its place now, which it shows on its next link.
        saved: that is on its disk.
        releases: how releases of its software stand; none: it takes none from its hub.

    """

    id: int = 0
    boot: str = ""
    fingerprint: tuple[bytes, str] = (b"", "")
    source: str = ""
    digest: str = ""
    accepts: str = ""
    takes: tuple[str, ...] = ()
    problem: ChangeState | None = None
    challenged: bool = False
    proven: ResumeToken = NO_PLACE
    issued: ResumeToken = NO_PLACE
    saved: bool = False
    releases: ReleaseState | None = None


@dataclass(slots=True, kw_only=True, eq=False)
class HeldGateway:
    """A gateway that waits while another one has the place.

    Attributes:
        link: the way down, for STOP alone.
        since_us: when it began to wait (UTC).
        turn: set when it may ask for the place again.
        frames: how many it has sent since the last beat.
        pressed: the newest STOP that was sent to it, by device.
        stops: how it says that STOP stands, by device; only of devices in ``pressed``.
        written: how far of that press the audit log says: 1 latched, 2 confirmed.

    """

    link: SiteLink
    boot: str
    version: str
    address: str
    since_us: int
    turn: asyncio.Event = field(default_factory=asyncio.Event)
    frames: int = 0
    pressed: dict[str, str] = field(default_factory=dict)
    stops: dict[str, StopState] = field(default_factory=dict)
    written: dict[str, int] = field(default_factory=dict)


@dataclass(slots=True)
class RivalGateways:
    """Other gateways that claim to be this site's; kept over links, since they dial again.

    Attributes:
        boots: runs of which people were told, so that each is told of once.
        seen_us: when the last of them was there (UTC); 0 when none has been for a while.
        held: those that wait now.
        chosen: the link of the one that an admin gave the place to, until it has it.
        settled: runs about which an admin has decided.

    """

    boots: set[str] = field(default_factory=set)
    seen_us: int = 0
    held: list[HeldGateway] = field(default_factory=list)
    chosen: SiteLink | None = None
    settled: set[str] = field(default_factory=set)
    # Places of gateways that were sent away; the oldest are forgotten.
    _void: dict[ResumeToken, None] = field(default_factory=dict)

    def void_tokens(self, *tokens: ResumeToken) -> None:
        """Let places show nothing any more."""
        self._void |= dict.fromkeys(tokens)
        while len(self._void) > _MOST_VOID:
            del self._void[next(iter(self._void))]

    def is_void(self, token: ResumeToken) -> bool:
        """Tell whether a place shows nothing any more."""
        return token in self._void

    def wake_held(self) -> None:
        """Let those that wait ask for the place again."""
        for held in self.held:
            held.turn.set()

    def settle_held(self, *, replaces: bool) -> bool:
        """Decide: the one that is linked stays, or the first that waits takes the place.

        Returns:
            Whether one waits.

        """
        if not self.held:
            return False
        self.seen_us = 0
        if replaces:
            self.chosen = self.held[0].link
            self.held[0].turn.set()
        elif len(self.settled) < _MOST_RIVALS:
            # It goes on waiting, so that STOP reaches it, and nobody is told of it again.
            self.settled |= {held.boot for held in self.held}
        return True

    def add_boot(self, boot: str) -> bool:
        """Remember a rival's run; give whether it is new."""
        if boot in self.boots:
            return False
        if len(self.boots) >= _MOST_RIVALS:
            # All at once: at worst people are told of a rival a second time.
            self.boots.clear()
        self.boots.add(boot)
        return True


@dataclass(slots=True)
class CurrentState:
    """What holds only while a link stands: a lost link leaves none of it.

    Attributes:
        leases: by device, with the moment it was heard (monotonic ns).
        drives: how each driven device moves, by device.
        twins: the switch and the rehearsal of its twin, by the real device.
        interlocks: by name, with the moment it was heard (monotonic ns).
        unreached: devices that the gateway does not reach: why, and since when (µs, UTC).
        pending: commands sent down whose end is not known yet, by id.
        acting: commands by which somebody acts on a device, by id, with the moment each was heard
            (monotonic ns).

    """

    leases: dict[str, tuple[LeaseState, int]] = field(default_factory=dict)
    drives: dict[str, DriveState] = field(default_factory=dict)
    twins: dict[str, TwinState] = field(default_factory=dict)
    interlocks: dict[str, tuple[InterlockState, int]] = field(default_factory=dict)
    unreached: dict[str, tuple[str, int]] = field(default_factory=dict)
    pending: dict[str, Pending] = field(default_factory=dict)
    acting: dict[str, tuple[CommandState, int]] = field(default_factory=dict)

    def drop_undescribed(self, description: Site) -> None:
        """Forget devices and interlocks that ``description`` has no longer.

        Commands stay: each still has an end that somebody waits for.
        """
        _keep_only(self.leases, description.devices)
        _keep_only(self.drives, description.devices)
        _keep_only(self.twins, description.devices)
        _keep_only(self.unreached, description.devices)
        _keep_only(self.interlocks, description.interlocks)


@dataclass(slots=True)
class RetainedState:
    """What is still shown of a site that is away; the next link begins without it.

    A latched STOP and a roof that is not shown to be closed stay true while nobody can say so.

    Attributes:
        stops: by device.
        enclosures: what the gateway has told of each on its last link: why it should be closed
            and cannot be shown to be; empty: all is well.
        recorder: what is recorded; None before the gateway has said.

    """

    stops: dict[str, StopState] = field(default_factory=dict)
    enclosures: dict[str, str] = field(default_factory=dict)
    recorder: RecorderState | None = None

    def drop_undescribed(self, description: Site) -> None:
        """Forget devices and enclosures that ``description`` has no longer."""
        _keep_only(self.stops, description.devices)
        _keep_only(self.enclosures, description.enclosures)


def _keep_only(by_name: dict[str, _Known], names: Collection[str]) -> None:
    # A set of its own, so that the dict may shrink meanwhile.
    for name in by_name.keys() - set(names):
        del by_name[name]
