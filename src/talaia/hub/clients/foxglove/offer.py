"""What one account is offered of a site: channels, services, parameters, driven topics. Pure.

What an account may not see is not in it, so nothing that is advertised has to be hidden later.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.auth.permissions import Right, sees_device, sees_signal, sees_stream
from talaia.hub.clients.foxglove.schemas import (
    ANSWER_SCHEMA,
    EMPTY_SCHEMA,
    IMAGE_SCHEMA,
    arguments_schema,
    signal_schema,
)
from talaia.model.site import parts_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.clients.foxglove.schemas import NamedSchema
    from talaia.model.site import Device, Signal, Site

__all__ = [
    "FoxgloveOffer",
    "OfferedCamera",
    "OfferedService",
    "OfferedSignal",
    "OfferedTopic",
    "make_offer",
]

# Beside a driven device's commands; no command can be called so, for ids hold no slash.
STOP = "drive/stop"


class OfferedSignal(NamedTuple):
    """A channel with a signal's samples.

    Attributes:
        device: see `Site`.
        signal: as it is described.
        addresses: of its parts, in their order.
        schema: of its messages.

    """

    device: str
    signal: Signal
    addresses: tuple[str, ...]
    schema: NamedSchema


class OfferedCamera(NamedTuple):
    """A channel with a camera's pictures; ``stream`` is ``<device>/<stream>``."""

    stream: str
    schema: NamedSchema


class OfferedTopic(NamedTuple):
    """A channel with a raw topic of the robot, as it is serialized there."""

    topic: str
    schema: NamedSchema


class OfferedService(NamedTuple):
    """A service that is a command of a device, or STOP when ``command`` is empty."""

    device: str
    command: str
    request: NamedSchema
    response: NamedSchema


@dataclass(frozen=True, slots=True)
class FoxgloveOffer:
    """All of it, by topic, by the service's name, and by the parameter's.

    Attributes:
        signals: see above.
        cameras: see above.
        topics: see above; what may be tapped is found out by `TappedChannels`.
        services: see above.
        driven: by topic: the device that listens to it.
        parameters: plain facts of the description.

    """

    signals: dict[str, OfferedSignal] = field(default_factory=dict)
    cameras: dict[str, OfferedCamera] = field(default_factory=dict)
    topics: dict[str, OfferedTopic] = field(default_factory=dict)
    services: dict[str, OfferedService] = field(default_factory=dict)
    driven: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, str | float] = field(default_factory=dict)

    @property
    def channels(self) -> Mapping[str, OfferedSignal | OfferedCamera | OfferedTopic]:
        """All channels, by topic."""
        return {**self.topics, **self.signals, **self.cameras}


def make_offer(
    site: Site, grants: Grants, tapped: Mapping[str, NamedSchema] | None = None
) -> FoxgloveOffer:
    """Offer an account what it may see and do at a site now, and the raw topics it may tap."""
    offer = FoxgloveOffer()
    offer.parameters.update({"/site": site.site, "/name": site.name, "/zone": site.zone})
    for device_id in site.devices:
        if sees_device(grants, site, device_id):
            _offer_views(offer, site, grants, device=device_id)
            _offer_actions(offer, site, grants, device=device_id)
    # Rights were looked at where they come from.
    for topic, schema in (tapped or {}).items():
        # A signal or camera of the same name keeps it.
        taken = topic in offer.signals or topic in offer.cameras
        offer.topics[f"/raw{topic}" if taken else topic] = OfferedTopic(topic, schema)
    return offer


def _offer_views(offer: FoxgloveOffer, site: Site, grants: Grants, *, device: str) -> None:
    described = site.devices[device]
    # One by one: a public signal may be of a device that is not.
    for name, signal in described.signals.items():
        if sees_signal(grants, site, device, name):
            address = f"{device}/{name}"
            parts = tuple(f"{address}.{part}" if part else address for part in parts_of(signal))
            offer.signals[f"/{address}"] = OfferedSignal(
                device, signal, parts, signal_schema(signal, described.name)
            )
    for name in described.streams:
        if sees_stream(grants, site, device, name):
            stream = f"{device}/{name}"
            # A signal of the same name keeps its topic.
            topic = f"/{stream}" if f"/{stream}" not in offer.signals else f"/{stream}/picture"
            offer.cameras[topic] = OfferedCamera(stream, IMAGE_SCHEMA)


def _offer_actions(offer: FoxgloveOffer, site: Site, grants: Grants, *, device: str) -> None:
    described: Device = site.devices[device]
    if grants.has_right(Right.USE, site.site, device):
        for name, command in described.commands.items():
            request = arguments_schema(f"{device}/{name}", command)
            service = OfferedService(device, name, request, ANSWER_SCHEMA)
            offer.services[f"/{device}/{name}"] = service
    rule = described.drive
    # Whoever may look at a driven device may stop it.
    if rule is not None and grants.has_right(Right.VIEW, site.site, device):
        service = OfferedService(device, "", EMPTY_SCHEMA, ANSWER_SCHEMA)
        offer.services[f"/{device}/{STOP}"] = service
        # Of two devices that listen to one topic, the first; the other has its own name.
        offer.driven.setdefault(rule.topic, device)
        offer.driven[f"/{device}/drive"] = device
        offer.parameters[f"/{device}/drive/max_speed"] = rule.max_speed
        offer.parameters[f"/{device}/drive/max_turn"] = rule.max_turn
