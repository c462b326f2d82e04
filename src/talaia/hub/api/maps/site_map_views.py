"""What a site draws on a map, and where it is, as far as a person may see it. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.api.maps.map_schemas import (
    FloorPlanShape,
    MapLineShape,
    MapOriginShape,
    MapZoneShape,
    SiteMapShape,
)
from talaia.hub.auth.permissions import Right, sees_device, sees_signal, sees_stream
from talaia.model.discovery.role_proposal import roles_of
from talaia.model.maps.geodesy import GeodeticPlace, place_of_local
from talaia.model.roles import SignalRole
from talaia.model.site import PositionFrame, SignalType

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.sites import LiveSite
    from talaia.model.site import Signal, Site

__all__ = ["SiteAtGlance", "describe_map", "glance_at"]

_TOLD_ROLES = (
    SignalRole.TELESCOPE_STATE,
    SignalRole.DOME_SHUTTER,
    SignalRole.CAMERA_STATE,
    SignalRole.WEATHER_SAFETY,
)


class SiteAtGlance(NamedTuple):
    """A site in one line. What is unknown, too old or not open to the person is None or empty.

    Attributes:
        state: a state in words, with the name of what it is of.
        battery: how full the emptiest battery is (%).
        place: where its robot is, or the site; degrees.
        moving: ``place`` is that of a robot, and fresh.
        heading: of the robot, clockwise from true north (°).
        driver: who drives, by name.
        stream: a camera of it, as ``device/stream``.

    """

    state: str = ""
    battery: float | None = None
    place: GeodeticPlace | None = None
    moving: bool = False
    heading: float | None = None
    driver: str = ""
    stream: str = ""


class _Reading(NamedTuple):
    device: str
    signal: Signal
    role: SignalRole | None
    numbers: tuple[float, ...]


def describe_map(site: Site, grants: Grants) -> SiteMapShape | None:
    """Say what a site draws, to those who may view something of it beyond what is public."""
    shown = site.map
    if shown is None or not _views_something(site, grants):
        return None
    origin = shown.origin
    return SiteMapShape(
        origin=None
        if origin is None
        else MapOriginShape(
            latitude=origin.latitude, longitude=origin.longitude, heading=origin.heading
        ),
        zones=[
            MapZoneShape(
                id=name,
                name=zone.name,
                kind=zone.kind,
                type=zone.geometry.type,
                lines=[_line_schema(line) for line in zone.geometry.lines()],
                alarm=zone.alarm,
                interlock=zone.interlock,
            )
            for name, zone in shown.zones.items()
        ],
        plans=[
            FloorPlanShape(
                id=name,
                name=plan.name,
                picture=plan.picture,
                x=plan.x,
                y=plan.y,
                rotation=plan.rotation,
                resolution=plan.resolution,
            )
            for name, plan in shown.plans.items()
        ],
        grid=shown.grid,
    )


def glance_at(live: LiveSite, grants: Grants, fresh: Collection[tuple[str, str]]) -> SiteAtGlance:
    """Say in one line how a site is; ``fresh`` are the signals whose values may be believed."""
    site = live.description
    readings = list(_readings_of(live, grants, fresh)) if live.online else []
    place, heading = _robot_place(site, readings)
    return SiteAtGlance(
        state=_state_in_words(site, readings),
        battery=min(
            (r.numbers[0] for r in readings if r.role is SignalRole.BATTERY_LEVEL), default=None
        ),
        place=place or _site_place(site, grants),
        moving=place is not None,
        heading=heading,
        driver=next(
            (
                state.who
                for device, (state, _) in live.current.leases.items()
                if state.session and grants.has_right(Right.VIEW, site.site, device)
            ),
            "",
        ),
        stream=next(
            (
                f"{device_id}/{stream_id}"
                for device_id, device in site.devices.items()
                for stream_id in device.streams
                if sees_device(grants, site, device_id)
                and sees_stream(grants, site, device_id, stream_id)
            ),
            "",
        ),
    )


def _line_schema(line: Sequence[tuple[float, float]]) -> MapLineShape:
    return MapLineShape(
        latitudes=[latitude for _, latitude in line],
        longitudes=[longitude for longitude, _ in line],
    )


def _views_something(site: Site, grants: Grants) -> bool:
    viewed = grants.devices(Right.VIEW, site.site)
    # None is the whole site; an empty set is nothing but what is public.
    return viewed is None or bool(viewed)


def _readings_of(
    live: LiveSite, grants: Grants, fresh: Collection[tuple[str, str]]
) -> Iterator[_Reading]:
    site = live.description
    numbers: dict[tuple[str, str], list[float]] = {}
    for at, channel in enumerate(live.channels):
        key = (channel.device, channel.signal)
        if key in fresh:
            numbers.setdefault(key, []).append(float(live.latest.value[at]))
    roles: dict[str, Mapping[str, SignalRole]] = {}
    for (device_id, signal_id), found in numbers.items():
        if not sees_signal(grants, site, device_id, signal_id):
            continue
        device = site.devices[device_id]
        if device_id not in roles:
            roles[device_id] = roles_of(device).signals
        role = roles[device_id].get(signal_id)
        # What may be unknown in a position is its heading.
        if math.isfinite(found[0]):
            yield _Reading(device_id, device.signals[signal_id], role, tuple(found))


def _state_in_words(site: Site, readings: list[_Reading]) -> str:
    states = [r for r in readings if r.signal.type is SignalType.STATE and r.signal.primary]
    # By what it is, where that is known; else as the description has it.
    states.sort(
        key=lambda r: _TOLD_ROLES.index(r.role) if r.role in _TOLD_ROLES else len(_TOLD_ROLES)
    )
    for reading in states:
        number = int(reading.numbers[0])
        if 0 <= number < len(reading.signal.states):
            name = site.devices[reading.device].name
            return f"{name}: {reading.signal.states[number]}"
    return ""


def _robot_place(site: Site, readings: list[_Reading]) -> tuple[GeodeticPlace | None, float | None]:
    origin = None if site.map is None else site.map.origin
    positions = [r for r in readings if r.signal.type is SignalType.POSITION]
    # What a satellite says is of Earth already.
    for reading in positions:
        if reading.signal.frame is PositionFrame.WGS84 and math.isfinite(reading.numbers[1]):
            return GeodeticPlace(reading.numbers[0], reading.numbers[1]), None
    for reading in positions:
        if origin is None or reading.signal.frame is PositionFrame.WGS84:
            continue
        x, y, yaw = reading.numbers
        if not math.isfinite(y):
            continue
        zero = GeodeticPlace(origin.latitude, origin.longitude)
        heading = (origin.heading - math.degrees(yaw)) % 360 if math.isfinite(yaw) else None
        return place_of_local(x, y, zero, origin.heading), heading
    return None, None


def _site_place(site: Site, grants: Grants) -> GeodeticPlace | None:
    if not _views_something(site, grants):
        return None
    if site.place is not None:
        return GeodeticPlace(site.place.latitude, site.place.longitude)
    if site.map is not None and site.map.origin is not None:
        return GeodeticPlace(site.map.origin.latitude, site.map.origin.longitude)
    return None
