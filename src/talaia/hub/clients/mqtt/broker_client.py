"""The connection to a broker: MQTT 5, with nothing kept there for the hub while it is away."""

from __future__ import annotations

import ssl
from typing import TYPE_CHECKING, Any

import aiomqtt
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from paho.mqtt.reasoncodes import ReasonCode
from paho.mqtt.subscribeoptions import SubscribeOptions

from talaia.hub.clients.mqtt.asked_commands import InboundMessage
from talaia.hub.clients.mqtt.broker_settings import read_secret
from talaia.wire.mqtt.payloads import MOST_COMMAND_BYTES

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.hub.clients.mqtt.broker_settings import BrokerAddress
    from talaia.wire.mqtt.topic_tree import TopicTree

__all__ = ["answer_properties", "connect_broker", "read_message", "subscribe_commands"]

# The broker learns of a dead hub within one and a half of these (s).
_KEEPALIVE_S = 15
# An answer of the broker takes at most so long (s).
_ANSWER_S = 10.0
# Messages of the broker that wait here; more are left out.
_MOST_INCOMING = 100
# The largest command with its topic and properties (bytes).
_MOST_PACKET = MOST_COMMAND_BYTES + 8192


class _BrokerClient(aiomqtt.Client):
    """A client that tells what the broker refuses; aiomqtt passes over the reasons of PUBACK."""

    report_refusal: Callable[[str], None]

    def _on_publish(self, *about: Any) -> None:  # noqa: ANN401 - paho's own, in its order
        # Which message it was is not known here: its number is the client's own.
        for said in about:
            if isinstance(said, ReasonCode) and said.is_failure:
                self.report_refusal(f"publishing ({said})")
        super()._on_publish(*about)


def connect_broker(
    address: BrokerAddress,
    *,
    will: tuple[str, bytes, bool],
    report_refusal: Callable[[str], None],
    more_id: str = "",
) -> aiomqtt.Client:
    """Make a client; entering it connects.

    Args:
        address: of the broker.
        will: topic and payload that the broker publishes when it has lost the hub, and whether it
            keeps it.
        report_refusal: is told what the broker does not let the hub do.
        more_id: is added to the client's name at the broker.

    Raises:
        OSError: a file of certificates, or of the password, cannot be read.

    """
    password = read_secret(address.password_file) if address.password_file else None
    asked = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]
    # Nothing waits at the broker for a hub that is away: old commands must not move anything.
    asked.SessionExpiryInterval = 0
    asked.MaximumPacketSize = _MOST_PACKET
    client = _BrokerClient(
        address.host,
        address.number,
        username=address.username or None,
        password=password,
        identifier=address.client_id + more_id,
        protocol=aiomqtt.ProtocolVersion.V5,
        clean_start=True,
        properties=asked,
        will=aiomqtt.Will(will[0], will[1], qos=1, retain=will[2]),
        timeout=_ANSWER_S,
        keepalive=_KEEPALIVE_S,
        max_queued_incoming_messages=_MOST_INCOMING,
        tls_context=_make_context(address),
    )
    client.report_refusal = report_refusal
    return client


async def subscribe_commands(
    client: aiomqtt.Client, filters: list[str], *, report_refusal: Callable[[str], None]
) -> None:
    """Listen to topics, at most once for each message, and to nothing that was kept."""
    options = SubscribeOptions(
        qos=0,
        noLocal=True,
        # What is published to be kept is known by it, and refused.
        retainAsPublished=True,
        retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND,
    )
    for name in filters:
        for code in await client.subscribe(name, options=options):
            if isinstance(code, ReasonCode) and code.is_failure:
                report_refusal(f"listening to {name} ({code})")


def read_message(message: aiomqtt.Message, tree: TopicTree) -> InboundMessage | None:
    """Give what a message asks for; None: nothing."""
    topic = str(message.topic)
    asked = tree.read_command(topic)
    if asked is None:
        return None
    correlation = getattr(message.properties, "CorrelationData", b"")
    return InboundMessage(asked, topic, message.payload, bool(message.retain), correlation)


def answer_properties(correlation: bytes) -> Properties | None:
    """Give the properties of an answer."""
    if not correlation:
        return None
    found = Properties(PacketTypes.PUBLISH)  # type: ignore[no-untyped-call]
    found.CorrelationData = correlation
    return found


def _make_context(address: BrokerAddress) -> ssl.SSLContext | None:
    if not address.tls:
        return None
    # The broker's certificate and name are checked; there is no way to leave that out.
    return ssl.create_default_context(cafile=address.ca or None)
