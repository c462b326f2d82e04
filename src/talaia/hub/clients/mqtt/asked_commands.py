"""Commands that come by MQTT: which are asked of the hub, and which are refused. Pure.

A broker keeps messages, and so do the clients and bridges before it. What was asked a while ago
must not move anything now, so each command says when it was asked for, and a retained one is
refused whatever it says.
"""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, NamedTuple

from talaia.wire.browser import PageCommand
from talaia.wire.errors import PeerError
from talaia.wire.mqtt.payloads import read_command_payload

if TYPE_CHECKING:
    from talaia.hub.clients.mqtt.publication import SitePublication
    from talaia.model.site import Site
    from talaia.wire.mqtt.topic_tree import CommandTopic

__all__ = ["InboundMessage", "RefusedMessage", "judge_command", "judge_stop"]

# A command may be this old at the most, or as old as its own limit (s).
_MOST_AGE_S = 5.0
# The asker's clock may be so far ahead (s): a message of the future would stay young for longer.
_MOST_AHEAD_S = 1.0


class InboundMessage(NamedTuple):
    """A message of the broker on a topic that asks for something.

    Attributes:
        retained: it was published to be kept, or has been kept.
        correlation: what its sender knows the answer by.

    """

    asked: CommandTopic
    topic: str
    payload: bytes
    retained: bool
    correlation: bytes


class RefusedMessage(NamedTuple):
    """Why nothing is done.

    Attributes:
        quiet: it is told to nobody but the log: the broker would only repeat it.

    """

    why: str
    quiet: bool = False


def judge_command(
    message: InboundMessage, site: Site, publication: SitePublication, now_us: int
) -> PageCommand | RefusedMessage:
    """Give the command as a page would ask for it, or why it is refused; ``now_us`` is UTC."""
    device, name = message.asked.device, message.asked.command
    if message.retained:
        return RefusedMessage("a retained message never moves anything; clear it", quiet=True)
    # Told alike whether it is not there, not permitted or not for the account.
    if (device, name) not in publication.commands:
        return RefusedMessage(f"{device}/{name} is not permitted by MQTT")
    command = site.devices[device].commands.get(name)
    if command is None:
        return RefusedMessage(f"{device}/{name} is not permitted by MQTT")
    try:
        asked = read_command_payload(message.payload)
    except PeerError as error:
        return RefusedMessage(error.problem)
    age_s = (now_us - asked.time_us) / 1e6
    limit_s = min(command.ttl, _MOST_AGE_S)
    if age_s > limit_s:
        return RefusedMessage(
            f"asked for {age_s:.1f} s ago, and it is good for {limit_s:g} s; are the clocks right?"
        )
    if age_s < -_MOST_AHEAD_S:
        return RefusedMessage(f"asked for {-age_s:.1f} s from now; are the clocks right?")
    # The same bytes again are a repeat, and the gateway acts on an id once.
    digest = hashlib.sha256(message.topic.encode() + b"\x00" + message.payload).hexdigest()
    return PageCommand(
        site=message.asked.site,
        device=device,
        command=name,
        id=f"mqtt-{digest[:40]}",
        args=asked.args,
    )


def judge_stop(message: InboundMessage, publication: SitePublication) -> RefusedMessage | None:
    """Tell why STOP is not pressed; neither age nor retaining keeps anybody from stopping."""
    if message.asked.device not in publication.stops:
        return RefusedMessage(f"there is no device {message.asked.device} to stop")
    return None
