"""Cross-checks of a description that has the right shape; returns findings, raises nothing.

Long, because what must fit together is listed in one place.
"""

from __future__ import annotations

import math
from difflib import get_close_matches
from typing import TYPE_CHECKING

from talaia.model.boards.board_checks import boards_findings
from talaia.model.checks.alarm_checks import alarms_findings
from talaia.model.checks.anomaly_checks import anomaly_findings, budget_findings, group_findings
from talaia.model.checks.connection_checks import (
    NO_CONNECTION,
    connection_findings,
    frames_findings,
    link_of,
)
from talaia.model.checks.derivation_checks import derivation_findings
from talaia.model.checks.detection_checks import (
    blur_fits,
    count_fits,
    detect_fits,
    hub_sight_findings,
    lane_fits,
    models_findings,
    sky_fits,
)
from talaia.model.checks.enclosure_checks import enclosure_findings
from talaia.model.checks.extension_rules import NO_RULES, extension_findings
from talaia.model.checks.identifiers import (
    FIELD,
    Finding,
    at_least,
    check_above,
    field_fits,
    id_fits,
    name_fits,
    range_fits,
    topic_fits,
)
from talaia.model.checks.interlock_checks import interlock_findings
from talaia.model.checks.night_checks import night_findings
from talaia.model.checks.role_checks import role_findings
from talaia.model.checks.topic_checks import topics_findings
from talaia.model.checks.unit_checks import shown_units_findings, unit_fits
from talaia.model.checks.validity_checks import validity_fits
from talaia.model.connection import (
    DerivedSource,
    DetectionSource,
    Ros1Connection,
    Ros2Connection,
    rules_of,
)
from talaia.model.derived_signals import with_counts
from talaia.model.driving.drive_checks import drive_findings
from talaia.model.errors import DescriptionError
from talaia.model.list_texts import LIST_TYPES, parse_list
from talaia.model.maps.map_checks import map_findings, tag_findings
from talaia.model.picture_models.model_checks import picture_models_fit
from talaia.model.renames import former_findings
from talaia.model.site import ArgumentType, CommandKind, SignalType, Site
from talaia.model.twins.twin_checks import twin_findings
from talaia.model.units.time_zones import known_zones
from talaia.model.yaml_text.value_remedies import remedy_of_value, words_of_value
from talaia.model.yaml_text.version import FORMAT

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.checks.extension_rules import ExtensionRules
    from talaia.model.recording import Recording
    from talaia.model.site import Argument, Command, Device, Signal, Stream

__all__ = ["Finding", "check_site", "raise_first"]

# A channel's index on the wire has 16 bits; see `wire.columns`.
_MAX_CHANNELS = 60_000


def check_site(site: Site, rules: ExtensionRules = NO_RULES) -> list[Finding]:
    """List all that does not fit together in ``site``; an empty list means it can run.

    Args:
        site: the description.
        rules: what extensions that are installed here ask for; see `ExtensionRules`.

    """
    # Counts are put in first: alarms and interlocks may name them.
    found = [*_check_whole_site(site, with_counts(site)), *extension_findings(site, rules)]
    # What the whole site lacks is told once, not at each of its devices.
    first = next((one for one in found if one.problem == NO_CONNECTION), None)
    return [one for one in found if one.problem != NO_CONNECTION or one is first]


def raise_first(site: Site, rules: ExtensionRules = NO_RULES) -> Site:
    """Give ``site`` back when it can run.

    Raises:
        DescriptionError: the first finding, with the number of the others.

    """
    findings = check_site(site, rules)
    if not findings:
        return site
    first = findings[0]
    more = f" (and {len(findings) - 1} more: run talaia check)" if len(findings) > 1 else ""
    raise DescriptionError(first.where, first.problem, first.remedy + more)


def _check_whole_site(site: Site, whole: Site) -> Iterator[Finding]:
    """Check ``site``; what may refer to the signals of what is seen has them from ``whole``."""
    if site.talaia != FORMAT:
        problem = f"expected the format version {FORMAT}, found {site.talaia}"
        yield Finding("$.talaia", problem, f"write: talaia: {FORMAT}")
    yield from id_fits("$.site", site.site)
    yield from name_fits("$.name", site.name)
    if site.zone not in known_zones():
        yield _unknown_zone(site.zone)
    yield from shown_units_findings("$.shown_units", site.shown_units)
    yield from connection_findings(site)
    # A connection that discovers makes its devices itself.
    if not site.devices and not any(
        getattr(link, "discover", False) for link in site.links().values()
    ):
        yield Finding("$.devices", "there is no device", "describe at least one")
    if len(whole.channels()) > _MAX_CHANNELS:
        yield Finding("$.devices", f"more than {_MAX_CHANNELS} channels at one site", "split it")
    for device_id, device in site.devices.items():
        where = f"$.devices.{device_id}"
        yield from id_fits(where, device_id)
        yield from _check_device(whole, where, device)
    yield from derivation_findings(whole)
    yield from models_findings(site)
    yield from interlock_findings(whole)
    yield from enclosure_findings(whole)
    yield from night_findings(whole)
    yield from hub_sight_findings(whole)
    yield from former_findings(whole)
    yield from group_findings(whole)
    yield from budget_findings(whole)
    yield from alarms_findings(whole)
    yield from topics_findings(site)
    yield from boards_findings(site)
    yield from map_findings(site)
    yield from tag_findings(site)
    yield from twin_findings(site)
    if site.recording is not None:
        yield from _check_recording(site, site.recording)


