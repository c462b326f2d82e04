"""Cross-checks of enclosures and of where telescopes may point; part of `check`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.check_interlocks import step_findings
from talaia.model.errors import UnknownWord
from talaia.model.site import ArgumentType, SignalType
from talaia.model.words import Finding, above, at_least, id_fits, name_fits

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.enclosure import Enclosure, Follow, Pointing, Sighting
    from talaia.model.site import Device, Site

__all__ = ["enclosure_findings"]


def enclosure_findings(site: Site) -> Iterator[Finding]:
    """List what does not fit in a site's place, enclosures and pointing limits."""
    if site.place is not None:
        yield from _within("$.place.latitude", site.place.latitude, -90, 90)
        yield from _within("$.place.longitude", site.place.longitude, -180, 360)
        yield from _within("$.place.elevation", site.place.elevation, -500, 9000)
    for name, enclosure in site.enclosures.items():
        where = f"$.enclosures.{name}"
        yield from id_fits(where, name)
        yield from _enclosure(site, where, enclosure)
    for device_id, device in site.devices.items():
        if device.pointing is not None:
            where = f"$.devices.{device_id}.pointing"
            yield from _pointing(site, where, device, device.pointing)


def _within(where: str, value: float, low: float, high: float) -> Iterator[Finding]:
    # Written so that NaN is found as well.
    if not low <= value <= high:
        yield Finding(where, f"expected {low} to {high}, found {value}")


def _enclosure(site: Site, where: str, enclosure: Enclosure) -> Iterator[Finding]:
    yield from name_fits(f"{where}.name", enclosure.name)
    if not enclosure.unsafe:
        yield Finding(f"{where}.unsafe", "nothing would ever close it", "name an interlock")
    for index, name in enumerate(enclosure.unsafe):
        if name not in site.interlocks:
            at = f"{where}.unsafe[{index}]"
            yield _of(UnknownWord(at, "interlock", name, list(site.interlocks)))
    if not enclosure.closed:
        yield Finding(f"{where}.closed", "nothing says when it is closed", "name its end switch")
    for key in ("closed", "moving"):
        for index, sighting in enumerate(getattr(enclosure, key)):
            yield from _sighting(site, f"{where}.{key}[{index}]", sighting)
    yield from step_findings(site, f"{where}.close", enclosure.close)
    for index, step in enumerate(enclosure.abort):
        yield from step_findings(site, f"{where}.abort[{index}]", step)
    if enclosure.stop and enclosure.stop not in _commands(site):
        yield _of(UnknownWord(f"{where}.stop", "command", enclosure.stop, _commands(site)))
    if enclosure.park is not None:
        yield from step_findings(site, f"{where}.park", enclosure.park)
        if enclosure.parked is None:
            yield Finding(f"{where}.parked", "nothing says when the telescope is parked")
    if enclosure.parked is not None:
        yield from _sighting(site, f"{where}.parked", enclosure.parked)
    for key in ("mount_within", "move_within", "alarm_every"):
        yield from above(f"{where}.{key}", getattr(enclosure, key), 0)
    yield from at_least(f"{where}.retries", enclosure.retries, 0)
    if enclosure.follow is not None:
        yield from _follow(site, f"{where}.follow", enclosure.follow)


def _follow(site: Site, where: str, follow: Follow) -> Iterator[Finding]:
    for key in ("target", "azimuth"):
        yield from _signal(site, f"{where}.{key}", getattr(follow, key), SignalType.NUMBER)
    yield from _sighting(site, f"{where}.when", follow.when)
    for key in ("moving", "open"):
        sighting: Sighting | None = getattr(follow, key)
        if sighting is not None:
            yield from _sighting(site, f"{where}.{key}", sighting)
    for index, name in enumerate(follow.before):
        if name not in _commands(site):
            at = f"{where}.before[{index}]"
            yield _of(UnknownWord(at, "command", name, _commands(site)))
    yield from above(f"{where}.wait", follow.wait, 0)
    device_id, _, command_id = follow.command.partition("/")
    if follow.command not in _commands(site):
        yield _of(UnknownWord(f"{where}.command", "command", follow.command, _commands(site)))
    else:
        arguments = site.devices[device_id].commands[command_id].arguments
        if follow.argument not in arguments:
            at = f"{where}.argument"
            yield _of(UnknownWord(at, "argument", follow.argument, list(arguments)))
    yield from above(f"{where}.within", follow.within, 0)
    yield from at_least(f"{where}.every", follow.every, 1)


def _pointing(site: Site, where: str, device: Device, pointing: Pointing) -> Iterator[Finding]:
    if site.place is None:
        yield Finding(where, "it is not known where the site is", "write place: at the top")
    yield from _within(f"{where}.horizon", pointing.horizon, -90, 90)
    yield from _within(f"{where}.sun", pointing.sun, 0, 180)
    for name, names in pointing.commands.items():
        at = f"{where}.commands.{name}"
        command = device.commands.get(name)
        if command is None:
            yield _of(UnknownWord(at, "command", name, list(device.commands)))
            continue
        pairs = [(names.ra, names.dec), (names.alt, names.az)]
        given = [pair for pair in pairs if any(pair)]
        if len(given) != 1 or not all(given[0]):
            yield Finding(at, "expected ra and dec, or alt and az", "name both arguments")
            continue
        for argument in given[0]:
            described = command.arguments.get(argument)
            if described is None or described.type is not ArgumentType.NUMBER:
                yield _of(UnknownWord(at, "number argument", argument, list(command.arguments)))


def _sighting(site: Site, where: str, sighting: Sighting) -> Iterator[Finding]:
    found = [*_signal(site, f"{where}.signal", sighting.signal, SignalType.STATE)]
    yield from found
    if found:
        return
    device_id, _, signal_id = sighting.signal.partition("/")
    states = site.devices[device_id].signals[signal_id].states
    if not sighting.is_one_of:
        yield Finding(f"{where}.is", "no state is named", f"one of {', '.join(states)}")
    for index, word in enumerate(sighting.is_one_of):
        if word not in states:
            yield _of(UnknownWord(f"{where}.is[{index}]", "state", word, states))


def _signal(site: Site, where: str, address: str, kind: SignalType) -> Iterator[Finding]:
    known = [
        f"{device_id}/{signal_id}"
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
        if signal.type is kind
    ]
    if address not in known:
        yield _of(UnknownWord(where, f"{kind} signal", address, known))


def _commands(site: Site) -> list[str]:
    return [
        f"{device_id}/{command_id}"
        for device_id, device in site.devices.items()
        for command_id in device.commands
    ]


def _of(error: UnknownWord) -> Finding:
    return Finding(error.where, error.problem, error.remedy)
