"""The connection graph as one Foxglove client is told of it: our devices, and the robot's nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.clients.foxglove.offer import CameraChannel, SignalChannel
from talaia.wire.foxglove.server_messages import (
    ConnectionGraphUpdate,
    GraphProviders,
    GraphPublishers,
    GraphSubscribers,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.hub.clients.foxglove.offer import FoxgloveOffer, TopicChannel
    from talaia.wire.frames import RobotGraph

__all__ = ["ClientGraph", "robot_services"]

# Who publishes a raw topic of which the robot has not said it yet.
_ROBOT = "robot"
# By name: who has it.
_Owners = dict[str, list[str]]


def robot_services(offer: FoxgloveOffer) -> frozenset[str]:
    """Give the robot's own services and actions that are offered."""
    return frozenset(of.robot.name for of in offer.services.values() if of.robot is not None)


class ClientGraph:
    """What was told last."""

    def __init__(self) -> None:
        """Nothing yet."""
        self._told: tuple[_Owners, _Owners, _Owners] | None = None

    def update(self, offer: FoxgloveOffer, robot: RobotGraph) -> ConnectionGraphUpdate | None:
        """Give what the client is to be told, all of it; None if that is what it knows."""
        now = _published(offer, robot), _subscribed(offer, robot), _provided(offer, robot)
        before, self._told = self._told, now
        if now == before:
            return None
        published, subscribed, provided = now
        was_published, was_subscribed, was_provided = before or ({}, {}, {})
        # A topic that is published or listened to is there.
        former = was_published.keys() | was_subscribed.keys()
        return ConnectionGraphUpdate(
            published_topics=[
                GraphPublishers(name=name, publisher_ids=ids) for name, ids in published.items()
            ],
            subscribed_topics=[
                GraphSubscribers(name=name, subscriber_ids=ids) for name, ids in subscribed.items()
            ],
            advertised_services=[
                GraphProviders(name=name, provider_ids=ids) for name, ids in provided.items()
            ],
            removed_topics=sorted(former - published.keys() - subscribed.keys()),
            removed_services=sorted(was_provided.keys() - provided.keys()),
        )


def _published(offer: FoxgloveOffer, robot: RobotGraph) -> _Owners:
    owners = _owners((node.name, node.publishes) for node in robot.nodes)
    return {topic: _publishers_of(of, owners) for topic, of in offer.channels.items()}


def _publishers_of(
    offered: SignalChannel | CameraChannel | TopicChannel, owners: _Owners
) -> list[str]:
    match offered:
        case SignalChannel():
            return [offered.device]
        case CameraChannel():
            return [offered.stream.partition("/")[0]]
        case _:
            return owners.get(offered.topic, [_ROBOT])


def _subscribed(offer: FoxgloveOffer, robot: RobotGraph) -> _Owners:
    # The names of raw topics are those of their channels.
    names = {offered.topic: topic for topic, offered in offer.topics.items()}
    nodes = _owners((node.name, node.subscribes) for node in robot.nodes)
    found = {names.get(topic, topic): ids for topic, ids in nodes.items()}
    devices = {topic: listened.device for topic, listened in offer.listened.items()} | offer.driven
    for topic, device in devices.items():
        found[topic] = [device, *found.get(topic, [])]
    return found


def _provided(offer: FoxgloveOffer, robot: RobotGraph) -> _Owners:
    nodes = _owners((node.name, node.serves) for node in robot.nodes)
    return {
        name: (nodes.get(of.robot.name) if of.robot is not None else None) or [of.device]
        for name, of in offer.services.items()
    }


def _owners(nodes: Iterable[tuple[str, list[str]]]) -> _Owners:
    found: _Owners = {}
    for node, names in nodes:
        for name in names:
            found.setdefault(name, []).append(node)
    return found
