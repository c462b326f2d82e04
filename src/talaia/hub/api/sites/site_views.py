"""A site's description as a person may see it. Pure.

Long, because each part of a description has its view here.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from talaia.hub.api.driving.drive_schemas import DrivenJointShape
from talaia.hub.api.driving.lane_views import describe_lane
from talaia.hub.api.driving.picture_model_views import describe_models, mark_shapes
from talaia.hub.api.maps.site_map_views import describe_map, glance_at
from talaia.hub.api.schemas.account_schemas import DeviceSummary
from talaia.hub.api.schemas.common import (
    ArgumentShape,
    CommandShape,
    DetectShape,
    DeviceShape,
    DriveShape,
    ShownUnitShape,
    SignalShape,
    SiteShape,
    SiteSummary,
    StreamShape,
)
from talaia.hub.api.schemas.observatory_schemas import SlewShape, StateNeed
from talaia.hub.api.schemas.sighting_schemas import MarkCountShape
from talaia.hub.api.sites.command_states import command_part, signal_part, state_need
from talaia.hub.api.sites.rule_views import (
    describe_enclosures,
    describe_place,
    describe_pointing,
    describe_rules,
)
from talaia.hub.api.sites.shown_signals import ShownSignals
from talaia.hub.auth.permissions import (
    Grants,
    Right,
    sees_device,
    sees_signal,
    sees_stream,
    sees_unblurred,
)
from talaia.model.connections.onvif import ONVIF_TRAVELS
from talaia.model.derived_signals import detect_of
from talaia.model.detection import DetectionSource
from talaia.model.discovery.role_proposal import meanings_of, place_arguments, roles_of
from talaia.model.interlocks.unguarded import unguarded_devices
from talaia.model.roles import CommandRole, SignalRole
from talaia.model.site import (
    CommandKind,
    DriveMessage,
    LinkLoss,
    SignalType,
    Visibility,
    parts_of,
)
from talaia.model.units.unit import unit_of

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from talaia.hub.live.sites import LiveSite
    from talaia.model.discovery.role_proposal import DeviceRoles
    from talaia.model.site import Command, Device, Drive, Signal, Site
    from talaia.model.units.conversion import Conversion

__all__ = [
    "describe_command",
    "describe_site",
    "heartbeat_commands",
    "list_devices",
    "summarise_site",
]

_AS_STORED: Mapping[str, Conversion] = MappingProxyType({})
# Sees only what is public.
_GUEST = Grants()


def describe_site(
    live: LiveSite, grants: Grants, shown: Mapping[str, Conversion] = _AS_STORED
) -> SiteShape:
    """Describe a site, leaving out what is not open to the person; ``shown`` is by stored unit."""
    site = live.description
    ways = ShownSignals(site, shown)
    heartbeats = heartbeat_commands(site)
    return SiteShape(
        site=site.site,
        name=site.name,
        zone=site.zone,
        online=live.online,
        since_us=live.presence.since_us,
        last_seen_us=live.presence.last_seen_us,
        catalogue=live.edition,
        place=describe_place(site, grants),
        devices=[
            _device_schema(site, device_id, device, grants, heartbeats=heartbeats, shown=ways)
            for device_id, device in site.devices.items()
            if sees_device(grants, site, device_id)
        ],
        rules=describe_rules(site, grants),
        enclosures=describe_enclosures(site, grants),
        shown_units={unit: ShownUnitShape(**way._asdict()) for unit, way in shown.items()},
        map=describe_map(site, grants),
    )


def heartbeat_commands(site: Site) -> frozenset[str]:
    """Give the addresses of the commands that keep a roof's own supervision quiet.

    They are the gateway's business: sent by a person one would hide that nobody supervises.
    """
    return frozenset(roof.heartbeat.command for roof in site.enclosures.values() if roof.heartbeat)


def describe_command(site: Site, device_id: str, command_id: str, grants: Grants) -> CommandShape:
    """Describe one command of a device."""
    device = site.devices[device_id]
    command = device.commands[command_id]
    role = roles_of(device).commands.get(command_id)
    return _command_schema(command_id, command, role, state_need(site, device_id, command, grants))


def summarise_site(live: LiveSite, grants: Grants, now_ns: int) -> SiteSummary:
    """Say in short how a site is."""
    site = live.description
    seen, fresh = _visible_signals(live, grants, now_ns)
    glance = glance_at(live, grants, fresh)
    return SiteSummary(
        site=site.site,
        name=site.name,
        zone=site.zone,
        online=live.online,
        since_us=live.presence.since_us,
        last_seen_us=live.presence.last_seen_us,
        why=live.presence.why,
        loop_ms=live.presence.loop_ms,
        skew_ms=live.presence.skew_ms,
        rival_us=live.rivals.seen_us,
        devices=sum(sees_device(grants, site, device) for device in site.devices),
        signals=len(seen),
        stale=len(seen - fresh),
        group=site.group,
        tags=list(site.tags),
        state=glance.state,
        battery=glance.battery,
        latitude=None if glance.place is None else glance.place.latitude,
        longitude=None if glance.place is None else glance.place.longitude,
        moving=glance.moving,
        heading=glance.heading,
        driver=glance.driver,
        stream=glance.stream,
        stops=[
            device_id
            for device_id, device in site.devices.items()
            if device.drive and grants.has_right(Right.VIEW, site.site, device_id)
        ],
    )


def list_devices(live: LiveSite, grants: Grants, now_ns: int) -> list[DeviceSummary]:
    """Say in short how each device is that is open to the person."""
    site = live.description
    seen, fresh = _visible_signals(live, grants, now_ns)
    return [
        DeviceSummary(
            site=site.site,
            site_name=site.name,
            device=device_id,
            name=device.name,
            kind=device.kind,
            online=live.online,
            rights=list(grants.rights_on(site.site, device_id)),
            public=sees_device(_GUEST, site, device_id),
            signals=sum(of == device_id for of, _ in seen),
            stale=sum(of == device_id for of, _ in seen - fresh),
        )
        for device_id, device in site.devices.items()
        if sees_device(grants, site, device_id)
    ]


def _visible_signals(
    live: LiveSite, grants: Grants, now_ns: int
) -> tuple[set[tuple[str, str]], set[tuple[str, str]]]:
    """Give the signals a person sees, and those of them that are not older than their limit."""
    site = live.description
    ages = {
        (device_id, signal_id): signal.stale_after
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
        if sees_signal(grants, site, device_id, signal_id)
    }
    # When each newest sample came here (monotonic): a gateway's clock may be wrong.
    arrived = live.latest.arrived_ns
    fresh = {
        (channel.device, channel.signal)
        for at, channel in enumerate(live.channels)
        # The least number stands for "never".
        if arrived[at] != np.iinfo(np.int64).min
        and now_ns - int(arrived[at])
        <= ages.get((channel.device, channel.signal), 0.0) * 1_000_000_000
    }
    return set(ages), fresh


def _device_schema(
    site: Site,
    device_id: str,
    device: Device,
    grants: Grants,
    *,
    heartbeats: Collection[str],
    shown: ShownSignals,
) -> DeviceShape:
    uses = grants.has_right(Right.USE, site.site, device_id)
    views = grants.has_right(Right.VIEW, site.site, device_id)
    roles = roles_of(device)
    return DeviceShape(
        id=device_id,
        name=device.name,
        kind=device.kind,
        signals=[
            _signal_schema(
                f"{device_id}/{signal_id}",
                signal,
                roles.signals.get(signal_id),
                shown.conversion_of(signal),
            )
            for signal_id, signal in device.signals.items()
            if sees_signal(grants, site, device_id, signal_id)
        ],
        streams=[
            StreamShape(
                id=stream_id,
                address=f"{device_id}/{stream_id}",
                name=stream.name,
                max_rate=stream.max_rate,
                public=stream.visibility is Visibility.PUBLIC,
                detect=_detect_schema(site, device_id, stream_id, grants),
                lane=describe_lane(site, device_id, stream_id, grants),
                models=describe_models(site, device_id, stream_id, grants),
                blurred=stream.blur is not None,
                may_unblur=stream.blur is not None
                and sees_unblurred(grants, site, device_id, stream_id),
            )
            for stream_id, stream in device.streams.items()
            if sees_stream(grants, site, device_id, stream_id)
        ],
        commands=[
            _command_schema(
                command_id,
                command,
                roles.commands.get(command_id),
                state_need(site, device_id, command, grants),
            )
            for command_id, command in device.commands.items()
            if uses
            and f"{device_id}/{command_id}" not in heartbeats
            # What somebody may not ask for has no button.
            and grants.has_right(Right(command.right), site.site, device_id)
        ],
        drive=_drive_schema(device.drive, shown.by_unit) if device.drive and views else None,
        public=device.visibility is Visibility.PUBLIC,
        link_loss=_link_loss(site, device) if views else "",
        pointing=describe_pointing(device.pointing) if device.pointing and views else None,
        slew=_slew_schema(device, roles) if uses else None,
        unguarded=device_id in unguarded_devices(site),
        # Whoever may not see the real one must not learn that it is there.
        twin_of=device.twin.of
        if device.twin is not None and sees_device(grants, site, device.twin.of)
        else "",
        rights=list(grants.rights_on(site.site, device_id)),
    )


def _link_loss(site: Site, device: Device) -> str:
    """Say what is done with a device without the hub; empty when there is nothing to say."""
    said = []
    if device.drive is not None:
        stops = device.drive.link_loss is LinkLoss.STOP
        said.append("stops at once" if stops else "stops if it is being driven from here")
    if device.link_loss is not None:
        steps = (step.command.partition("/") for step in device.link_loss.run)
        # An arrow is read in every language; the rest is recognised and said in that of the page.
        names = " → ".join(
            f"{site.devices[at].name}: {site.devices[at].commands[what].name}"
            for at, _, what in steps
        )
        said.append(f"after {device.link_loss.after:g} seconds: {names}")
    return "; ".join(said)


def _slew_schema(device: Device, roles: DeviceRoles) -> SlewShape | None:
    """Say how the device is pointed to a place in the sky."""
    found = place_arguments(device, roles)
    if found is None:
        return None
    return SlewShape(command=found.command, ra=found.ra, dec=found.dec, alt="", az="")


def _signal_schema(
    address: str, signal: Signal, role: SignalRole | None, shown: Conversion | None
) -> SignalShape:
    decimals = signal.decimals
    # The description leaves them to the unit.
    if decimals < 0:
        decimals = unit_of(signal.unit).decimals
    return SignalShape(
        id=address.partition("/")[2],
        address=address,
        name=signal.name,
        type=signal.type,
        role=role or SignalRole.NONE,
        unit=signal.unit,
        decimals=decimals,
        minimum=signal.minimum,
        maximum=signal.maximum,
        states=list(signal.states),
        meanings=list(meanings_of(signal, role)),
        frame=signal.frame if signal.type is SignalType.POSITION else "",
        max_age=signal.stale_after,
        primary=signal.primary,
        public=signal.visibility is Visibility.PUBLIC,
        ros=signal_part(signal),
        channels=[address + (f".{part}" if part else "") for part in parts_of(signal)],
        shown=_shown_schema(shown),
    )


def _shown_schema(shown: Conversion | None) -> ShownUnitShape | None:
    return None if shown is None else ShownUnitShape(**shown._asdict())


def _detect_schema(
    site: Site, device_id: str, stream_id: str, grants: Grants
) -> DetectShape | None:
    device = site.devices[device_id]
    detect = detect_of(site, device.streams[stream_id])
    if detect is None:
        return None
    zones: dict[str, list[MarkCountShape]] = {}
    lines: dict[str, list[MarkCountShape]] = {}
    for signal_id, signal in device.signals.items():
        source = signal.source
        if not isinstance(source, DetectionSource) or source.stream != stream_id or source.model:
            continue
        if not sees_signal(grants, site, device_id, signal_id):
            continue
        count = MarkCountShape(
            signal=f"{device_id}/{signal_id}",
            label=source.sees,
            measure=source.measure,
            max_age=signal.stale_after,
        )
        if source.zone:
            zones.setdefault(source.zone, []).append(count)
        elif source.line:
            lines.setdefault(source.line, []).append(count)
    return DetectShape(
        classes=list(detect.classes),
        confidence=detect.confidence,
        zones=mark_shapes(detect.zones, zones),
        lines=mark_shapes(detect.lines, lines),
    )


def _command_schema(
    command_id: str, command: Command, role: CommandRole | None, needs: StateNeed | None
) -> CommandShape:
    return CommandShape(
        id=command_id,
        name=command.name,
        role=role or CommandRole.NONE,
        description=command.description,
        confirm=command.confirm,
        timeout=command.timeout,
        cancellable=command.kind is CommandKind.ACTION
        or (command.kind is CommandKind.ONVIF and command.target in ONVIF_TRAVELS),
        arguments=[
            ArgumentShape(
                id=argument_id,
                name=argument.name or argument_id,
                type=argument.type,
                unit=argument.unit,
                minimum=argument.minimum,
                maximum=argument.maximum,
                max_length=argument.max_length,
                default=argument.default,
            )
            for argument_id, argument in command.arguments.items()
        ],
        needs=needs,
        ros=command_part(command),
    )


def _drive_schema(drive: Drive, shown: Mapping[str, Conversion]) -> DriveShape:
    return DriveShape(
        max_speed=drive.max_speed,
        # None: as fast as forwards.
        max_reverse=drive.reverse,
        max_sideways=drive.max_sideways,
        max_turn=drive.max_turn,
        max_steering=drive.max_steering,
        joints=[
            DrivenJointShape(
                id=word,
                name=joint.name or word,
                max_speed=joint.max_speed,
                minimum=joint.minimum,
                maximum=joint.maximum,
                position=joint.position,
                slides=joint.slides,
            )
            for word, joint in drive.joints.items()
        ],
        ptz=drive.message is DriveMessage.PTZ,
        rate=drive.rate,
        ttl=drive.ttl,
        lease=drive.lease,
        picture=drive.picture,
        position=drive.position,
        stop=True,
        shown_speed=_shown_schema(shown.get("m/s")),
        shown_turn=_shown_schema(shown.get("rad/s")),
    )
