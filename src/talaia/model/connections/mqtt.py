"""An MQTT broker: topics, and fields of the JSON in them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.base import Shape, SourceShape
from talaia.model.checks.identifiers import Finding
from talaia.model.closed_lists import SignalType
from talaia.model.connections.addresses import url_fits
from talaia.model.connections.json_path import json_path_fits
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.rules import KindRules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Signal

__all__ = ["MqttConnection", "MqttRules", "MqttSource"]

# MQTT's own bound, in bytes of UTF-8.
_MAX_TOPIC = 65_535


class MqttConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="mqtt"):
    """An MQTT broker; topics are read, and nothing is published.

    Attributes:
        url: ``mqtt://broker.local:1883``, or ``mqtts://`` with TLS (8883); without a password.
        user: whom the broker knows us as; empty for nobody.
        password_file: a file that holds that user's password; empty for none.
        password_env: a variable that holds it, instead of a file.
        ca: file of certificate authorities for ``mqtts://``; empty takes the system's.
        client: our name at the broker, which no other client may have; empty takes one that the
            broker gives.
        version: 5, or 3 for a broker that knows only MQTT 3.1.1; with 3 nothing bounds how large a
            message may be.

    """

    url: str
    user: str = ""
    password_file: str = ""
    password_env: str = ""
    ca: str = ""
    client: str = ""
    version: int = 5


class MqttSource(SourceShape, frozen=True, kw_only=True, tag="mqtt"):
    """Where a signal comes from that a broker's topic carries.

    Attributes:
        topic: its name, ``home/roof/weather``; no pattern.
        path: the field of the JSON in it, ``wind.speed`` or ``$.sensors[0].value``; empty where
            the whole message is the value.

    """

    topic: str = ""
    path: str = ""


class MqttRules(KindRules[MqttConnection, MqttSource]):
    """Checks what is described of an MQTT broker."""

    kind = ConnectionKind.MQTT
    source = MqttSource
    example = "topic: roof/weather, path: wind.speed"

    def __init__(self, connection: MqttConnection) -> None:
        """Answer for this connection."""
        super().__init__(connection, MqttSource)

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        connection = self.connection
        yield from url_fits(
            f"{where}.url",
            connection.url,
            ("mqtt", "mqtts"),
            example="broker.local:1883",
            instead="write user and password_file at the connection",
        )
        if connection.version not in (3, 5):
            yield Finding(f"{where}.version", f"expected 3 or 5, found {connection.version}")
        # Which of two secrets was meant nobody can tell.
        if connection.password_file and connection.password_env:
            yield Finding(f"{where}.password_env", "password_file is given, too", "leave one out")
        if (connection.password_file or connection.password_env) and not connection.user:
            yield Finding(f"{where}.user", "whose password is it?", "write: user: talaia")
        if connection.ca and not connection.url.startswith("mqtts:"):
            problem = "only mqtts:// has certificates"
            yield Finding(f"{where}.ca", problem, "write mqtts:// in the url, or leave it out")

    def signal_fits(self, where: str, signal: Signal, source: MqttSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if signal.type is SignalType.POSITION:
            yield self.no_positions(where)
        topic = source.topic
        if not topic:
            yield Finding(f"{where}.topic", "which topic is it?", "write: topic: roof/weather")
        elif "+" in topic or "#" in topic:
            problem = f"{topic[:80]!r} is a pattern, and a signal is one topic"
            yield Finding(f"{where}.topic", problem, "make a signal of each topic")
        # A broker ends the connection of a client that asks for one of these.
        elif "\0" in topic or len(topic.encode(errors="replace")) > _MAX_TOPIC:
            yield Finding(f"{where}.topic", "it is not the name of a topic", "as roof/weather")
        yield from json_path_fits(f"{where}.path", source.path)
