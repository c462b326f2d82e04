"""Cross-checks of enclosures and of where telescopes may point; part of `check`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import (
    Finding,
    at_least,
    check_above,
    finding_of,
    id_fits,
    name_fits,
)
from talaia.model.checks.interlock_checks import step_findings
from talaia.model.checks.outlet_checks import outlet_findings
from talaia.model.errors import UnknownWord
from talaia.model.interlocks.interlock import Step
from talaia.model.site import ArgumentType, SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.interlocks.enclosure import Enclosure, Follow, Heartbeat, Pointing, Sighting
    from talaia.model.site import Device, Site

__all__ = ["enclosure_findings", "sighting_findings"]


def enclosure_findings(site: Site) -> Iterator[Finding]:
    """List what does not fit in a site's place, enclosures and pointing limits."""
    if site.place is not None:
        yield from _check_range("$.place.latitude", site.place.latitude, -90, 90)
        # People count east to 180° or to 360°.
        yield from _check_range("$.place.longitude", site.place.longitude, -180, 360)
        # From the lowest shore to the highest summit.
        yield from _check_range("$.place.elevation", site.place.elevation, -500, 9000)
    for name, enclosure in site.enclosures.items():
        where = f"$.enclosures.{name}"
        yield from id_fits(where, name)
        yield from _check_enclosure(site, where, enclosure)
    yield from outlet_findings(site)
    for device_id, device in site.devices.items():
        if device.pointing is not None:
            where = f"$.devices.{device_id}.pointing"
            yield from _check_pointing(site, where, device, device.pointing)


def _check_range(where: str, value: float, low: float, high: float) -> Iterator[Finding]:
    # Written so that NaN is found as well.
    if not low <= value <= high:
        yield Finding(where, f"expected {low} to {high}, found {value}")


def _check_enclosure(site: Site, where: str, enclosure: Enclosure) -> Iterator[Finding]:
    yield from name_fits(f"{where}.name", enclosure.name)
    if not enclosure.unsafe:
        yield Finding(f"{where}.unsafe", "nothing would ever close it", "name an interlock")
    for index, name in enumerate(enclosure.unsafe):
        if name not in site.interlocks:
            at = f"{where}.unsafe[{index}]"
            yield finding_of(UnknownWord(at, "interlock", name, list(site.interlocks)))
    if not enclosure.closed:
        yield Finding(f"{where}.closed", "nothing says when it is closed", "name its end switch")
    for key in ("closed", "moving", "opening"):
        for index, sighting in enumerate(getattr(enclosure, key)):
            yield from sighting_findings(site, f"{where}.{key}[{index}]", sighting)
    yield from step_findings(site, f"{where}.close", enclosure.close)
    for index, step in enumerate(enclosure.abort):
        yield from step_findings(site, f"{where}.abort[{index}]", step)
    if enclosure.stop and enclosure.stop not in _command_addresses(site):
        yield finding_of(
            UnknownWord(f"{where}.stop", "command", enclosure.stop, _command_addresses(site))
        )
    if enclosure.park is not None:
        yield from step_findings(site, f"{where}.park", enclosure.park)
        # Without it a park would be waited for in vain, each time.
        if enclosure.parked is None:
            yield Finding(f"{where}.parked", "nothing says when the telescope is parked")
    if enclosure.parked is not None:
        yield from sighting_findings(site, f"{where}.parked", enclosure.parked)
    for key in ("mount_within", "move_within", "alarm_every"):
        yield from check_above(f"{where}.{key}", getattr(enclosure, key), 0)
    yield from at_least(f"{where}.retries", enclosure.retries, 0)
    if enclosure.heartbeat is not None:
        yield from _heartbeat(site, f"{where}.heartbeat", enclosure.heartbeat)
    # Less would take a short pause of the gateway for its death.
    if enclosure.watchdog_after and not 2 <= enclosure.watchdog_after <= 3600:
        at, found = f"{where}.watchdog_after", enclosure.watchdog_after
        yield Finding(at, f"expected 2 to 3600 s, or 0 for never, found {found:g}")
    yield from _check_parts(site, where, enclosure)
    if enclosure.follow is not None:
        yield from _check_follow(site, f"{where}.follow", enclosure.follow)


def _heartbeat(site: Site, where: str, heartbeat: Heartbeat) -> Iterator[Finding]:
    step = Step(command=heartbeat.command, args=heartbeat.args)
    yield from step_findings(site, where, step)
    yield from at_least(f"{where}.every", heartbeat.every, 0.5)


def _check_follow(site: Site, where: str, follow: Follow) -> Iterator[Finding]:
    for key in ("target", "azimuth"):
        yield from _check_signal(site, f"{where}.{key}", getattr(follow, key), SignalType.NUMBER)
    yield from sighting_findings(site, f"{where}.when", follow.when)
    for key in ("moving", "open"):
        sighting: Sighting | None = getattr(follow, key)
        if sighting is not None:
            yield from sighting_findings(site, f"{where}.{key}", sighting)
    for index, name in enumerate(follow.before):
        if name not in _command_addresses(site):
            at = f"{where}.before[{index}]"
            yield finding_of(UnknownWord(at, "command", name, _command_addresses(site)))
    yield from check_above(f"{where}.wait", follow.wait, 0)
    device_id, _, command_id = follow.command.partition("/")
    if follow.command not in _command_addresses(site):
        yield finding_of(
            UnknownWord(f"{where}.command", "command", follow.command, _command_addresses(site))
        )
    else:
        arguments = site.devices[device_id].commands[command_id].arguments
        if follow.argument not in arguments:
            at = f"{where}.argument"
            yield finding_of(UnknownWord(at, "argument", follow.argument, list(arguments)))
    yield from check_above(f"{where}.within", follow.within, 0)
    yield from at_least(f"{where}.every", follow.every, 1)


