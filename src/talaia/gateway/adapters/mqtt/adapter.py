"""The MQTT adapter: reads the topics that the description names, and publishes nothing.

What a broker kept (retained) was said before we came, nobody knows when: it has the time of its
arrival and is shown, and interlocks get no reading of it. See decision 0078.
"""

from __future__ import annotations

import asyncio
import logging
from hashlib import sha256
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import aiomqtt
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

from talaia.gateway.adapters.credentials import read_authorities, read_secret
from talaia.gateway.adapters.json_signals import JsonSignals
from talaia.gateway.adapters.undriven_adapter import JsonAdapter
from talaia.gateway.adapters.unreadable_reports import UnreadableReports
from talaia.gateway.errors import AdapterLost
from talaia.gateway.ports import CommandOutcome
from talaia.model.connection import MqttConnection, MqttSource, source_as
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import AdapterContext, AdapterStatus
    from talaia.model.site import Signal

__all__ = ["MqttAdapter"]

log = logging.getLogger(__name__)
# A broker that is there answers within these (s); one that is gone is told after two of the second.
_TIMEOUT_S, _KEEPALIVE_S = 5.0, 5
# Larger messages a broker of MQTT 5 does not send us; sensors send some hundred bytes.
_MAX_PACKET = 256 * 1024
# Messages that wait to be read; what comes on top is dropped, as by a broker that is full.
_MAX_WAITING = 10_000
# Topics in one request: a thousand would not fit the packet that a small broker takes.
_TOPICS_AT_ONCE = 50
# Pace at which held-back values are given out, and samples at most.
_TURN_S = 0.05
# From here on an answer to a subscription is a refusal.
_REFUSED = 0x80
_PORTS = {"mqtt": 1883, "mqtts": 8883}


class MqttAdapter(JsonAdapter):
    """An `Adapter` for an MQTT broker; see `talaia.gateway.ports`."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what is to be read; `run` connects.

        Raises:
            SettingsError: the password or the certificate authorities cannot be read.

        """
        settings = scope.connection
        assert isinstance(settings, MqttConnection)  # noqa: S101 - the catalog has seen to it
        self._settings = settings
        self._status = status
        self._clock = context.clock
        self._unreadable = UnreadableReports(context.events)
        self._password = read_secret(
            "password",
            context.folder,
            file=settings.password_file,
            variable=settings.password_env,
        )
        secure = settings.url.startswith("mqtts:")
        self._tls = read_authorities(context.folder, settings.ca) if secure else None
        signals = JsonSignals(scope, _place_of, self._unreadable.report_unreadable)
        super().__init__(signals, context.samples, "mqtt")
        # By topic: of the newest message a hash, so that a broker which keeps it does not make
        # news of it with each new connection.
        self._newest: dict[str, bytes] = {}
        self._connected = False
        # Ends this connection for another one.
        self._again: asyncio.Event | None = None

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        where = self._settings.url
        try:
            async with self._make_client() as client:
                await self._serve_connection(client)
        except aiomqtt.MqttError as error:
            lost = (
                f"the MQTT broker at {where} is gone"
                if self._connected
                else (f"no MQTT broker takes us at {where}")
            )
            raise AdapterLost(f"{lost} ({str(error)[:200]})") from error
        finally:
            self._connected = False
            self._again = None
            self._signals.forget_readings()
        raise AdapterLost(f"the connection to the MQTT broker at {where} is made anew")

    def _make_client(self) -> aiomqtt.Client:
        settings = self._settings
        parts = urlsplit(settings.url)
        properties = None
        if settings.version == 5:
            # Its own type says nothing of what it takes.
            make: Callable[[int], Properties] = Properties
            properties = make(PacketTypes.CONNECT)
            properties.MaximumPacketSize = _MAX_PACKET
        return aiomqtt.Client(
            parts.hostname or "",
            parts.port or _PORTS[parts.scheme],
            username=settings.user or None,
            password=self._password or None,
            identifier=settings.client or None,
            protocol=aiomqtt.ProtocolVersion.V5
            if settings.version == 5
            else aiomqtt.ProtocolVersion.V311,
            # A session of before would bring what was said while nobody listened, as if it were
            # new. MQTT 5 begins anew by itself.
            clean_session=None if settings.version == 5 else True,
            timeout=_TIMEOUT_S,
            keepalive=_KEEPALIVE_S,
            max_queued_incoming_messages=_MAX_WAITING,
            properties=properties,
            tls_context=self._tls,
            logger=log,
        )

    async def _serve_connection(self, client: aiomqtt.Client) -> None:
        self._connected, again = True, asyncio.Event()
        self._again = again
        await self._subscribe_topics(client)
        self._status.up()
        parts = [
            asyncio.ensure_future(part)
            for part in (self._read_messages(client), self._keep_pace(), again.wait())
        ]
        try:
            done, _ = await asyncio.wait(parts, return_when=asyncio.FIRST_COMPLETED)
            for part in done:
                part.result()
        finally:
            for part in parts:
                part.cancel()
            await asyncio.gather(*parts, return_exceptions=True)

    async def _subscribe_topics(self, client: aiomqtt.Client) -> None:
        topics = [*self._signals.keys]
        for at in range(0, len(topics), _TOPICS_AT_ONCE):
            some = topics[at : at + _TOPICS_AT_ONCE]
            answers = await client.subscribe([(topic, 0) for topic in some])
            for topic, answer in zip(some, answers, strict=False):
                # MQTT 5 gives an object for each, MQTT 3 a number.
                code = answer if isinstance(answer, int) else getattr(answer, "value", 0)
                if code >= _REFUSED:
                    said = "the broker does not let us read it; look at its access list"
                    self._unreadable.report_once(topic, said)

    async def _read_messages(self, client: aiomqtt.Client) -> None:
        async for message in client.messages:
            topic, data = message.topic.value, bytes(message.payload)
            digest = sha256(data).digest()
            # Kept by the broker, and heard before: no news, nor is it of now.
            if message.retain and self._newest.get(topic) == digest:
                continue
            if topic in self._signals.keys:
                self._newest[topic] = digest
            now_us, now_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
            self._signals.read_payload(topic, data, now_us, now_ns, fresh=not message.retain)

    async def _keep_pace(self) -> None:
        while True:
            await asyncio.sleep(_TURN_S)
            self._signals.gather_due(self._clock.wall_ns() // 1000)
            self._publish_samples()

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Connect anew, for all its devices."""
        if self._again is None:
            said = "it is not connected; it is tried every second"
            done(CommandOutcome(CommandPhase.FAILED, said))
            return
        self._again.set()
        done(CommandOutcome(CommandPhase.SUCCEEDED, "it is connected anew"))


def _place_of(signal: Signal) -> tuple[str, str]:
    source = source_as(signal.source, MqttSource)
    return source.topic, source.path
