"""Discovery messages of Home Assistant: what makes its entities appear by themselves.

By https://www.home-assistant.io/integrations/mqtt/#mqtt-discovery: one retained message for each
entity under ``<discovery prefix>/<component>/<node>/<object>/config``.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.model.site import SignalType
from talaia.wire.mqtt.channel_units import channel_unit

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Channel, Device, Signal, Site
    from talaia.wire.mqtt.topic_tree import TopicTree

__all__ = ["DiscoveryWriter"]

# Device classes that a unit alone makes certain; of the others (``%``, ``m``) it says too little.
_CLASS_OF_UNIT = {
    "°C": "temperature",
    "K": "temperature",
    "V": "voltage",
    "mV": "voltage",
    "A": "current",
    "W": "power",
    "Wh": "energy_storage",
    "Hz": "frequency",
    "hPa": "pressure",
    "Pa": "pressure",
    "lx": "illuminance",
    "m/s": "speed",
    "km/h": "speed",
    "mm/h": "precipitation_intensity",
    "kg": "weight",
    "dBm": "signal_strength",
}
# What else may stand in a part of a discovery topic is made a line.
_ODD = re.compile(r"[^a-zA-Z0-9_-]")
# Longer states are refused there.
_MOST_LETTERS = 255
_GOOD = "{{ 'online' if value_json.quality == 'good' else 'offline' }}"
# The hub refuses a command that does not say when it was asked for.
_ASKED_NOW = '{"time": {{ now().timestamp() }}}'


class DiscoveryWriter(NamedTuple):
    """Writes discovery messages.

    Attributes:
        prefix: of the discovery topics; ``homeassistant`` unless it was changed there.
        tree: of the topics that they refer to.
        version: of Talaia.

    """

    prefix: str
    tree: TopicTree
    version: str

    def describe_sensor(self, site: Site, channel: Channel) -> tuple[str, bytes]:
        """Give topic and payload for a channel."""
        device = site.devices[channel.device]
        signal = device.signals[channel.signal]
        topic = self.tree.channel_value(site.site, channel.address)
        own = channel.address.split("/", 1)[1].replace(".", "_")
        said: dict[str, object] = {
            "name": f"{signal.name} {channel.part}" if channel.part else signal.name,
            "state_topic": topic,
            "value_template": _template_of(signal),
            **_kind_of(signal, channel),
        }
        good = {"topic": topic, "value_template": _GOOD}
        return self._write_entity("sensor", site, (channel.device, own), said, good)

    def describe_button(self, site: Site, device: str, command: str) -> tuple[str, bytes]:
        """Give topic and payload for a command without arguments."""
        said: dict[str, object] = {
            "name": site.devices[device].commands[command].name,
            "command_topic": self.tree.command_ask(site.site, device, command),
            "command_template": _ASKED_NOW,
            "qos": 0,
            "retain": False,
        }
        return self._write_entity("button", site, (device, f"do_{command}"), said)

    def describe_stop(self, site: Site, device: str) -> tuple[str, bytes]:
        """Give topic and payload for STOP (software)."""
        said: dict[str, object] = {
            "name": "STOP (software)",
            "command_topic": self.tree.stop_ask(site.site, device),
            "qos": 1,
            "retain": False,
        }
        return self._write_entity("button", site, (device, "stop_software"), said)

    def is_about(self, topic: str, site: str) -> bool:
        """Tell whether a topic describes something of a site."""
        levels = topic.removeprefix(f"{self.prefix}/").split("/")
        node = _ODD.sub("_", f"{self.tree.prefix}_{site}_")
        return (
            topic.startswith(f"{self.prefix}/") and levels[1:2] != [] and levels[1].startswith(node)
        )

    def _write_entity(
        self,
        component: str,
        site: Site,
        place: tuple[str, str],
        said: dict[str, object],
        *more: dict[str, str],
    ) -> tuple[str, bytes]:
        device, own = place
        node = _ODD.sub("_", f"{self.tree.prefix}_{site.site}_{device}")
        states = [
            {"topic": self.tree.hub_state},
            {"topic": self.tree.site_state(site.site)},
            {"topic": self.tree.device_state(site.site, device)},
            *more,
        ]
        whole = {
            **said,
            "unique_id": f"talaia_{node}_{own}",
            # All of them, else a dead hub would leave its sites looking alive.
            "availability": states,
            "availability_mode": "all",
            "device": self._describe_device(site, site.devices[device], node),
            "origin": {"name": "Talaia", "sw_version": self.version},
        }
        return f"{self.prefix}/{component}/{node}/{own}/config", msgspec.json.encode(whole)

    def _describe_device(self, site: Site, device: Device, node: str) -> dict[str, object]:
        return {
            "identifiers": [f"talaia_{node}"],
            "name": f"{site.name} {device.name}",
            "model": device.kind.value,
        }


def _template_of(signal: Signal) -> str:
    if signal.type is SignalType.TEXT:
        return f"{{{{ (value_json.value | string)[:{_MOST_LETTERS}] }}}}"
    return "{{ value_json.value }}"


def _kind_of(signal: Signal, channel: Channel) -> dict[str, object]:
    if signal.type is SignalType.TEXT:
        return {}
    if signal.type is SignalType.STATE:
        # A state that has no words is a number.
        words = list(dict.fromkeys(signal.states))
        return {"device_class": "enum", "options": words} if words else {}
    return dict(_kind_of_number(signal, channel))


def _kind_of_number(signal: Signal, channel: Channel) -> Iterator[tuple[str, object]]:
    yield "state_class", "measurement"
    unit = channel_unit(signal, channel)
    if unit:
        yield "unit_of_measurement", unit
    if unit in _CLASS_OF_UNIT:
        yield "device_class", _CLASS_OF_UNIT[unit]
    if signal.decimals >= 0:
        yield "suggested_display_precision", signal.decimals