def _check_pointing(
    site: Site, where: str, device: Device, pointing: Pointing
) -> Iterator[Finding]:
    if site.place is None:
        yield Finding(where, "it is not known where the site is", "write place: at the top")
    yield from _check_range(f"{where}.horizon", pointing.horizon, -90, 90)
    yield from _check_range(f"{where}.sun", pointing.sun, 0, 180)
    for name, names in pointing.commands.items():
        at = f"{where}.commands.{name}"
        command = device.commands.get(name)
        if command is None:
            yield finding_of(UnknownWord(at, "command", name, list(device.commands)))
            continue
        # One pair, and both of it.
        pairs = [(names.ra, names.dec), (names.alt, names.az)]
        given = [pair for pair in pairs if any(pair)]
        if len(given) != 1 or not all(given[0]):
            yield Finding(at, "expected ra and dec, or alt and az", "name both arguments")
            continue
        for argument in given[0]:
            described = command.arguments.get(argument)
            if described is None or described.type is not ArgumentType.NUMBER:
                yield finding_of(
                    UnknownWord(at, "number argument", argument, list(command.arguments))
                )


def sighting_findings(site: Site, where: str, sighting: Sighting) -> Iterator[Finding]:
    """List what does not fit in what a sensor is to say."""
    signal = site.signal(sighting.signal)
    # A text or a position says neither.
    if signal is None or signal.type not in (SignalType.STATE, SignalType.NUMBER):
        known = [
            *_signal_addresses(site, SignalType.STATE),
            *_signal_addresses(site, SignalType.NUMBER),
        ]
        yield finding_of(UnknownWord(f"{where}.signal", "state or number", sighting.signal, known))
        return
    limits = [key for key in ("above", "below") if getattr(sighting, key) is not None]
    if signal.type is SignalType.NUMBER:
        if sighting.is_one_of:
            yield Finding(f"{where}.is", "a number has no states", "write above or below")
        elif not limits:
            yield Finding(where, "a number is compared with nothing", "write: below: 1")
        for key in limits:
            if not math.isfinite(getattr(sighting, key)):
                yield Finding(f"{where}.{key}", "expected a finite number")
        return
    for key in limits:
        yield Finding(f"{where}.{key}", "a state is neither above nor below", "write is")
    if not sighting.is_one_of:
        states = ", ".join(signal.states)
        yield Finding(f"{where}.is", "no state is named", f"one of {states}")
    for index, word in enumerate(sighting.is_one_of):
        if word not in signal.states:
            yield finding_of(UnknownWord(f"{where}.is[{index}]", "state", word, signal.states))


def _check_parts(site: Site, where: str, enclosure: Enclosure) -> Iterator[Finding]:
    """List what is wrong with segments, flap, position, and what it is said to be able to do."""
    ways = {f"{where}.segments.{key}": segment for key, segment in enclosure.segments.items()}
    if enclosure.flap is not None:
        ways[f"{where}.flap"] = enclosure.flap
    for at, part in ways.items():
        yield from name_fits(f"{at}.name", part.name)
        if not part.closed:
            yield Finding(f"{at}.closed", "nothing says when it is closed", "name its end switch")
        for index, sighting in enumerate(part.closed):
            yield from sighting_findings(site, f"{at}.closed[{index}]", sighting)
        if part.position:
            yield from _check_signal(site, f"{at}.position", part.position, SignalType.NUMBER)
        if part.close is not None:
            yield from step_findings(site, f"{at}.close", part.close)
    for key in enclosure.segments:
        yield from id_fits(f"{where}.segments.{key}", key)
    # `Enclosure.parts` gives it that name, and one of the two would be lost.
    if "flap" in enclosure.segments:
        yield Finding(f"{where}.segments.flap", "a flap is no segment", "write it as flap:")
    if enclosure.position:
        yield from _check_signal(site, f"{where}.position", enclosure.position, SignalType.NUMBER)
    yield from at_least(f"{where}.disagree_after", enclosure.disagree_after, 0)
    yield from _check_capabilities(f"{where}.capabilities", enclosure)


def _check_capabilities(where: str, enclosure: Enclosure) -> Iterator[Finding]:
    said, segments = enclosure.capabilities, len(enclosure.segments)
    if said is None:
        return
    if said.can_rotate is False and enclosure.follow is not None:
        yield Finding(
            f"{where}.can_rotate", "it follows the telescope, so it turns", "leave it out"
        )
    if said.has_flap is True and enclosure.flap is None:
        yield Finding(f"{where}.has_flap", "nothing says when the flap is closed", "write flap:")
    if said.has_flap is False and enclosure.flap is not None:
        yield Finding(f"{where}.has_flap", "its flap is described", "leave it out")
    # A roof without segments is one part.
    if said.segments is not None and said.segments != max(1, segments):
        problem = f"expected {max(1, segments)}, as described under segments, found {said.segments}"
        yield Finding(f"{where}.segments", problem, "describe each, with its end switch")


def _check_signal(site: Site, where: str, address: str, kind: SignalType) -> Iterator[Finding]:
    known = _signal_addresses(site, kind)
    if address not in known:
        yield finding_of(UnknownWord(where, f"{kind} signal", address, known))


def _signal_addresses(site: Site, kind: SignalType) -> list[str]:
    return [
        f"{device_id}/{signal_id}"
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
        if signal.type is kind
    ]


def _command_addresses(site: Site) -> list[str]:
    return [
        f"{device_id}/{command_id}"
        for device_id, device in site.devices.items()
        for command_id in device.commands
    ]
