"""What one client was told is there, by number, and what it subscribed to of it. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.foxglove.offer import FoxgloveOffer
from talaia.wire.foxglove.server_messages import (
    AdvertiseChannels,
    AdvertiseServices,
    FoxgloveChannel,
    FoxgloveSchema,
    FoxgloveService,
    UnadvertiseChannels,
    UnadvertiseServices,
)

if TYPE_CHECKING:
    from talaia.hub.clients.foxglove.offer import ServiceEntry
    from talaia.hub.clients.foxglove.schemas import NamedSchema
    from talaia.wire.foxglove.server_messages import ServerMessage

__all__ = ["AdvertisedThings", "TopicChange"]


class TopicChange(NamedTuple):
    """What another offer comes to: messages for the client, and topics it gets no more of."""

    messages: list[ServerMessage]
    gone: list[str]


class AdvertisedThings:
    """Numbers of channels, services and subscriptions of one client.

    A number is never another thing's: clients keep what they know of a channel by it.
    """

    def __init__(self) -> None:
        """Start with nothing."""
        self.offer = FoxgloveOffer()
        # By the topic or service and its schema; numbers stay while either is gone.
        self._channel_ids: dict[tuple[str, str], int] = {}
        self._service_ids: dict[tuple[str, str], int] = {}
        self._topics: dict[int, str] = {}
        self._services: dict[int, str] = {}
        # By the client's number of the subscription, and by topic.
        self._subscribed: dict[int, str] = {}
        self._subscription_of: dict[str, int] = {}

    def update_offer(self, offer: FoxgloveOffer) -> TopicChange:
        """Take what is offered now; give what the client has to be told."""
        channels = {
            self._number(self._channel_ids, topic, offered.schema): topic
            for topic, offered in offer.channels.items()
        }
        # Services have numbers of their own.
        services = {
            self._number(self._service_ids, name, offered.request): name
            for name, offered in offer.services.items()
        }
        # What is gone first: a topic may come back with another schema.
        messages: list[ServerMessage] = []
        lost = [number for number in self._topics if number not in channels]
        if lost:
            messages.append(UnadvertiseChannels(channel_ids=lost))
        ended = [number for number in self._services if number not in services]
        if ended:
            messages.append(UnadvertiseServices(service_ids=ended))
        gone = [self._topics[number] for number in lost]
        # The client's numbers of these are free again.
        for topic in gone:
            subscription = self._subscription_of.pop(topic, None)
            if subscription is not None:
                del self._subscribed[subscription]
        # A channel whose schema changed has another number: it is both lost and new.
        new = [number for number in channels if number not in self._topics]
        # The first one always: clients wait for it.
        if new or not self._topics:
            said = [_channel(number, channels[number], offer) for number in new]
            messages.append(AdvertiseChannels(channels=said))
        begun = [number for number in services if number not in self._services]
        if begun:
            added = [_service(number, services[number], offer) for number in begun]
            messages.append(AdvertiseServices(services=added))
        self.offer, self._topics, self._services = offer, channels, services
        return TopicChange(messages, gone)

    def subscribe_topic(self, subscription: int, channel: int) -> str:
        """Note a subscription and give its topic.

        Raises:
            ValueError: there is no such channel, or it or the number is subscribed already.

        """
        topic = self._topics.get(channel)
        if topic is None:
            raise ValueError(f"there is no channel {channel}")
        if subscription in self._subscribed:
            raise ValueError(f"the subscription {subscription} is in use")
        if topic in self._subscription_of:
            raise ValueError(f"{topic} is subscribed to already")
        # Both ways: samples come by topic, and clients speak of numbers.
        self._subscribed[subscription] = topic
        self._subscription_of[topic] = subscription
        return topic

    def unsubscribe_topic(self, subscription: int) -> str | None:
        """End a subscription and give its topic; None if there is none."""
        topic = self._subscribed.pop(subscription, None)
        if topic is not None:
            del self._subscription_of[topic]
        return topic

    def subscription_of(self, topic: str) -> int | None:
        """Give the client's number of its subscription to a topic."""
        return self._subscription_of.get(topic)

    def has_subscription(self, topic: str) -> bool:
        """Tell whether a topic is subscribed to."""
        return topic in self._subscription_of

    def service(self, number: int) -> ServiceEntry | None:
        """Find a service by its number."""
        return self.offer.services.get(self._services.get(number, ""))

    @staticmethod
    def _number(numbers: dict[tuple[str, str], int], name: str, schema: NamedSchema) -> int:
        return numbers.setdefault((name, schema.text), len(numbers) + 1)


def _channel(number: int, topic: str, offer: FoxgloveOffer) -> FoxgloveChannel:
    schema = offer.channels[topic].schema
    return FoxgloveChannel(
        id=number,
        topic=topic,
        encoding=schema.messages,
        schema_name=schema.name,
        schema_encoding=schema.encoding,
        schema=schema.text,
    )


def _service(number: int, name: str, offer: FoxgloveOffer) -> FoxgloveService:
    offered = offer.services[name]
    return FoxgloveService(
        id=number,
        name=name,
        type=offered.request.name,
        request=_schema(offered.request),
        response=_schema(offered.response),
    )


def _schema(schema: NamedSchema) -> FoxgloveSchema:
    return FoxgloveSchema(
        encoding="json",
        schema_name=schema.name,
        schema_encoding="jsonschema",
        schema=schema.text,
    )
