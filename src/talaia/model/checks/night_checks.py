"""Cross-checks of how a site observes by itself; part of `check`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.checks.enclosure_checks import sighting_findings
from talaia.model.checks.identifiers import Finding, at_least, check_above, finding_of
from talaia.model.checks.interlock_checks import step_findings
from talaia.model.errors import UnknownWord
from talaia.model.site import ArgumentType, SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.night_frames import (
        FrameCommand,
        NightField,
        NightFlats,
        SettingCommand,
    )
    from talaia.model.night_section import NightSection
    from talaia.model.site import Command, Site

__all__ = ["night_findings"]

# Civil dusk: above it the Sun may shine into an open roof.
_LIGHT = -6.0
# A picture for focus is exposed so many times as long at the most.
_MOST_LONGER = 100.0
# A picture that shows more is an all-sky camera's, on no tangent plane.
_WIDEST = 60.0
_NUMBERS = frozenset({ArgumentType.NUMBER, ArgumentType.INTEGER})


def night_findings(site: Site) -> Iterator[Finding]:
    """List what does not fit in a site's ``night``."""
    night = site.night
    if night is None:
        return
    if site.place is None:
        yield Finding("$.night", "nobody knows where the Sun stands", "write the site's place")
    rule = site.enclosures.get(night.enclosure)
    if rule is None:
        word = UnknownWord("$.night.enclosure", "enclosure", night.enclosure, site.enclosures)
        yield finding_of(word)
    elif rule.park is None or rule.parked is None:
        problem = f"nothing says how the telescope under {night.enclosure} parks, or that it has"
        remedy = f"write park and parked in enclosures.{night.enclosure}"
        yield Finding("$.night.enclosure", problem, remedy)
    yield from sighting_findings(site, "$.night.opened", night.opened)
    if night.tracking is not None:
        yield from sighting_findings(site, "$.night.tracking", night.tracking)
    elif night.track is not None:
        problem = "nothing says whether it tracks"
        yield Finding("$.night.track", problem, "write tracking, by what the mount says")
    for key, step in night.steps().items():
        yield from step_findings(site, f"$.night.{key}", step)
    yield from _commands_fit(site, night)
    yield from _guarded_fits(site, night)
    for key in ("clouds", "seeing"):
        yield from _signal_fits(site, f"$.night.{key}", getattr(night, key))
    yield from _star_parts_fit(site, night)
    yield from _sun_fits(night)
    yield from at_least("$.night.step_tries", night.step_tries, 1)
    yield from at_least("$.night.failure_limit", night.failure_limit, 1)
    yield from at_least("$.night.hand_over", night.hand_over, 0)
    yield from _times_fit(night)


def _commands_fit(site: Site, night: NightSection) -> Iterator[Finding]:
    slew, where = night.slew, "$.night.slew"
    yield from _arguments_fit(site, where, slew.command, {"ra": slew.ra, "dec": slew.dec})
    if night.point is not None:
        point, where = night.point, "$.night.point"
        angles = {"altitude": point.altitude, "azimuth": point.azimuth}
        yield from _arguments_fit(site, where, point.command, angles)
    yield from at_least("$.night.flip_after", night.flip_after, 0)
    yield from _frame_fits(site, "$.night.light", night.light)
    if night.darks is not None:
        yield from _frame_fits(site, "$.night.darks.command", night.darks.command)
        yield from at_least("$.night.darks.count", night.darks.count, 1)
        for index, exposure in enumerate(night.darks.exposures):
            yield from at_least(f"$.night.darks.exposures[{index}]", exposure, 0)
    if night.bias is not None:
        yield from _frame_fits(site, "$.night.bias", night.bias, timed=False)
    yield from _flats_fit(site, night.flats)
    if night.filter is not None:
        where = "$.night.filter"
        others = {"argument": night.filter.argument}
        yield from _arguments_fit(site, where, night.filter.command, {}, others=others)
        if not night.filter.filters:
            yield Finding(f"{where}.filters", "no filter has a name", "name each, with its value")
        for name, factor in night.filter.longer.items():
            if name not in night.filter.filters:
                known = ", ".join(night.filter.filters)
                yield Finding(
                    f"{where}.longer.{name}", "no filter has this name", f"one of {known}"
                )
            elif not 0.0 < factor <= _MOST_LONGER:
                yield Finding(f"{where}.longer.{name}", f"expected over 0, to {_MOST_LONGER:g}")
    for key in ("binning", "gain"):
        yield from _setting_fits(site, f"$.night.{key}", getattr(night, key))
    yield from _field_fits(site, night.field)


