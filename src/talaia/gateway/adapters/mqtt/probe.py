"""Looks at an MQTT broker: hears all topics that it may, for a while. It publishes nothing."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urlsplit

import aiomqtt

from talaia.gateway.adapters.credentials import read_authorities, read_secret
from talaia.gateway.adapters.json_signals import parse_payload
from talaia.gateway.errors import AdapterLost, FieldError
from talaia.model.discovery.json_fields import MOST_FIELDS, fields_of_json
from talaia.model.discovery.probe_report import FORMAT, FieldFound, Found, TopicFound

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["BrokerLogin", "probe_broker"]

_TIMEOUT_S = 5.0
_PORTS = {"mqtt": 1883, "mqtts": 8883}
# More topics are a plant and not a robot; the rest is left out, and said.
_MOST_TOPICS = 2000
# Of one message (bytes), as the adapter takes it.
_MOST_PAYLOAD = 256 * 1024
# What programs tell each other by it is no device's.
_OF_PROGRAMS = {
    "homeassistant": "it is for Home Assistant's discovery",
    "spBv1.0": "it is Sparkplug, which is no JSON",
}
_REFUSED = 0x80


class BrokerLogin(NamedTuple):
    """Where a broker is, and how to sign in; files are meant from ``folder`` on."""

    url: str
    folder: Path
    user: str = ""
    password_file: str = ""
    ca: str = ""


class _Heard:
    """A topic: how often, since when, and the newest message."""

    def __init__(self) -> None:
        self.count = 0
        # Of messages that were said while we listened (monotonic).
        self.first_s = self.last_s = 0.0
        self.payload = b""
        # The broker had one before we came.
        self.kept = False

    def add_message(self, payload: bytes, now_s: float, *, kept: bool) -> None:
        self.payload = payload
        self.kept = self.kept or kept
        # When a kept message was said nobody knows.
        if kept:
            return
        self.first_s = self.first_s or now_s
        self.last_s = now_s
        self.count += 1

    @property
    def rate(self) -> float:
        span_s = self.last_s - self.first_s
        return (self.count - 1) / span_s if self.count > 1 and span_s > 0 else 0.0


def probe_broker(login: BrokerLogin, seconds: float) -> Found:
    """Listen for a while.

    Raises:
        AdapterLost: the broker is not reached, or does not let us listen.
        SettingsError: the password or the authorities cannot be read.

    """
    return asyncio.run(_probe(login, seconds))


async def _probe(login: BrokerLogin, seconds: float) -> Found:
    heard: dict[str, _Heard] = {}
    left_out: set[str] = set()
    try:
        async with _make_client(login) as client:
            for code in await client.subscribe("#"):
                if (code if isinstance(code, int) else code.value) >= _REFUSED:
                    raise AdapterLost(
                        f"the broker at {login.url} does not let this user listen to all topics;"
                        " look at its access list, or describe the topics by hand"
                    )
            # All that is kept comes at once; the rest as it is said.
            try:
                async with asyncio.timeout(seconds):
                    await _listen(client, heard, left_out)
            except TimeoutError:
                pass
    except aiomqtt.MqttError as error:
        raise AdapterLost(f"no MQTT broker takes us at {login.url} ({str(error)[:200]})") from error
    topics = [_topic_found(topic, one) for topic, one in sorted(heard.items())]
    # As one line: a list of thousands would hide what is there.
    if left_out:
        problem = f"and {len(left_out)} more topics: over {_MOST_TOPICS} are not listed"
        topics.append(TopicFound("…", "", problem=problem))
    return Found(
        talaia_probe=FORMAT,
        protocol="mqtt",
        where=f"the MQTT broker at {login.url}",
        seconds=seconds,
        topics=tuple(topics),
        url=login.url,
        user=login.user,
        password_file=login.password_file,
        ca=login.ca,
    )


async def _listen(client: aiomqtt.Client, heard: dict[str, _Heard], left_out: set[str]) -> None:
    async for message in client.messages:
        topic, payload = message.topic.value, bytes(message.payload)
        if topic not in heard and len(heard) >= _MOST_TOPICS:
            # Counted, and not without end.
            if len(left_out) < _MOST_TOPICS:
                left_out.add(topic)
            continue
        one = heard.setdefault(topic, _Heard())
        # One byte more than the most, by which it is known as too long.
        one.add_message(payload[: _MOST_PAYLOAD + 1], time.monotonic(), kept=bool(message.retain))


def _make_client(login: BrokerLogin) -> aiomqtt.Client:
    parts = urlsplit(login.url)
    password = read_secret("password", login.folder, file=login.password_file)
    secure = parts.scheme == "mqtts"
    return aiomqtt.Client(
        parts.hostname or "",
        parts.port or _PORTS[parts.scheme],
        username=login.user or None,
        password=password or None,
        protocol=aiomqtt.ProtocolVersion.V5,
        timeout=_TIMEOUT_S,
        max_queued_incoming_messages=10_000,
        tls_context=read_authorities(login.folder, login.ca) if secure else None,
    )


def _topic_found(topic: str, heard: _Heard) -> TopicFound:
    problem = _OF_PROGRAMS.get(topic.partition("/")[0], "")
    if not problem and len(heard.payload) > _MOST_PAYLOAD:
        problem = f"its message is longer than {_MOST_PAYLOAD // 1024} KiB"
    fields: tuple[FieldFound, ...] = ()
    kind = ""
    if not problem:
        try:
            read = parse_payload(heard.payload)
        except FieldError:
            problem = "its message is neither JSON nor text"
        else:
            kind = "JSON" if read.is_json and isinstance(read.value, dict | list) else "value"
            fields = fields_of_json(
                read.value if read.is_json else read.text, topic.rpartition("/")[2]
            )
    more = (f"has more than {MOST_FIELDS} fields",) if len(fields) == MOST_FIELDS else ()
    return TopicFound(
        topic,
        kind,
        publishers=1,
        rate=round(heard.rate, 3),
        latched=heard.kept,
        fields=fields,
        left_out=more,
        problem=problem,
    )
