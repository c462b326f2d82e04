"""What of a site goes to the broker: by the settings and by the account's rights. Pure."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.account_offer import make_account_offer
from talaia.wire.mqtt.channel_units import channel_unit

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.clients.mqtt.broker_settings import SiteChoice
    from talaia.model.site import Channel, Site
    from talaia.wire.mqtt.home_assistant import DiscoveryWriter
    from talaia.wire.mqtt.topic_tree import TopicTree

__all__ = ["PublishedChannel", "SitePublication", "make_publication"]


class PublishedChannel(NamedTuple):
    """A channel that goes to the broker.

    Attributes:
        at: its place among the site's channels.
        states: of a state: its words.
        max_age: older than this it is stale (s); 0: never.

    """

    at: int
    topic: str
    device: str
    text: bool
    unit: str
    states: tuple[str, ...]
    max_age: float


@dataclass(frozen=True, slots=True)
class SitePublication:
    """All of it.

    Attributes:
        site_state: where it stands whether its gateway is connected; empty: nothing is published.
        channels: see above.
        devices: by device: where it stands whether it is reached.
        commands: device and command, of those that are listened to.
        stops: devices of which STOP is listened to.
        discovery: payloads by topic, for Home Assistant.

    """

    site_state: str = ""
    channels: list[PublishedChannel] = field(default_factory=list)
    devices: dict[str, str] = field(default_factory=dict)
    commands: set[tuple[str, str]] = field(default_factory=set)
    stops: set[str] = field(default_factory=set)
    discovery: dict[str, bytes] = field(default_factory=dict)

    def retained_topics(self) -> Iterator[str]:
        """Go through all topics that hold something."""
        if self.site_state:
            yield self.site_state
        yield from self.devices.values()
        yield from (channel.topic for channel in self.channels)
        yield from self.discovery


def make_publication(
    site: Site,
    channels: Sequence[Channel],
    *,
    grants: Grants,
    choice: SiteChoice,
    tree: TopicTree,
    discovery: DiscoveryWriter | None,
) -> SitePublication:
    """Choose what is published of a site now, and what is listened to."""
    # What the account may not see is not in it, as for every other protocol.
    offer = make_account_offer(site, grants)
    seen = {signal.address for signal in offer.signals}
    found = SitePublication(tree.site_state(site.site))
    for at, channel in enumerate(channels):
        address = f"{channel.device}/{channel.signal}"
        if address in seen and choice.has_signal(address):
            found.channels.append(_publish_channel(site, at, channel, tree))
            found.devices[channel.device] = tree.device_state(site.site, channel.device)
            if discovery is not None:
                topic, payload = discovery.describe_sensor(site, channel)
                found.discovery[topic] = payload
    found.commands.update(
        (command.device, command.name)
        for command in offer.commands
        if choice.has_command(f"{command.device}/{command.name}")
    )
    # STOP is for whoever may view what is published; it needs no other word.
    found.stops.update(
        drive.device
        for drive in offer.drives
        if drive.device in found.devices or _has_chosen_commands(site, drive.device, choice)
    )
    for device in {device for device, _ in found.commands} | found.stops:
        found.devices[device] = tree.device_state(site.site, device)
    if discovery is not None:
        _describe_buttons(found, site, discovery)
    # That there is a site is not told for an account that sees nothing of it.
    return found if found.devices else SitePublication()


def _publish_channel(site: Site, at: int, channel: Channel, tree: TopicTree) -> PublishedChannel:
    signal = site.devices[channel.device].signals[channel.signal]
    return PublishedChannel(
        at,
        tree.channel_value(site.site, channel.address),
        channel.device,
        channel.text,
        channel_unit(signal, channel),
        signal.states,
        signal.max_age,
    )


def _has_chosen_commands(site: Site, device: str, choice: SiteChoice) -> bool:
    return any(choice.has_command(f"{device}/{name}") for name in site.devices[device].commands)


def _describe_buttons(found: SitePublication, site: Site, discovery: DiscoveryWriter) -> None:
    for device, command in found.commands:
        # A button gives no arguments.
        if not site.devices[device].commands[command].arguments:
            topic, payload = discovery.describe_button(site, device, command)
            found.discovery[topic] = payload
    for device in found.stops:
        topic, payload = discovery.describe_stop(site, device)
        found.discovery[topic] = payload
