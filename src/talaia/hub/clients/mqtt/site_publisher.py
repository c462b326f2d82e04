"""One site at the broker: its newest values, how it stands, and commands for it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple, Protocol

from talaia.clock import SECOND
from talaia.hub.clients.mqtt.asked_commands import RefusedMessage, judge_command, judge_stop
from talaia.hub.clients.mqtt.publication import SitePublication, make_publication
from talaia.wire.browser import CommandUpdate, StopUpdate
from talaia.wire.frames import CommandPhase
from talaia.wire.mqtt.payloads import (
    OFFLINE,
    ONLINE,
    ValueQuality,
    encode_answer,
    encode_value,
)

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.mqtt.asked_commands import InboundMessage
    from talaia.hub.clients.mqtt.broker_settings import SiteChoice
    from talaia.hub.clients.mqtt.publication import PublishedChannel
    from talaia.hub.live.last_values import Latest
    from talaia.wire.browser import ToBrowser
    from talaia.wire.mqtt.home_assistant import DiscoveryWriter
    from talaia.wire.mqtt.topic_tree import TopicTree

__all__ = ["BrokerOutput", "SitePublisher"]

# Commands whose end is not known yet.
_MOST_WAITING = 100
_GOING_ON = frozenset({CommandPhase.ACCEPTED, CommandPhase.RUNNING})


class BrokerOutput(Protocol):
    """The way to the broker; nothing here waits for it."""

    def set_payload(self, topic: str, payload: bytes) -> None:
        """Have a topic hold ``payload``."""
        ...

    def keep_only(self, site: str, topics: set[str]) -> None:
        """Clear every topic of a site but these."""
        ...

    def send_answer(self, topic: str, payload: bytes, correlation: bytes) -> None:
        """Tell what became of a command, to whoever hears it now."""
        ...

    def report_refused(self, message: InboundMessage, refused: RefusedMessage) -> None:
        """Write down that something was refused."""
        ...


class _Waiting(NamedTuple):
    topic: str
    correlation: bytes


class SitePublisher:
    """See `ClientSession`: its client is the broker."""

    def __init__(
        self,
        connection: ClientConnection,
        output: BrokerOutput,
        *,
        choice: SiteChoice,
        tree: TopicTree,
        discovery: DiscoveryWriter | None,
        every_s: float,
        clock: Clock,
    ) -> None:
        """Publish by ``output`` what ``connection`` gives its account of ``choice``."""
        self._connection = connection
        self._output = output
        self._choice = choice
        self._tree = tree
        self._discovery = discovery
        self._every_s = every_s
        self._clock = clock
        self._live = connection.live
        # Of the description that is published.
        self._edition: str | None = None
        self._publication = SitePublication()
        # By place: when the value came that was written last (monotonic ns), and how good it was.
        self._written: dict[int, tuple[int, ValueQuality]] = {}
        # By the command's or STOP's id.
        self._waiting: dict[str, _Waiting] = {}

    # ── to the broker ──

    async def read_client(self) -> None:
        """Publish until cancelled; what the broker sends comes by `receive_message`."""
        while True:
            self.publish_changes()
            await asyncio.sleep(self._every_s)

    def publish_changes(self) -> None:
        """Publish what is not as it was."""
        if self._live.edition != self._edition:
            self._describe_again()
        live = self._live
        if self._publication.site_state:
            self._set_state(self._publication.site_state, on=live.online)
        for device, topic in self._publication.devices.items():
            self._set_state(topic, on=live.online and device not in live.current.unreached)
        now_ns = self._clock.monotonic_ns()
        latest = live.latest
        for channel in self._publication.channels:
            self._publish_channel(channel, latest, now_ns)

    def _describe_again(self) -> None:
        self._edition = self._live.edition
        self._written.clear()
        self._publication = make_publication(
            self._connection.description,
            self._live.channels,
            grants=self._connection.who.grants,
            choice=self._choice,
            tree=self._tree,
            discovery=self._discovery,
        )
        self._output.keep_only(self._live.name, set(self._publication.retained_topics()))
        for topic, payload in self._publication.discovery.items():
            self._output.set_payload(topic, payload)

    def _set_state(self, topic: str, *, on: bool) -> None:
        self._output.set_payload(topic, ONLINE if on else OFFLINE)

    def _publish_channel(self, channel: PublishedChannel, latest: Latest, now_ns: int) -> None:
        arrived_ns = int(latest.arrived_ns[channel.at])
        # Nothing was heard of it yet.
        if arrived_ns < 0:
            return
        quality = self._quality_of(channel, (now_ns - arrived_ns) / SECOND)
        if self._written.get(channel.at) == (arrived_ns, quality):
            return
        self._written[channel.at] = arrived_ns, quality
        value: float | str
        if channel.text:
            value = latest.texts.get(channel.at, "")
        else:
            value = _word_of(float(latest.value[channel.at]), channel.states)
        payload = encode_value(
            value, unit=channel.unit, time_us=int(latest.time_us[channel.at]), quality=quality
        )
        self._output.set_payload(channel.topic, payload)

    def _quality_of(self, channel: PublishedChannel, age_s: float) -> ValueQuality:
        live = self._live
        if not live.online or channel.device in live.current.unreached:
            return ValueQuality.LOST
        stale = channel.max_age and age_s > channel.max_age
        return ValueQuality.STALE if stale else ValueQuality.GOOD

    # ── from the broker ──

    def receive_message(self, message: InboundMessage) -> None:
        """Do what a message asks, or say why not."""
        if not message.asked.command:
            self._press_stop(message)
            return
        now_us = self._clock.wall_ns() // 1000
        judged = judge_command(message, self._connection.description, self._publication, now_us)
        if isinstance(judged, RefusedMessage):
            self._refuse(message, judged)
            return
        if judged.id in self._waiting or len(self._waiting) >= _MOST_WAITING:
            self._refuse(message, RefusedMessage("this command is under way already"))
            return
        # Before it is asked: its end may come at once.
        topic = self._tree.command_answer(*message.asked)
        self._waiting[judged.id] = _Waiting(topic, message.correlation)
        problem = self._connection.request(judged)
        if problem is not None:
            del self._waiting[judged.id]
            self._refuse(message, RefusedMessage(problem.message))

    def _press_stop(self, message: InboundMessage) -> None:
        refused = judge_stop(message, self._publication)
        if refused is not None:
            self._refuse(message, refused)
            return
        press, why = self._connection.press_stop(message.asked.device)
        if why:
            self._refuse(message, RefusedMessage(why))
            return
        if len(self._waiting) < _MOST_WAITING:
            topic = self._tree.stop_answer(message.asked.site, message.asked.device)
            self._waiting[press] = _Waiting(topic, message.correlation)

    def _refuse(self, message: InboundMessage, refused: RefusedMessage) -> None:
        self._output.report_refused(message, refused)
        if refused.quiet:
            return
        site, device, command = message.asked
        topic = (
            self._tree.command_answer(site, device, command)
            if command
            else self._tree.stop_answer(site, device)
        )
        payload = encode_answer("", CommandPhase.REFUSED.value, refused.why)
        self._output.send_answer(topic, payload, message.correlation)

    async def deliver_message(self, message: ToBrowser) -> None:
        """Tell the broker what became of what it asked; all else is read where it stands."""
        match message:
            case CommandUpdate() if message.id in self._waiting:
                going_on = message.phase in _GOING_ON
                waiting = self._waiting[message.id] if going_on else self._waiting.pop(message.id)
                said = (message.id, message.phase.value, message.message)
                payload = encode_answer(*said, message.progress)
                self._output.send_answer(waiting.topic, payload, waiting.correlation)
            case StopUpdate() if message.id in self._waiting and message.latched:
                waiting = self._waiting.pop(message.id)
                phase = CommandPhase.SUCCEEDED.value
                payload = encode_answer(message.id, phase, "STOP is on")
                self._output.send_answer(waiting.topic, payload, waiting.correlation)
            case _:
                pass

    async def warn_person(self, text: str) -> None:
        """Tell nobody: nothing is driven by MQTT."""

    async def close_client(self, code: int) -> None:
        """Leave the broker's connection to the other sites."""


def _word_of(value: float, states: tuple[str, ...]) -> float | str:
    """Give the word of a state, where it has words."""
    # NaN compares with nothing, so it stays the number that is none.
    return states[int(value)] if states and 0 <= value < len(states) else value
