"""One site at Sparkplug's edge node: its devices, and commands that are written to them."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import msgspec

from talaia.hub.clients.mqtt.asked_commands import InboundMessage, RefusedMessage
from talaia.hub.clients.mqtt.command_relay import CommandRelay
from talaia.hub.clients.mqtt.publication import SitePublication, make_publication
from talaia.hub.clients.sparkplug.device_metrics import DeviceMetrics
from talaia.wire.mqtt.topic_tree import CommandTopic, TopicTree

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.mqtt.broker_settings import SiteChoice
    from talaia.hub.clients.sparkplug.device_metrics import ControlMetric
    from talaia.wire.browser import ToBrowser
    from talaia.wire.sparkplug.payloads import ReadMetric

__all__ = ["SiteMetrics", "command_payload"]

# Names of topics are not used here: Sparkplug has its own.
_NO_TREE = TopicTree("")


class SiteMetrics:
    """See `ClientSession`: its client is the broker.

    Attributes:
        devices: by their names at the broker.

    """

    def __init__(
        self,
        connection: ClientConnection,
        *,
        choice: SiteChoice,
        report_refused: Callable[[InboundMessage, RefusedMessage], None],
        clock: Clock,
    ) -> None:
        """Publish what ``connection`` gives its account of ``choice``."""
        self.devices: dict[str, DeviceMetrics] = {}
        self._connection = connection
        self._choice = choice
        self._live = connection.live
        # Of the description that is published.
        self._edition: str | None = None
        self._publication = SitePublication()
        self._relay = CommandRelay(
            connection, clock, answer=self._answer_command, report_refused=report_refused
        )

    @property
    def is_outdated(self) -> bool:
        """Whether the site is described anew since `describe`."""
        return self._live.edition != self._edition

    def describe(self, first_alias: int) -> int:
        """Describe all devices anew, none of them born; give the first alias that is free."""
        self._edition = self._live.edition
        self._publication = make_publication(
            self._connection.description,
            self._live.channels,
            grants=self._connection.who.grants,
            choice=self._choice,
            tree=_NO_TREE,
            discovery=None,
        )
        self.devices = {}
        for device in self._publication.devices:
            metrics = DeviceMetrics(self._live, device, self._publication, first_alias=first_alias)
            first_alias = metrics.end_alias
            self.devices[metrics.name] = metrics
        return first_alias

    def write_metric(
        self, topic: str, device: DeviceMetrics, metric: ReadMetric, *, retained: bool
    ) -> None:
        """Do what a written metric asks, or say why not."""
        control = device.find_control(metric)
        if control is None:
            # Told alike whether it is not there, cannot be written or is not for the account.
            asked = CommandTopic(self._live.name, _device_of(device), metric.name or "?")
            message = InboundMessage(asked, topic, b"", retained, b"")
            self._relay.refuse_message(
                message, RefusedMessage(f"{metric.name or metric.alias} cannot be written")
            )
            return
        # A switch that goes back asks for nothing.
        if not metric.value and not (control.command and isinstance(metric.value, str)):
            return
        asked = CommandTopic(self._live.name, _device_of(device), control.command)
        payload = command_payload(control, metric)
        message = InboundMessage(asked, f"{topic} {metric.name}", payload, retained, b"")
        self._relay.receive_message(message, self._publication)

    def _answer_command(self, asked: CommandTopic, payload: bytes, _correlation: bytes) -> None:
        device = self.devices.get(f"{asked.site}.{asked.device}")
        if device is not None:
            said = {"command": asked.command or "Stop", **msgspec.json.decode(payload)}
            device.set_answer(msgspec.json.encode(said).decode())

    async def read_client(self) -> None:
        """Wait until cancelled: the edge node reads for all sites."""
        await asyncio.Event().wait()

    async def deliver_message(self, message: ToBrowser) -> None:
        """Tell the broker what became of what it asked; all else is read where it stands."""
        self._relay.deliver_message(message)

    async def warn_person(self, text: str) -> None:
        """Tell nobody: nothing is driven by MQTT."""

    async def close_client(self, code: int) -> None:
        """Leave the broker's connection to the other sites."""


def _device_of(device: DeviceMetrics) -> str:
    return device.name.split(".", 1)[1]


def command_payload(control: ControlMetric, metric: ReadMetric) -> bytes:
    """Write a command as the topics under the prefix have it, so that the same rules judge it."""
    said: dict[str, object] = {}
    # Without one it is refused, as everywhere: when it was asked for is not known.
    if metric.time_ms is not None:
        said["time"] = metric.time_ms / 1000
    text = metric.value if isinstance(metric.value, str) else ""
    if control.command and text:
        try:
            # Read here: what is put in as it stands could bring keys of its own with it.
            said["args"] = msgspec.json.decode(text)
        except (msgspec.DecodeError, RecursionError, UnicodeError):
            # No arguments; it is refused as such.
            said["args"] = text
    return msgspec.json.encode(said)