def _check_recording(site: Site, recording: Recording) -> Iterator[Finding]:
    where = "$.recording"
    ros = Ros2Connection | Ros1Connection
    streams = {f"{name}/{key}" for name, device in site.devices.items() for key in device.streams}
    if not streams and not any(isinstance(link, ros) for link in site.links().values()):
        yield Finding(where, "only topics of ROS and cameras are recorded", "add: ros2: {}")
    for index, camera in enumerate(recording.cameras):
        if camera not in streams:
            known = ", ".join(sorted(streams)[:5]) or "none is described"
            yield Finding(
                f"{where}.cameras[{index}]", f"there is no camera {camera!r}", f"one of: {known}"
            )
    for index, topic in enumerate(recording.topics):
        yield from topic_fits(f"{where}.topics[{index}]", topic)
    for key, low, high, unit in (
        ("before", 0, 600, "s"),
        ("after", 1, 3600, "s"),
        ("longest", 1, 86_400, "s"),
        ("ring_mb", 1, 4_000, "MB"),
        ("file_mb", 1, 100_000, "MB"),
        ("disk_mb", 1, 1_000_000, "MB"),
        ("upload", 1, 1_000_000, "kB/s"),
    ):
        found = getattr(recording, key)
        if not low <= found <= high:
            yield Finding(f"{where}.{key}", f"expected {low} to {high} {unit}, found {found}")
    if recording.file_mb > recording.disk_mb:
        yield Finding(
            f"{where}.file_mb",
            f"a file of {recording.file_mb:g} MB does not fit {recording.disk_mb:g} MB",
            "make disk_mb larger",
        )


def _unknown_zone(zone: str) -> Finding:
    """Offer the zone that was misspelt, or say how zones are called: six hundred are no help."""
    # Nearer than for other words: Barcelona is not in Europe/Berlin.
    # Nor is CEST near to EST.
    near = get_close_matches(zone, known_zones(), n=1, cutoff=0.85) if "/" in zone else []
    # In other capitals, or a city alone.
    plain = zone.replace(" ", "_").casefold()
    whole = [one for one in known_zones() if plain in (one.casefold(), _city_of(one))]
    near = whole if len(whole) == 1 else near
    remedy = "write the region and a large city of the zone, as Europe/Madrid or America/New_York"
    if near:
        remedy = f"did you mean {near[0]!r}?"
    return Finding("$.zone", f"unknown time zone {zone!r}", remedy)


def _city_of(zone: str) -> str:
    return zone.rpartition("/")[2].casefold() if "/" in zone else ""


def _check_device(site: Site, where: str, device: Device) -> Iterator[Finding]:
    yield from name_fits(f"{where}.name", device.name)
    link, problems = link_of(site, where, device)
    yield from problems
    # Without a connection nothing can be said of what is read by it: that was said above.
    rules = None if link is None else rules_of(link)
    for signal_id, signal in device.signals.items():
        yield from id_fits(f"{where}.signals.{signal_id}", signal_id)
        yield from _check_signal(f"{where}.signals.{signal_id}", signal)
        at = f"{where}.signals.{signal_id}.source"
        if isinstance(signal.source, DetectionSource):
            yield from count_fits(site, at, device, signal)
        # What is worked out is checked for the whole site at once: see `derivation_findings`.
        elif rules is not None and not isinstance(signal.source, DerivedSource):
            yield from rules.signal_findings(at, signal)
    for stream_id, stream in device.streams.items():
        at = f"{where}.streams.{stream_id}"
        yield from id_fits(at, stream_id)
        yield from _check_stream(at, stream)
        yield from detect_fits(site, f"{at}.detect", stream)
        yield from blur_fits(site, f"{at}.blur", stream)
        yield from sky_fits(f"{at}.sky", stream)
        yield from lane_fits(f"{at}.lane", stream)
        yield from picture_models_fit(site, f"{at}.models", stream)
        if rules is not None:
            yield from rules.stream_findings(f"{at}.source", stream)
    for command_id, command in device.commands.items():
        at = f"{where}.commands.{command_id}"
        yield from id_fits(at, command_id)
        yield from _check_command(at, command)
        if rules is not None:
            yield from rules.command_findings(at, command)
    yield from role_findings(where, device)
    if link is not None:
        yield from frames_findings(f"{where}.frames", device, link)
    if device.drive is not None:
        yield from drive_findings(site, f"{where}.drive", device.drive)


