"""Which changes of the description a gateway takes from its hub. Pure.

The file at the gateway may be changed in every way, by whoever may write it. What comes over the
link is another matter: a hub in wrong hands must not run programs beside the robot, take an
interlock away or raise a limit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.model.checks.identifiers import Finding
from talaia.model.connection import (
    DetectionSource,
    ExtensionConnection,
    ExtensionSource,
    HttpConnection,
    HttpSource,
    ProcessConnection,
    ProcessSource,
    source_as,
)
from talaia.model.derived_signals import camera_meaning
from talaia.model.maps.site_map import zone_meaning

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Device, Site

__all__ = ["forbidden_changes"]

_FILE = "change it in the gateway's own file"
_ALL = "start the gateway with --accept-changes all, or " + _FILE


def forbidden_changes(before: Site, after: Site, accepts: AcceptedChanges) -> list[Finding]:
    """List what of a change may not come from the hub; an empty list means it may."""
    if accepts is AcceptedChanges.NO:
        remedy = "start the gateway with --accept-changes readings, or " + _FILE
        return [Finding("$", "this gateway takes no changes from the hub", remedy)]
    # At every level: even with all accepted, these come from the file alone.
    findings = [*_check_always(before, after)]
    if accepts is AcceptedChanges.READINGS:
        findings += _beyond_readings(before, after)
    return findings


def _check_always(before: Site, after: Site) -> Iterator[Finding]:
    if after.site != before.site:
        yield Finding("$.site", "a site keeps its short name", f"leave it {before.site!r}")
    if after.connections != before.connections or after.ros2 != before.ros2:
        where = "$.connections" if after.connections != before.connections else "$.ros2"
        yield Finding(where, "how the robot is reached is not changed from the hub", _FILE)
    if after.object_models != before.object_models:
        # A detector is a program of this machine, too.
        problem = "which detectors run beside the robot is not changed from the hub"
        yield Finding("$.object_models", problem, _FILE)
    had = _programs_of(before)
    # By path, so that a word is compared with what stood in the same place.
    for where, words in _programs_of(after).items():
        # Words that are gone are no finding: what is not run any more harms nobody.
        if had.get(where) != words:
            yield Finding(where, "what is run beside the robot is not changed from the hub", _FILE)


def _programs_of(site: Site) -> dict[str, str]:
    """Give what runs on the gateway's machine, or is asked with its credentials, by path."""
    links = site.links()
    runs: dict[str, str] = {}
    for name, device in site.devices.items():
        link = links.get(site.connection_of(name))
        # By its connection: only these kinds do something for a signal or a command.
        if not isinstance(link, ProcessConnection | ExtensionConnection | HttpConnection):
            continue
        at = f"$.devices.{name}"
        for signal_id, signal in device.signals.items():
            if isinstance(link, ProcessConnection):
                runs[f"{at}.signals.{signal_id}.source.run"] = source_as(
                    signal.source, ProcessSource
                ).run
            elif isinstance(link, HttpConnection):
                # Of many devices a GET switches a relay.
                asked = source_as(signal.source, HttpSource).get
                runs[f"{at}.signals.{signal_id}.source.get"] = asked
            else:
                # They may name a file or a program: only the extension knows.
                # Sorted, so that another order of the same keys is no change.
                keys = msgspec.json.encode(
                    source_as(signal.source, ExtensionSource).keys, order="sorted"
                )
                runs[f"{at}.signals.{signal_id}.source.keys"] = keys.decode()
        for command_id, command in device.commands.items():
            said = msgspec.json.encode((command.target, command.fixed, command.arguments))
            runs[f"{at}.commands.{command_id}"] = said.decode()
    return runs


def _beyond_readings(before: Site, after: Site) -> Iterator[Finding]:
    for key in ("interlocks", "enclosures", "night", "recording", "place"):
        if getattr(before, key) != getattr(after, key):
            yield Finding(f"$.{key}", "only what is read may be changed from the hub", _ALL)
    for name in before.devices.keys() | after.devices.keys():
        yield from _check_device(
            f"$.devices.{name}", before.devices.get(name), after.devices.get(name)
        )
    zones = {
        zone
        for site in (before, after)
        for rule in site.interlocks.values()
        for condition in rule.when
        for zone in condition.zones()
    }
    for zone in sorted(zones):
        if zone_meaning(before, zone) != zone_meaning(after, zone):
            yield Finding(f"$.map.zones.{zone}", "an interlock goes by where this zone lies", _ALL)
    # Of both: a signal must not be freed and changed in one step.
    guarded = before.safety_signals() | after.safety_signals()
    for address in sorted(guarded):
        # Compared as safety sees it; another name, or other decimals, are let through.
        if _safety_meaning(before, address) != _safety_meaning(after, address):
            device, _, signal = address.partition("/")
            yield Finding(
                f"$.devices.{device}.signals.{signal}",
                "interlocks, STOP or the night depend on this signal",
                _ALL,
            )


def _check_device(where: str, before: Device | None, after: Device | None) -> Iterator[Finding]:
    for key in ("commands", "drive", "link_loss", "pointing"):
        was = getattr(before, key, None) or None
        now = getattr(after, key, None) or None
        if was != now:
            yield Finding(f"{where}.{key}", "only what is read may be changed from the hub", _ALL)
    # Of a device that comes or goes its other keys tell.
    if before is not None and after is not None and before.connection != after.connection:
        yield Finding(f"{where}.connection", "only what is read may be changed from the hub", _ALL)
    # Whether it is shown to guests is for those who answer for the robot.
    if _was_opened(before, after):
        problem = "what only people with an account saw is not shown to guests from the hub"
        yield Finding(f"{where}.visibility", problem, _ALL)


def _was_opened(before: Device | None, after: Device | None) -> bool:
    if after is None:
        return False
    # A new device counts as hidden, so that it cannot come as a public one.
    was = {"": before.visibility if before is not None else "view"}
    now = {"": after.visibility}
    for key in ("signals", "streams"):
        for name, part in getattr(before, key, {}).items():
            was[f"{key} {name}"] = part.visibility
        for name, part in getattr(after, key).items():
            now[f"{key} {name}"] = part.visibility
    # New signals and streams may be public: nobody hid them.
    return any(value == "public" and was.get(key) == "view" for key, value in now.items())


def _safety_meaning(site: Site, address: str) -> tuple[object, ...] | None:
    """Give what safety depends on of a signal, and of the camera it counts on: not how it looks."""
    device, _, name = address.partition("/")
    described = site.devices.get(device)
    signal = None if described is None else described.signals.get(name)
    if signal is None:
        return None
    # Its range stays: what is outside of it is unknown, and unknown is unsafe.
    plain = {"name": "", "decimals": -1, "keep": 0.0}
    # What only changes how it looks is set to one value in both.
    looks = msgspec.structs.replace(signal, **plain, primary=True, was="")
    return looks, camera_meaning(site, device, source_as(signal.source, DetectionSource).stream)
