"""What one account may see and do of a site, whatever the protocol it comes by. Pure.

Each protocol gives this its own form. What an account may not see is not in it, so nothing that is
listed has to be hidden later.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.auth.permissions import Right, sees_signal, sees_stream
from talaia.model.site import DriveMessage, parts_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.hub.auth.permissions import Grants
    from talaia.model.site import Command, Drive, Signal, Site

__all__ = [
    "AccountOffer",
    "DrivenTopic",
    "OfferedCamera",
    "OfferedCommand",
    "OfferedDrive",
    "OfferedSignal",
    "make_account_offer",
]


class OfferedSignal(NamedTuple):
    """A signal that the account may see."""

    device: str
    name: str
    signal: Signal

    @property
    def address(self) -> str:
        """Name it as people do; its channels have the part behind that."""
        return f"{self.device}/{self.name}"

    def addresses(self) -> dict[str, str]:
        """Give the addresses of its channels by part; a single one has the empty name."""
        return {
            part: f"{self.address}.{part}" if part else self.address
            for part in parts_of(self.signal)
        }


class OfferedCamera(NamedTuple):
    """A camera whose pictures the account may see."""

    device: str
    name: str

    @property
    def address(self) -> str:
        """Name it as people do."""
        return f"{self.device}/{self.name}"


class OfferedCommand(NamedTuple):
    """A command that the account may call."""

    device: str
    name: str
    command: Command


class OfferedDrive(NamedTuple):
    """A driven device that the account may view, and so may stop.

    Attributes:
        usable: it may also use it, which driving takes, beside an admin's word.

    """

    device: str
    rule: Drive
    usable: bool


class DrivenTopic(NamedTuple):
    """A topic to which a velocity may be published, and of which type it is there."""

    device: str
    type: str


@dataclass(frozen=True, slots=True)
class AccountOffer:
    """All of it, in the order of the description.

    Attributes:
        signals: see above.
        cameras: see above.
        commands: see above.
        drives: see above.
        facts: plain facts of the description, by the names that parameters have.

    """

    # Each protocol goes through these in this order, so that its numbers are the same next time.
    signals: tuple[OfferedSignal, ...]
    cameras: tuple[OfferedCamera, ...]
    commands: tuple[OfferedCommand, ...]
    drives: tuple[OfferedDrive, ...]
    facts: dict[str, str | float]

    def driven_topics(self, prefix: str) -> dict[str, DrivenTopic]:
        """Give the topics by which devices are driven: the robot's, and our own after ``prefix``.

        Of two devices that listen to one topic of the robot it is the first's.
        """
        # The first to take a name keeps it.
        topics: dict[str, DrivenTopic] = {}
        for drive in self.drives:
            # Wheels that steer and joints are driven from the pages alone.
            if drive.rule.message.steers or drive.rule.message.jogs:
                continue
            topics.setdefault(drive.rule.topic, DrivenTopic(drive.device, drive.rule.message.value))
            # Ours takes plain velocities, whatever the device itself listens to.
            topics[f"{prefix}/{drive.device}/drive"] = DrivenTopic(
                drive.device, DriveMessage.TWIST.value
            )
        return topics


def make_account_offer(site: Site, grants: Grants) -> AccountOffer:
    """Choose what an account is offered of a site now."""
    drives = tuple(_offered_drives(site, grants))
    return AccountOffer(
        # One by one: a public signal or camera may be of a device that is not.
        signals=tuple(
            OfferedSignal(device, name, signal)
            for device, described in site.devices.items()
            for name, signal in described.signals.items()
            if sees_signal(grants, site, device, name)
        ),
        cameras=tuple(
            OfferedCamera(device, name)
            for device, described in site.devices.items()
            for name in described.streams
            if sees_stream(grants, site, device, name)
        ),
        commands=tuple(
            OfferedCommand(device, name, command)
            for device, described in site.devices.items()
            # Viewing a device does not show what could be done with it.
            if grants.has_right(Right.USE, site.site, device)
            for name, command in described.commands.items()
        ),
        drives=drives,
        facts=_facts_of(site, drives),
    )


def _offered_drives(site: Site, grants: Grants) -> Iterator[OfferedDrive]:
    for device, described in site.devices.items():
        # Whoever may look at a driven device may stop it.
        if described.drive is not None and grants.has_right(Right.VIEW, site.site, device):
            usable = grants.has_right(Right.USE, site.site, device)
            yield OfferedDrive(device, described.drive, usable)


def _facts_of(site: Site, drives: tuple[OfferedDrive, ...]) -> dict[str, str | float]:
    facts: dict[str, str | float] = {"/site": site.site, "/name": site.name, "/zone": site.zone}
    for drive in drives:
        facts[f"/{drive.device}/drive/max_speed"] = drive.rule.max_speed
        facts[f"/{drive.device}/drive/max_turn"] = drive.rule.max_turn
    return facts