def _check_signal(where: str, signal: Signal) -> Iterator[Finding]:
    yield from name_fits(f"{where}.name", signal.name)
    number = signal.type is SignalType.NUMBER
    yield from anomaly_findings(where, signal.anomalies, number=number)
    yield from unit_fits(f"{where}.unit", signal.unit)
    yield from validity_fits(where, signal)
    for key in ("max_rate", "deadband", "keep", "max_age"):
        yield from at_least(f"{where}.{key}", getattr(signal, key), 0)
    if not math.isfinite(signal.scale) or signal.scale == 0:
        yield Finding(f"{where}.scale", "expected a number other than 0", "leave it out for 1")
    # -1 takes the unit's own.
    if not -1 <= signal.decimals <= 9:
        yield Finding(f"{where}.decimals", f"expected 0 to 9, found {signal.decimals}")
    if signal.type is SignalType.STATE and not signal.states:
        yield Finding(
            f"{where}.states", "a state needs its list of states", 'write: states: ["off", "on"]'
        )
    if signal.type is not SignalType.STATE and signal.states:
        yield Finding(f"{where}.states", f"a {signal.type} has no states", "write: type: state")
    if signal.type is not SignalType.NUMBER and signal.unit:
        yield Finding(f"{where}.unit", f"a {signal.type} has no unit", "leave the unit out")
    if signal.yaw_from and not FIELD.match(signal.yaw_from):
        yield Finding(f"{where}.yaw_from", f"{signal.yaw_from!r} is not the path of a field")


def _check_stream(where: str, stream: Stream) -> Iterator[Finding]:
    yield from name_fits(f"{where}.name", stream.name)
    yield from check_above(f"{where}.max_rate", stream.max_rate, 0)
    if not 1 <= stream.quality <= 95:
        yield Finding(f"{where}.quality", f"expected 1 to 95, found {stream.quality}")
    if not 0 <= stream.kbits <= 100_000:
        yield Finding(f"{where}.kbits", f"expected 0 to 100000, found {stream.kbits}")
    if stream.width < 0:
        yield Finding(f"{where}.width", f"expected 0 or more pixels, found {stream.width}")


def _check_command(where: str, command: Command) -> Iterator[Finding]:
    yield from name_fits(f"{where}.name", command.name)
    yield from at_least(f"{where}.progress_end", command.progress_end, 0)
    if command.progress:
        yield from field_fits(f"{where}.progress", command.progress)
        if command.kind is not CommandKind.ACTION:
            yield Finding(f"{where}.progress", "only an action tells its progress", "leave it out")
    yield from check_above(f"{where}.ttl", command.ttl, 0)
    yield from check_above(f"{where}.timeout", command.timeout, 0)
    for argument_id, argument in command.arguments.items():
        yield from id_fits(f"{where}.arguments.{argument_id}", argument_id)
        yield from _check_argument(f"{where}.arguments.{argument_id}", argument)
        if argument.type in LIST_TYPES and command.kind is not CommandKind.PARAMETER:
            yield Finding(
                f"{where}.arguments.{argument_id}.type",
                "only parameters of ROS nodes are lists",
                "take kind: parameter, or an argument for each item",
            )


def _check_argument(where: str, argument: Argument) -> Iterator[Finding]:
    yield from range_fits(where, argument.minimum, argument.maximum)
    yield from unit_fits(f"{where}.unit", argument.unit)
    if argument.default is None:
        return
    if argument.type in LIST_TYPES:
        problem = f"expected a list as text, found {argument.default!r}"
        found = (
            parse_list(argument.type, argument.default)
            if isinstance(argument.default, str)
            else problem
        )
        if isinstance(found, str):
            yield Finding(f"{where}.default", found)
        return
    expected: dict[ArgumentType, type | tuple[type, ...]] = {
        ArgumentType.NUMBER: (int, float),
        ArgumentType.INTEGER: int,
        ArgumentType.BOOLEAN: bool,
        ArgumentType.TEXT: str,
    }
    fits = isinstance(argument.default, expected[argument.type])
    # For Python True is an int.
    if isinstance(argument.default, bool) and argument.type is not ArgumentType.BOOLEAN:
        fits = False
    if not fits:
        value = argument.default
        # In the words of the other checks of values.
        word = {str: "str", bool: "bool", int: "int"}.get(type(value), "float")
        kind = {"number": "float", "integer": "int", "boolean": "bool"}.get(argument.type, "str")
        problem = f"expected {words_of_value(None, kind)}, found {words_of_value(value, word)}"
        yield Finding(f"{where}.default", problem, remedy_of_value([kind], value, None))
