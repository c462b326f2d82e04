"""What a probe found, brought into the description that is open. Pure.

What is there already stays as the person has it; only what is new is added. A source is known by
what it reads, not by its name, so a signal that was renamed does not come twice.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.configurator.description_paths import Path, value_at, with_value
from talaia.configurator.edits import free_word
from talaia.model.checks.site_checks import check_site
from talaia.model.connection import kind_of
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.rules.stop_choice import NO_ANSWERS, StopAnswers, StopChoice

if TYPE_CHECKING:
    from talaia.model.discovery.probe_report import Found
    from talaia.model.site import Command, Device, Site, Source

__all__ = ["Merged", "merge_findings"]


class Merged(NamedTuple):
    """The description with what was found, and what came of it.

    Attributes:
        added: paths of what is new, devices among them.
        known: how many signals, cameras and commands were described before.
        left_out: what of the robot is not in it and why, in words.

    """

    site: Site
    added: tuple[Path, ...]
    known: int
    left_out: tuple[str, ...]
    # What STOP of a device that is newly driven may go by; only its owner knows.
    stops: tuple[StopChoice, ...] = ()

    def count(self, group: str) -> int:
        """Tell how many of ``signals``, ``streams`` or ``commands`` are new."""
        return sum(len(path) == 4 and path[2] == group for path in self.added)


def merge_findings(site: Site, found: Found, answers: StopAnswers = NO_ANSWERS) -> Merged:
    """Add to ``site`` what a probe found and it does not describe yet.

    ``answers`` are what the owner said of STOP, by the addresses of ``Merged.stops``.
    """
    # The same proposal as `talaia init` makes, so that both ways lead to one description.
    proposal = propose_description(found, site.site, site.name, site.zone, answers=answers)
    links = site.links()
    # Also a domain that the description does not say yet; one that it says stays.
    if not links or (found.domain and site.ros2 and site.ros2.domain is None):
        site = msgspec.structs.replace(site, ros2=proposal.site.ros2 or site.ros2)
        links = site.links()
    # Empty where no connection is of that protocol.
    link = next((name for name, link in links.items() if kind_of(link) == found.protocol), "")
    # Proposed device to the one that takes its things.
    words = {word: _device_to_fill(site, word, link) for word in proposal.site.devices}
    # What is described already, whatever it is called here.
    have = {key for device in site.devices.values() for key in _identities_of(device)}
    added: list[Path] = []
    known = 0
    for word, device in proposal.site.devices.items():
        path: Path = ("devices", words[word])
        if words[word] not in site.devices:
            drives = device.drive is not None and _is_undriven(site, device.drive.topic)
            # Nothing of it is new: an empty device would only be in the way.
            if not drives and all(key in have for key in _identities_of(device)):
                known += len(_identities_of(device))
                continue
            # Its things are added one by one below, where each is compared.
            bare = msgspec.structs.replace(
                device,
                signals={},
                streams={},
                commands={},
                drive=None,
                connection=link if len(links) > 1 else "",
            )
            site = with_value(site, path, bare)
            added.append(path)
        site, new, old = _fill_device(site, path, device, words=words, have=have)
        added += new
        known += old
    # Last, when all that driving may refer to is there.
    site = _without_open_ends(site, added)
    # Asked is of what is driven from now on; what was driven before its owner has described.
    driven = {path[1] for path in added if path[-1] == "drive"}
    stops = tuple(stop for stop in proposal.stops if words.get(stop.device) in driven)
    return Merged(site, tuple(added), known, proposal.left_out, stops)


def _device_to_fill(site: Site, word: str, link: str) -> str:
    """Give the device to fill: that of the same name, unless it is reached another way."""
    if word in site.devices and link and site.connection_of(word) not in (link, ""):
        return free_word(word, site.devices)
    return word


def _fill_device(
    site: Site, path: Path, device: Device, *, words: dict[str, str], have: set[tuple[str, ...]]
) -> tuple[Site, list[Path], int]:
    added: list[Path] = []
    known = 0
    groups: tuple[tuple[str, dict[str, msgspec.Struct]], ...] = (
        ("signals", dict(device.signals)),
        ("streams", dict(device.streams)),
        ("commands", dict(device.commands)),
    )
    for group, things in groups:
        for name, thing in things.items():
            if _identity_of(thing) in have:
                known += 1
                continue
            there = value_at(site, (*path, group))
            assert isinstance(there, dict)  # noqa: S101 - the three groups are mappings
            place = (*path, group, free_word(name, there))
            site = with_value(site, place, thing)
            added.append(place)
    drive = device.drive
    if (
        drive is not None
        and value_at(site, (*path, "drive")) is None
        and _is_undriven(site, drive.topic)
    ):
        drive = msgspec.structs.replace(
            drive,
            picture=_renamed_address(drive.picture, words),
            position=_renamed_address(drive.position, words),
            joints={
                name: msgspec.structs.replace(
                    joint, position=_renamed_address(joint.position, words)
                )
                for name, joint in drive.joints.items()
            },
        )
        confirmed = tuple(_renamed_address(address, words) for address in drive.stop.confirmed_by)
        stop = msgspec.structs.replace(drive.stop, confirmed_by=confirmed)
        site = with_value(site, (*path, "drive"), msgspec.structs.replace(drive, stop=stop))
        added.append((*path, "drive"))
    return site, added, known


def _renamed_address(address: str, words: dict[str, str]) -> str:
    device, _, name = address.partition("/")
    return f"{words.get(device, device)}/{name}" if name else address


def _is_undriven(site: Site, topic: str) -> bool:
    return all(
        device.drive is None or device.drive.topic != topic for device in site.devices.values()
    )


def _without_open_ends(site: Site, added: list[Path]) -> Site:
    """Clear what the new driving refers to and the merge has put elsewhere."""
    for path in [added_path for added_path in added if added_path[-1] == "drive"]:
        prefix = ".".join(("$", *path))
        for finding in check_site(site):
            if not finding.where.startswith(prefix):
                continue
            key = finding.where.removeprefix(f"{prefix}.")
            if key in ("picture", "position"):
                site = with_value(site, (*path, key), "")
            elif key.startswith("stop.confirmed_by"):
                site = with_value(site, (*path, "stop", "confirmed_by"), ())
    return site


def _identities_of(device: Device) -> list[tuple[str, ...]]:
    things = (*device.signals.values(), *device.streams.values(), *device.commands.values())
    return [_identity_of(thing) for thing in things]


def _identity_of(thing: object) -> tuple[str, ...]:
    """Say what is read or called, whatever it is named here."""
    # Commands have no source; they are known by what they call.
    source: Source | None = getattr(thing, "source", None)
    if source is None:
        command: Command = thing  # type: ignore[assignment]
        return ("command", command.kind, command.target)
    kind = type(thing).__name__
    # As texts, for a source may hold dicts, which no set can hold.
    read = (str(part) for part in msgspec.structs.astuple(source))
    return (kind, type(source).__name__, *read)
