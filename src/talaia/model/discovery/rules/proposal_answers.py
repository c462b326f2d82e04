"""What a robot's owner says to a proposal: what is wanted, its names and units, and STOP. Pure.

The terminal, the page of `talaia init --web` and the configurator ask by the sentences here, and
make of the answers one description by `answered_proposal`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import msgspec

from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.rules.robot_board import robot_boards
from talaia.model.discovery.rules.stop_choice import StopAnswers

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.discovery.generate_description import DescriptionProposal
    from talaia.model.discovery.probe_report import Found
    from talaia.model.site import Device, Drive, Signal

__all__ = ["ProposalAnswers", "answered_proposal", "answers_problems"]


class ProposalAnswers(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """All that was said. A path is ``device``, or ``device/part/word``: ``base/signals/speed``.

    Attributes:
        name: what people call the robot; empty leaves it.
        unwanted: paths; ``device/drive`` is the driving of a device.
        names: what people call it, by path.
        units: of signals, by path.
        stop_topic: is true while the robot is stopped; empty for none.
        confirmed_by: addresses of signals that are 0 when it stands, and are not when it moves.

    """

    name: str = ""
    unwanted: frozenset[str] = frozenset()
    names: dict[str, str] = {}
    units: dict[str, str] = {}
    stop_topic: str = ""
    confirmed_by: tuple[str, ...] = ()


_Described = TypeVar("_Described", bound=msgspec.Struct)
_PARTS = ("signals", "streams", "commands")


def answered_proposal(
    found: Found, named: tuple[str, str, str], answers: ProposalAnswers
) -> DescriptionProposal:
    """Make the description that the answers ask for.

    Args:
        found: what a probe saw.
        named: short name of the site, what people call it, its time zone.
        answers: an answer to what is not there has no effect.

    """
    made = propose_description(
        found,
        *named,
        answers=StopAnswers(answers.stop_topic, answers.confirmed_by),
        without=frozenset(path for path in answers.unwanted if "/" not in path),
    )
    devices = {word: _answered(word, device, answers) for word, device in made.site.devices.items()}
    kept = {
        f"{word}/{name}"
        for word, device in devices.items()
        for name in (*device.signals, *device.streams)
    }
    devices = {
        word: device
        if device.drive is None
        else msgspec.structs.replace(device, drive=_drive_by(device.drive, kept))
        for word, device in devices.items()
    }
    site = msgspec.structs.replace(
        made.site,
        name=answers.name or made.site.name,
        devices=devices,
        boards=robot_boards(found, devices),
    )
    left_out = [f"{path}: not wanted" for path in sorted(answers.unwanted) if "/" in path]
    return made._replace(site=site, left_out=(*made.left_out, *left_out))


def answers_problems(made: DescriptionProposal) -> list[str]:
    """Say what `talaia check` would refuse of it, each with what to do."""
    return [str(finding) for finding in check_site(made.site)]


def _answered(word: str, device: Device, answers: ProposalAnswers) -> Device:
    parts = {part: _wanted(f"{word}/{part}", getattr(device, part), answers) for part in _PARTS}
    signals = {
        name: _measured(signal, answers.units.get(f"{word}/signals/{name}"))
        for name, signal in parts["signals"].items()
    }
    undriven = f"{word}/drive" in answers.unwanted
    return msgspec.structs.replace(
        device,
        name=answers.names.get(word, device.name),
        drive=None if undriven else device.drive,
        **{**parts, "signals": signals},
    )


def _wanted(
    above: str, described: Mapping[str, _Described], answers: ProposalAnswers
) -> dict[str, _Described]:
    wanted: dict[str, _Described] = {}
    for word, one in described.items():
        path = f"{above}/{word}"
        if path not in answers.unwanted:
            name = answers.names.get(path)
            wanted[word] = one if name is None else msgspec.structs.replace(one, name=name)
    return wanted


def _measured(signal: Signal, unit: str | None) -> Signal:
    return signal if unit is None else msgspec.structs.replace(signal, unit=unit)


def _drive_by(drive: Drive, kept: set[str]) -> Drive:
    """Leave out of driving what is not wanted; a joint without its position has no ends."""
    joints = {
        name: joint
        if joint.position in kept
        else msgspec.structs.replace(joint, position="", minimum=None, maximum=None)
        for name, joint in drive.joints.items()
    }
    stop = msgspec.structs.replace(
        drive.stop, confirmed_by=tuple(one for one in drive.stop.confirmed_by if one in kept)
    )
    return msgspec.structs.replace(
        drive,
        joints=joints,
        stop=stop,
        picture=drive.picture if drive.picture in kept else "",
        position=drive.position if drive.position in kept else "",
    )
