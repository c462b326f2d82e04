"""Topics that one rosbridge client publishes: velocities drive a device, the rest are commands."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.clients.key_velocity import read_key
from talaia.hub.clients.published_commands import PublishedCommands
from talaia.hub.clients.published_message import read_fields
from talaia.hub.clients.published_velocity import read_velocity
from talaia.hub.clients.rosbridge.offer import full_type
from talaia.hub.clients.rosbridge.wanted_topics import absolute_name
from talaia.model.site import DriveMessage

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.clients.account_offer import DrivenTopic
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.robot_names import RobotName
    from talaia.hub.clients.rosbridge.offer import RosbridgeOffer
    from talaia.hub.clients.rosbridge.output import RosbridgeOutput
    from talaia.wire.browser import CommandUpdate
    from talaia.wire.rosbridge import client_messages as said

__all__ = ["PublishedTopics"]

_MOST_ADVERTISED = 1000


class PublishedTopics:
    """What one client advertises and publishes."""

    def __init__(
        self, connection: ClientConnection, output: RosbridgeOutput, *, clock: Clock
    ) -> None:
        """Drive and ask through ``connection``; refusals are told by ``output``."""
        self._connection = connection
        self._output = output
        self._commands = PublishedCommands(connection, clock)
        # By topic: of which type the client said that it publishes it.
        self._advertised: dict[str, str] = {}
        # What the person was told last of why nothing comes of it: each message would repeat it.
        self._told = ""

    async def note_advertised(
        self, message: said.RosbridgeAdvertise, offer: RosbridgeOffer
    ) -> None:
        """Note a topic that the client is going to publish."""
        topic = absolute_name(message.topic)
        if topic not in offer.driven and topic not in offer.listened:
            await self._refuse_message(f"nothing here listens to {message.topic}", message.id)
        elif len(self._advertised) < _MOST_ADVERTISED or topic in self._advertised:
            self._advertised[topic] = full_type(message.type)

    def forget_advertised(self, message: said.RosbridgeUnadvertise) -> None:
        """Forget a topic; one that was not advertised is no fault."""
        self._advertised.pop(absolute_name(message.topic), None)

    async def publish_message(self, message: said.RosbridgePublish, offer: RosbridgeOffer) -> None:
        """Drive by a message or ask for its command, or say why not."""
        topic = absolute_name(message.topic)
        driven, listened = offer.driven.get(topic), offer.listened.get(topic)
        if driven is not None:
            why = self._drive(driven, topic, bytes(message.msg))
        elif listened is not None:
            why = self._ask_command(listened, bytes(message.msg))
        else:
            await self._refuse_message(f"nothing here listens to {message.topic}", message.id)
            return
        if why:
            await self._refuse_message(f"{message.topic}: {why}", message.id)
        else:
            self._told = ""

    async def follow_command(self, update: CommandUpdate) -> None:
        """Tell of a command that did not succeed, if one of this client's messages asked for it."""
        if why := self._commands.read_update(update):
            await self._output.tell_status("error", why)

    def _drive(self, driven: DrivenTopic, topic: str, message: bytes) -> str:
        kind = self._advertised.get(topic, driven.type)
        rule = self._connection.description.devices[driven.device].drive
        if kind == DriveMessage.KEYS.value and rule is not None:
            velocity = read_key(message, rule)
        else:
            velocity = read_velocity("json", kind, message)
        if isinstance(velocity, str):
            return velocity
        return self._connection.publish_drive(
            driven.device,
            linear=velocity.linear,
            angular=velocity.angular,
            lateral=velocity.lateral,
        )

    def _ask_command(self, topic: RobotName, message: bytes) -> str:
        kind = self._advertised.get(topic.name, topic.type)
        if kind != topic.type:
            return f"it is of the type {topic.type}, not {kind}"
        try:
            read = read_fields(message)
        except ValueError as error:
            return str(error)
        return self._commands.ask_command(topic, read)

    async def _refuse_message(self, why: str, message_id: str | int | None) -> None:
        """Say why what is published is refused, once for as long as it stays so."""
        if why != self._told:
            self._told = why
            await self._output.tell_status("error", why, message_id)
