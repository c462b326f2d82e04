"""What goes to the broker: the newest of each topic, and answers; sent as fast as it takes them."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from typing import TYPE_CHECKING

from talaia.hub.clients.mqtt.broker_client import answer_properties
from talaia.hub.clients.mqtt.retained_topics import RetainedTopics

if TYPE_CHECKING:
    from collections.abc import Collection

    import aiomqtt

    from talaia.hub.clients.mqtt.known_topics import KnownTopics

__all__ = ["BrokerFeed"]

_LOG = logging.getLogger(__name__)
# Messages that wait for the broker's word at once.
_AT_ONCE = 8
# Answers that wait; the oldest are left out.
_MOST_ANSWERS = 200


class BrokerFeed:
    """Bounded by the number of topics, however slow or absent the broker is."""

    def __init__(self, broker: str, known: KnownTopics) -> None:
        """Feed ``broker``; ``known`` keeps over restarts what it may hold."""
        self._broker = broker
        self._file = known
        self._topics = RetainedTopics(known.load_topics(broker))
        # The revision of what was written down.
        self._saved = self._topics.revision
        # Topic, payload and correlation.
        self._answers: deque[tuple[str, bytes, bytes]] = deque(maxlen=_MOST_ANSWERS)
        # Something is to be sent.
        self._wake = asyncio.Event()
        # Nothing is to be sent, and all that was has been taken.
        self._drained = asyncio.Event()

    @property
    def holds_topics(self) -> bool:
        """Whether the broker may hold anything of ours."""
        return bool(self._topics.known)

    def set_payload(self, topic: str, payload: bytes) -> None:
        """Have a topic hold ``payload``."""
        self._topics.set_payload(topic, payload)
        self._signal_due()

    @property
    def known_topics(self) -> frozenset[str]:
        """All topics of ours that the broker may hold."""
        return self._topics.known

    def forget_topics(self, topics: Collection[str]) -> None:
        """Leave topics as they are at the broker: somebody else sees to them."""
        self._topics.forget_topics(topics)

    def keep_only(self, topics: Collection[str]) -> None:
        """Clear every topic but these."""
        self._topics.keep_only(topics)
        self._signal_due()

    def withhold_values(self) -> None:
        """Send nothing that is not set again."""
        self._topics.withhold_values()
        self._answers.clear()

    def send_answer(self, topic: str, payload: bytes, correlation: bytes = b"") -> None:
        """Send a message that is not kept, before what is."""
        self._answers.append((topic, payload, correlation))
        self._signal_due()

    def restart_connection(self) -> None:
        """Begin a connection; answers of the one before are of no use any more."""
        self._answers.clear()
        self._topics.restart_connection()
        self._signal_due()

    async def wait_drained(self) -> None:
        """Wait until the broker has taken all."""
        await self._drained.wait()

    async def send_due(self, client: aiomqtt.Client) -> None:
        """Send until cancelled.

        Raises:
            aiomqtt.MqttError: the broker does not take it.

        """
        while True:
            await self._wake.wait()
            self._wake.clear()
            while self._answers or self._topics.has_due:
                await self._send_batch(client)
            await self._save_known()
            if not self._wake.is_set():
                self._drained.set()

    def _signal_due(self) -> None:
        if self._answers or self._topics.has_due:
            self._drained.clear()
            self._wake.set()

    async def _send_batch(self, client: aiomqtt.Client) -> None:
        while self._answers:
            topic, payload, correlation = self._answers.popleft()
            await client.publish(topic, payload, qos=1, properties=answer_properties(correlation))
        batch: list[tuple[str, bytes]] = []
        while len(batch) < _AT_ONCE and (due := self._topics.take_due()) is not None:
            batch.append(due)
        # Before it is sent: what the broker holds is never unknown to the next run.
        await self._save_known()
        await asyncio.gather(
            *(client.publish(topic, payload, qos=1, retain=True) for topic, payload in batch)
        )
        for topic, payload in batch:
            if not payload:
                self._topics.confirm_cleared(topic)

    async def _save_known(self) -> None:
        revision = self._topics.revision
        if revision == self._saved:
            return
        known = self._topics.known
        try:
            await asyncio.to_thread(self._file.save_topics, self._broker, known)
        except OSError as error:
            # Publishing goes on; at worst a topic stays after it is gone here.
            _LOG.warning("which topics the broker holds cannot be written down: %s", error)
        self._saved = revision