def _field_fits(site: Site, field: NightField | None) -> Iterator[Finding]:
    if field is None:
        return
    where = "$.night.field"
    for key in ("width", "height"):
        size = getattr(field, key)
        # Written so that NaN is found as well.
        if not 0 < size <= _WIDEST:
            problem = f"expected over 0, to {_WIDEST:g} °, found {size:g}"
            yield Finding(f"{where}.{key}", problem, "chip by focal length, times 57.3")
    if not 0 <= field.position_angle < 360:
        problem = f"expected 0 to 360 °, found {field.position_angle:g}"
        yield Finding(f"{where}.position_angle", problem, "from north through east")
    rotator, where = field.rotator, f"{where}.rotator"
    if rotator is not None:
        yield from _arguments_fit(site, where, rotator.command, {"argument": rotator.argument})
        if not rotator.argument:
            yield Finding(f"{where}.argument", "nothing takes the angle", "name its argument")
        yield from _signal_fits(site, f"{where}.reading", rotator.reading)
        if not -360 <= rotator.zero <= 360:
            problem = f"expected -360 to 360 °, found {rotator.zero:g}"
            yield Finding(f"{where}.zero", problem)
        yield from check_above(f"{where}.within", rotator.within, 0)


def _flats_fit(site: Site, flats: NightFlats | None) -> Iterator[Finding]:
    if flats is None:
        return
    where = "$.night.flats"
    yield from _frame_fits(site, f"{where}.command", flats.command)
    # Written so that NaN is found as well.
    if not 0 <= flats.pedestal < flats.least < flats.level < flats.most:
        problem = (
            "expected 0 <= pedestal < least < level < most, found"
            f" {flats.pedestal:g}, {flats.least:g}, {flats.level:g}, {flats.most:g}"
        )
        yield Finding(where, problem)
    if not 0 < flats.shortest <= flats.longest:
        problem = f"expected 0 < shortest <= longest, found {flats.shortest:g}, {flats.longest:g}"
        yield Finding(where, problem)
    if not 0 < flats.altitude < 90:
        yield Finding(f"{where}.altitude", f"expected 0 to 90 °, found {flats.altitude:g}")
    yield from at_least(f"{where}.tries", flats.tries, 1)


def _setting_fits(site: Site, where: str, rule: SettingCommand | None) -> Iterator[Finding]:
    if rule is None:
        return
    numbers = {f"arguments[{index}]": name for index, name in enumerate(rule.arguments)}
    yield from _arguments_fit(site, where, rule.command, numbers)
    if not rule.arguments:
        yield Finding(f"{where}.arguments", "nothing takes the number", "name its argument")
    yield from _signal_fits(site, f"{where}.reading", rule.reading)
    yield from check_above(f"{where}.within", rule.within, 0)


def _frame_fits(
    site: Site, where: str, frame: FrameCommand, *, timed: bool = True
) -> Iterator[Finding]:
    numbers = {key: getattr(frame, key) for key in ("seconds", "binning", "gain")}
    # A bias has no length: its command may know the shortest that its camera takes.
    if timed and not frame.seconds:
        yield Finding(f"{where}.seconds", "nothing says how long it exposes", "name its argument")
    others = {"target": frame.target, **{f"args.{key}": key for key in frame.args}}
    yield from _arguments_fit(site, where, frame.command, numbers, others=others)


def _arguments_fit(
    site: Site,
    where: str,
    address: str,
    numbers: dict[str, str],
    *,
    others: dict[str, str] | None = None,
) -> Iterator[Finding]:
    command = _find_command(site, address)
    if command is None:
        known = _command_addresses(site)
        yield finding_of(UnknownWord(f"{where}.command", "command", address, known))
        return
    for key, name in {**numbers, **(others or {})}.items():
        if not name:
            continue
        argument = command.arguments.get(name)
        if argument is None:
            word = UnknownWord(f"{where}.{key}", "argument", name, list(command.arguments))
            yield finding_of(word)
        elif key in numbers and argument.type not in _NUMBERS:
            yield Finding(f"{where}.{key}", f"{name} of {address} is not a number")


