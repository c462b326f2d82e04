"""What one account is offered of a site as Foxglove's channels, services and parameters. Pure."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.account_offer import make_account_offer
from talaia.hub.clients.foxglove.robot_schemas import ROBOT_ANSWER_SCHEMA, robot_schema
from talaia.hub.clients.foxglove.schemas import (
    ANSWER_SCHEMA,
    EMPTY_SCHEMA,
    FRAME_SCHEMA,
    IMAGE_SCHEMA,
    VIDEO_SCHEMA,
    arguments_schema,
    signal_schema,
)
from talaia.hub.clients.robot_names import RobotName, make_robot_names
from talaia.hub.clients.robot_parameters import RobotParameters, make_robot_parameters
from talaia.model.site import PositionFrame, SignalType

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.clients.account_offer import AccountOffer, OfferedSignal
    from talaia.hub.clients.foxglove.schemas import NamedSchema
    from talaia.model.site import Signal, Site

__all__ = [
    "CameraChannel",
    "FoxgloveOffer",
    "ServiceEntry",
    "SignalChannel",
    "TopicChannel",
    "make_foxglove_offer",
]

# Beside a driven device's commands; no command can be called so, for ids hold no slash.
STOP = "drive/stop"


class SignalChannel(NamedTuple):
    """A channel with a signal's samples.

    Attributes:
        device: see `Site`.
        signal: as it is described.
        addresses: of its parts, in their order.
        schema: of its messages.
        child: of a position as a transform: the frame that is there; else empty.

    """

    device: str
    signal: Signal
    addresses: tuple[str, ...]
    schema: NamedSchema
    child: str = ""


class CameraChannel(NamedTuple):
    """A channel with a camera's pictures; ``stream`` is ``<device>/<stream>``.

    Attributes:
        stream: see above.
        schema: of its messages.
        film: they are of an H.264 film instead of single.

    """

    stream: str
    schema: NamedSchema
    film: bool = False


class TopicChannel(NamedTuple):
    """A channel with a raw topic of the robot, as it is serialized there."""

    topic: str
    schema: NamedSchema


class ServiceEntry(NamedTuple):
    """A service that is a command of a device, or STOP when ``command`` is empty.

    Attributes:
        device: see above; of the robot's own service the first that it may be of.
        command: see above.
        request: of its arguments.
        response: of its answer.
        robot: the robot's own service or action; the request says which command is meant.

    """

    device: str
    command: str
    request: NamedSchema
    response: NamedSchema
    robot: RobotName | None = None


@dataclass(frozen=True, slots=True)
class FoxgloveOffer:
    """All of it, by topic, by the service's name, and by the parameter's.

    Attributes:
        signals: see above.
        cameras: see above.
        topics: see above; what may be tapped is found out by `TappedChannels`.
        services: see above.
        driven: by topic: the device that listens to it.
        listened: topics of the robot on which messages become commands.
        parameters: plain facts of the description.
        robot_parameters: of the robot's nodes.

    """

    signals: dict[str, SignalChannel] = field(default_factory=dict)
    cameras: dict[str, CameraChannel] = field(default_factory=dict)
    topics: dict[str, TopicChannel] = field(default_factory=dict)
    services: dict[str, ServiceEntry] = field(default_factory=dict)
    driven: dict[str, str] = field(default_factory=dict)
    listened: dict[str, RobotName] = field(default_factory=dict)
    parameters: dict[str, str | float] = field(default_factory=dict)
    robot_parameters: RobotParameters = field(default_factory=lambda: RobotParameters({}))

    @property
    def channels(self) -> Mapping[str, SignalChannel | CameraChannel | TopicChannel]:
        """All channels, by topic."""
        return {**self.topics, **self.signals, **self.cameras}


def make_foxglove_offer(
    site: Site, grants: Grants, tapped: Mapping[str, NamedSchema] | None = None
) -> FoxgloveOffer:
    """Offer an account what it may see and do at a site now, and the raw topics it may tap."""
    account = make_account_offer(site, grants)
    offer = FoxgloveOffer(
        driven={topic: driven.device for topic, driven in account.driven_topics("").items()},
        parameters=account.facts,
        robot_parameters=make_robot_parameters(site, account),
    )
    _offer_views(offer, site, account)
    _offer_services(offer, account)
    _offer_robot_names(offer, site, account)
    # Rights were looked at where they come from.
    for topic, schema in (tapped or {}).items():
        # A signal or camera of the same name keeps it.
        taken = topic in offer.signals or topic in offer.cameras
        offer.topics[f"/raw{topic}" if taken else topic] = TopicChannel(topic, schema)
    return offer


def _offer_views(offer: FoxgloveOffer, site: Site, account: AccountOffer) -> None:
    for seen in account.signals:
        schema = signal_schema(seen.signal, site.devices[seen.device].name)
        addresses = tuple(seen.addresses().values())
        offer.signals[f"/{seen.address}"] = SignalChannel(
            seen.device, seen.signal, addresses, schema
        )
        if _is_local(seen.signal):
            offer.signals[f"/{seen.address}/frame"] = SignalChannel(
                seen.device, seen.signal, addresses, FRAME_SCHEMA, _frame_of(site, seen)
            )
    for camera in account.cameras:
        topic = f"/{camera.address}"
        # A signal of the same name keeps its topic.
        topic = f"{topic}/picture" if topic in offer.signals else topic
        offer.cameras[topic] = CameraChannel(camera.address, IMAGE_SCHEMA)
        film = CameraChannel(camera.address, VIDEO_SCHEMA, film=True)
        offer.cameras[f"/{camera.address}/video"] = film


def _is_local(signal: Signal) -> bool:
    return signal.type is SignalType.POSITION and signal.frame is not PositionFrame.WGS84


def _frame_of(site: Site, seen: OfferedSignal) -> str:
    """Name the frame that a position places: the device's, if it has one alone."""
    # Also those that this account may not see: names are the same for everybody.
    positions = [one for one in site.devices[seen.device].signals.values() if _is_local(one)]
    return seen.device if len(positions) == 1 else seen.address


def _offer_services(offer: FoxgloveOffer, account: AccountOffer) -> None:
    for device, name, command in account.commands:
        request = arguments_schema(f"{device}/{name}", command)
        offer.services[f"/{device}/{name}"] = ServiceEntry(device, name, request, ANSWER_SCHEMA)
    for drive in account.drives:
        service = ServiceEntry(drive.device, "", EMPTY_SCHEMA, ANSWER_SCHEMA)
        offer.services[f"/{drive.device}/{STOP}"] = service


def _offer_robot_names(offer: FoxgloveOffer, site: Site, account: AccountOffer) -> None:
    names = make_robot_names(site, account.commands)
    # The protocol has no actions: a call is answered when the goal has ended.
    for name, robot in {**names.actions, **names.services}.items():
        entry = ServiceEntry(robot.device, "", robot_schema(robot), ROBOT_ANSWER_SCHEMA, robot)
        offer.services[f"/raw{name}" if name in offer.services else name] = entry
    offer.listened.update(names.topics)
