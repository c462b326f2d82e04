"""Devices of an MQTT broker's topics, or of a server's address: proposed from what a probe heard.

Pure. A topic whose message holds several values is a device; topics of one value each belong to
the level above them, as ``roof/wind`` and ``roof/rain`` to *roof*.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import msgspec

from talaia.model.connection import HttpConnection, HttpSource, MqttConnection, MqttSource
from talaia.model.discovery.ros_units import readable_name, word_of
from talaia.model.discovery.topic_words import free_word, path_in_words
from talaia.model.site import Device, Signal, SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.connection import Connection
    from talaia.model.discovery.probe_report import FieldFound, Found, TopicFound

__all__ = ["connection_of", "json_devices", "json_left_out"]

# More than a page of tiles is no first page.
_MOST_PRIMARY = 12
_POLL_S = 5.0
# Of a topic that was heard once: it speaks now and then (s).
_RARE_S = 3600.0
_LOOPBACK = ("localhost", "::1")


def connection_of(found: Found) -> tuple[str, Connection] | None:
    """Name the connection of what was found; None: it is of another protocol."""
    if found.protocol == "mqtt":
        return "broker", MqttConnection(
            url=found.url, user=found.user, password_file=found.password_file, ca=found.ca
        )
    if found.protocol == "http":
        # The path is the signals' own: one server has several addresses.
        parts = urlsplit(found.url)
        host = parts.hostname or ""
        return "server", HttpConnection(
            url=f"{parts.scheme}://{parts.netloc}",
            poll=_POLL_S,
            user=found.user,
            password_file=found.password_file,
            token_file=found.token_file,
            ca=found.ca,
            # Whoever asks for it by this name means this computer.
            here=host in _LOOPBACK or host.startswith("127."),
        )
    return None


def json_devices(found: Found) -> dict[str, Device]:
    """Propose the devices, by their words."""
    known = connection_of(found)
    if known is None:
        return {}
    # By name of the device: its signals in the order of the topics.
    signals: dict[str, dict[str, Signal]] = {}
    for topic in found.topics:
        # What cannot be read is told by `json_left_out`.
        if topic.problem or not topic.fields:
            continue
        own = signals.setdefault(_device_name(topic, found), {})
        for field in topic.fields:
            # Two fields may be one word: ``a-b`` and ``a.b``.
            name = _signal_name(topic, field)
            own[free_word(word_of(name), own)] = _signal_of(found, topic, field, name)
    devices: dict[str, Device] = {}
    # Topics come in the order of their names, so the first page does not change by itself.
    room = _MOST_PRIMARY
    for name, own in signals.items():
        shown, room = _with_primary(own, room)
        word = free_word(word_of(name), devices)
        devices[word] = Device(name=name, connection=known[0], signals=shown)
    return devices


def json_left_out(found: Found) -> Iterator[str]:
    """Say what is in no device, and why."""
    if connection_of(found) is None:
        return
    for topic in found.topics:
        if topic.problem:
            yield f"{topic.topic}: {topic.problem}"
        yield from (f"{topic.topic} {what}" for what in topic.left_out)


def _device_name(topic: TopicFound, found: Found) -> str:
    if found.protocol == "http":
        path = urlsplit(topic.topic).path.strip("/")
        host = urlsplit(found.url).hostname or "server"
        # An address of the root alone says nothing but where it is.
        return readable_name(path.rpartition("/")[2]) or host
    levels = [level for level in topic.topic.split("/") if level]
    alone = len(topic.fields) == 1 and not topic.fields[0].path
    # A topic of one level that is one value has nothing above it.
    named = levels[:-1] if alone and len(levels) > 1 else levels
    return " ".join(readable_name(level) or level for level in named[-2:])[:80] or "Broker"


def _signal_name(topic: TopicFound, field: FieldFound) -> str:
    if field.path:
        return path_in_words(field.path.removeprefix("$").replace("'", ""))[:80] or "Value"
    return readable_name(topic.topic.rstrip("/").rpartition("/")[2])[:80] or "Value"


def _signal_of(found: Found, topic: TopicFound, field: FieldFound, name: str) -> Signal:
    source = (
        MqttSource(topic=topic.topic, path=field.path)
        if found.protocol == "mqtt"
        else HttpSource(get=topic.topic, path=field.path)
    )
    age = 4 * _POLL_S if found.protocol == "http" else _age_of(topic)
    # A truth has no words of its own in JSON.
    if field.words or field.type == "boolean":
        words = field.words or ("off", "on")
        return Signal(name=name, type=SignalType.STATE, states=words, source=source, max_age=age)
    if field.type == "text":
        return Signal(name=name, type=SignalType.TEXT, source=source, max_age=age)
    # Only what differs is set: the description that is written stays short.
    if field.scale != 1.0:
        return Signal(name=name, unit=field.unit, scale=field.scale, source=source, max_age=age)
    return Signal(name=name, unit=field.unit, source=source, max_age=age)


def _with_primary(own: dict[str, Signal], room: int) -> tuple[dict[str, Signal], int]:
    """Put what tells something on the first page, as far as there is room."""
    shown = {}
    for word, signal in own.items():
        # A text fills a tile and tells little from afar.
        primary = room > 0 and signal.type is not SignalType.TEXT
        room -= primary
        shown[word] = msgspec.structs.replace(signal, primary=primary)
    return shown, room


def _age_of(topic: TopicFound) -> float:
    """Give how old a value may be before it is stale (s): five times its usual spacing."""
    if topic.rate > 0:
        return min(max(round(5.0 / topic.rate, 1), 2.0), _RARE_S)
    # What a broker keeps holds until it is said anew.
    return 0.0 if topic.latched else _RARE_S