def _guarded_fits(site: Site, night: NightSection) -> Iterator[Finding]:
    """A roof that nothing keeps from opening must not be opened by a machine."""
    rule = site.enclosures.get(night.enclosure)
    if rule is None:
        return
    refused = {
        word
        for name in rule.unsafe
        if name in site.interlocks
        for word in site.interlocks[name].refuse
    }
    for key, command in (("open", night.open.command), ("unpark", night.unpark.command)):
        device = command.partition("/")[0]
        if command not in refused and f"{device}/*" not in refused:
            problem = f"no interlock of {night.enclosure} ever refuses {command}"
            yield Finding(f"$.night.{key}.command", problem, "name it in their refuse")
    if night.link_loss == "park" and not any(device.link_loss for device in site.devices.values()):
        problem = "no device says what to do when the hub is away"
        yield Finding("$.night.link_loss", problem, "write link_loss of the roof's device")


def _signal_fits(site: Site, where: str, address: str) -> Iterator[Finding]:
    if not address:
        return
    signal = site.signal(address)
    if signal is None:
        known = [f"{name}/{key}" for name, device in site.devices.items() for key in device.signals]
        yield finding_of(UnknownWord(where, "signal", address, known))
    elif signal.type is not SignalType.NUMBER:
        yield Finding(where, f"{address} is not a number")


def _star_parts_fit(site: Site, night: NightSection) -> Iterator[Finding]:
    where, focuser = "$.night.focuser", night.focuser
    if focuser is not None:
        numbers = {"argument": focuser.argument}
        yield from _arguments_fit(site, where, focuser.command, numbers)
        if not focuser.position:
            yield Finding(f"{where}.position", "nothing says where it stands", "name its signal")
        yield from _signal_fits(site, f"{where}.position", focuser.position)
        yield from _signal_fits(site, f"{where}.temperature", focuser.temperature)
        yield from check_above(f"{where}.every", focuser.every, 0)
        yield from check_above(f"{where}.degrees", focuser.degrees, 0)
        yield from check_above(f"{where}.seconds", focuser.seconds, 0)
    if night.centring is not None:
        yield from check_above("$.night.centring.seconds", night.centring.seconds, 0)
    if night.guider is not None and not 0 < night.guider.port < 65_536:
        yield Finding("$.night.guider.port", f"expected 1 to 65535, found {night.guider.port}")


def _sun_fits(night: NightSection) -> Iterator[Finding]:
    sun = night.sun
    # Written so that NaN is found as well.
    if not -90 <= sun.observing <= sun.opening <= sun.closing <= _LIGHT:
        problem = (
            f"expected observing <= opening <= closing <= {_LIGHT:g} °, found"
            f" {sun.observing:g}, {sun.opening:g}, {sun.closing:g}"
        )
        yield Finding("$.night.sun", problem)
    if not sun.opening <= sun.calibrating <= 90:
        problem = f"expected opening to 90 °, found {sun.calibrating:g}"
        yield Finding("$.night.sun.calibrating", problem)


def _times_fit(night: NightSection) -> Iterator[Finding]:
    times, where = night.times, "$.night.times"
    for key in ("settle", "acquire", "filter_change", "readout", "unpark", "meridian_flip"):
        yield from at_least(f"{where}.{key}", getattr(times, key), 0)
    for key in ("focus_run", "dome_rate", "rotator_rate"):
        yield from at_least(f"{where}.{key}", getattr(times, key), 0)
    yield from check_above(f"{where}.slew_rate", times.slew_rate, 0)
    for key, values in (
        ("horizon", [times.horizon]),
        ("horizon_mask", [high for _, high in times.horizon_mask]),
    ):
        for value in values:
            if not 0 <= value <= 90:
                yield Finding(f"{where}.{key}", f"expected 0 to 90 °, found {value}")


def _find_command(site: Site, address: str) -> Command | None:
    name, _, command = address.partition("/")
    device = site.devices.get(name)
    return None if device is None else device.commands.get(command)


def _command_addresses(site: Site) -> list[str]:
    return [f"{name}/{key}" for name, device in site.devices.items() for key in device.commands]
