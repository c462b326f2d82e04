"""Channels of one Foxglove client's own: velocities drive a device, the rest are commands."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from talaia.hub.clients.published_commands import PublishedCommands
from talaia.hub.clients.published_message import read_published
from talaia.hub.clients.published_velocity import read_velocity
from talaia.hub.clients.robot_names import full_type

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.foxglove.offer import FoxgloveOffer
    from talaia.hub.clients.robot_names import RobotName
    from talaia.wire.browser import CommandUpdate
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

    def __init__(
        self, connection: ClientConnection, *, send_status: SendsStatus, clock: Clock
    ) -> None:
        """Drive and ask through ``connection``; refusals are told by ``send_status``."""
        self._connection = connection
        self._send_status = send_status
        self._commands = PublishedCommands(connection, clock)
        # By the client's number.
        self._channels: dict[int, FoxgloveClientChannel] = {}
        # What the person was told last of why nothing comes of it: each message would repeat it.
        self._told = ""

    async def add_channels(self, message: FoxgloveAdvertise, offer: FoxgloveOffer) -> None:
        """Note channels that the client is going to publish on."""
        for channel in message.channels:
            if len(self._channels) >= _MOST_PUBLISHED:
                await self._send_status(_WARNING, f"at most {_MOST_PUBLISHED} channels of your own")
                return
            # Also one that nothing listens to now: the description may change.
            self._channels[channel.id] = channel
            if channel.topic not in offer.driven and channel.topic not in offer.listened:
                await self._send_status(_WARNING, f"nothing here listens to {channel.topic}")

    def remove_channels(self, message: FoxgloveUnadvertise) -> None:
        """Forget channels; one that is not there is no fault."""
        for number in message.channel_ids:
            self._channels.pop(number, None)

    async def publish_message(self, message: FoxglovePublish, offer: FoxgloveOffer) -> None:
        """Drive by a message or ask for its command, or say why not."""
        channel = self._channels.get(message.channel_id)
        if channel is None:
            await self._refuse_message(f"channel {message.channel_id} is not advertised")
            return
        # Only of devices that the account may view: other topics are as if nobody listened.
        device, listened = offer.driven.get(channel.topic), offer.listened.get(channel.topic)
        if device is not None:
            why = self._drive(device, channel, message.data)
        elif listened is not None:
            why = self._ask_command(listened, channel, message.data)
        else:
            await self._refuse_message(f"nothing here listens to {channel.topic}")
            return
        if why:
            await self._refuse_message(f"{channel.topic}: {why}")
        else:
            self._told = ""

    async def follow_command(self, update: CommandUpdate) -> None:
        """Tell of a command that did not succeed, if one of this client's messages asked for it."""
        if why := self._commands.read_update(update):
            await self._send_status(_ERROR, why)

    def _drive(self, device: str, channel: FoxgloveClientChannel, data: bytes) -> str:
        # By the type that the client named when it advertised the channel.
        velocity = read_velocity(channel.encoding, channel.schema_name, data)
        if isinstance(velocity, str):
            return velocity
        # An admin's word, the lease and the limits are looked at there.
        return self._connection.publish_drive(
            device,
            linear=velocity.linear,
            angular=velocity.angular,
            lateral=velocity.lateral,
        )

    def _ask_command(self, topic: RobotName, channel: FoxgloveClientChannel, data: bytes) -> str:
        kind = full_type(channel.schema_name)
        if kind and kind != topic.type:
            return f"it is of the type {topic.type}, not {kind[:100]}"
        try:
            message = read_published(channel.encoding, topic.type, data)
        except ValueError as error:
            return str(error)
        return self._commands.ask_command(topic, message)

    async def _refuse_message(self, why: str) -> None:
        """Say why a published message is refused, once for as long as it stays so."""
        if why != self._told:
            self._told = why
            await self._send_status(_ERROR, why)
