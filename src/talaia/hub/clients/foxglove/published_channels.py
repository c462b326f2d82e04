"""Channels of one Foxglove client's own: velocities that it publishes drive a device."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from talaia.hub.clients.published_velocity import read_velocity

if TYPE_CHECKING:
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.foxglove.offer import FoxgloveOffer
    from talaia.wire.foxglove.client_messages import (
        FoxgloveAdvertise,
        FoxgloveClientChannel,
        FoxglovePublish,
        FoxgloveUnadvertise,
    )

__all__ = ["PublishedChannels"]

# Of a status.
_WARNING, _ERROR = 1, 2
# Channels that a client publishes on.
_MOST_PUBLISHED = 1000


class SendsStatus(Protocol):
    """Tells the client's person something."""

    async def __call__(self, level: int, text: str, /) -> None:
        """Send a status of the protocol."""
        ...


class PublishedChannels:
    """What one client advertises and publishes."""

    def __init__(self, connection: ClientConnection, *, send_status: SendsStatus) -> None:
        """Drive through ``connection``; refusals are told by ``send_status``."""
        self._connection = connection
        self._send_status = send_status
        # By the client's number.
        self._channels: dict[int, FoxgloveClientChannel] = {}
        # What the person was told last of why it does not drive: each message would repeat it.
        self._told = ""

    async def add_channels(self, message: FoxgloveAdvertise, offer: FoxgloveOffer) -> None:
        """Note channels that the client is going to publish on."""
        for channel in message.channels:
            if len(self._channels) >= _MOST_PUBLISHED:
                await self._send_status(_WARNING, f"at most {_MOST_PUBLISHED} channels of your own")
                return
            # Also one that nothing listens to now: the description may change.
            self._channels[channel.id] = channel
            if channel.topic not in offer.driven:
                await self._send_status(_WARNING, f"nothing here listens to {channel.topic}")

    def remove_channels(self, message: FoxgloveUnadvertise) -> None:
        """Forget channels; one that is not there is no fault."""
        for number in message.channel_ids:
            self._channels.pop(number, None)

    async def publish_message(self, message: FoxglovePublish, offer: FoxgloveOffer) -> None:
        """Drive by a message, or say why not."""
        channel = self._channels.get(message.channel_id)
        if channel is None:
            await self._refuse_message(f"channel {message.channel_id} is not advertised")
            return
        # Only of devices that the account may view: other topics are as if nobody listened.
        device = offer.driven.get(channel.topic)
        if device is None:
            await self._refuse_message(f"nothing here listens to {channel.topic}")
            return
        # By the type that the client named when it advertised the channel.
        velocity = read_velocity(channel.encoding, channel.schema_name, message.data)
        if isinstance(velocity, str):
            await self._refuse_message(f"{channel.topic}: {velocity}")
            return
        # An admin's word, the lease and the limits are looked at there.
        why = self._connection.publish_drive(
            device, linear=velocity.linear, angular=velocity.angular
        )
        if why:
            await self._refuse_message(f"{channel.topic}: {why}")
        else:
            self._told = ""

    async def _refuse_message(self, why: str) -> None:
        """Say why a published message is refused, once for as long as it stays so."""
        if why != self._told:
            self._told = why
            await self._send_status(_ERROR, why)
