"""The part of a site that closing its enclosures needs. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.model.connection import Ros1Connection, Ros2Connection
from talaia.model.interlocks.interlock import Condition, Interlock

if TYPE_CHECKING:
    from talaia.model.connection import Connection
    from talaia.model.interlocks.enclosure import Enclosure
    from talaia.model.interlocks.interlock import Step
    from talaia.model.site import Site

__all__ = ["GONE_WORDS", "closing_site"]

GONE = "gateway_gone"
# The interlock, and what is said of it: the hub matters to nobody here.
GONE_NAME = "The gateway is gone"
GONE_WORDS = f"{GONE_NAME}: the hub has been out of reach for 0 s"


def closing_site(site: Site) -> Site:
    """Give the part of a site that closing needs, with one interlock: the gateway is gone."""
    enclosures = {
        name: msgspec.structs.replace(enclosure, unsafe=(GONE,), follow=None)
        for name, enclosure in site.enclosures.items()
        if enclosure.watchdog_after
    }
    gone = Interlock(name=GONE_NAME, when=(Condition(link_lost=0.0),))
    site = msgspec.structs.replace(
        site,
        interlocks={GONE: gone},
        enclosures=enclosures,
        recording=None,
        alarms={},
        # What a night goes by must not be waited for before the roof is closed.
        night=None,
        services=None,
        ros2=None,
        connections={name: _under_own_name(link) for name, link in site.links().items()},
        devices={
            name: msgspec.structs.replace(
                device,
                connection=site.connection_of(name),
                drive=None,
                link_loss=None,
                pointing=None,
                streams={},
                frames=None,
            )
            for name, device in site.devices.items()
        },
    )
    steps = [step for enclosure in enclosures.values() for step in _closing_steps(enclosure)]
    commands = {step.command for step in steps} | {
        enclosure.stop for enclosure in enclosures.values()
    }
    wanted = {
        address.partition("/")[0] for address in (*site.safety_signals(), *commands) if address
    }
    return msgspec.structs.replace(
        site,
        devices={
            name: msgspec.structs.replace(
                device,
                signals={
                    key: signal
                    for key, signal in device.signals.items()
                    if f"{name}/{key}" in site.safety_signals()
                },
                commands={
                    key: command
                    for key, command in device.commands.items()
                    if f"{name}/{key}" in commands
                },
            )
            for name, device in site.devices.items()
            if name in wanted
        },
    )


def _closing_steps(rule: Enclosure) -> list[Step]:
    return [rule.close, *rule.abort, *([rule.park] if rule.park is not None else [])]


def _under_own_name(connection: Connection) -> Connection:
    """Join ROS as a node of another name: a master ends the older of two with the same one."""
    if isinstance(connection, Ros1Connection | Ros2Connection):
        return msgspec.structs.replace(connection, node=f"{connection.node}_watchdog")
    return connection
