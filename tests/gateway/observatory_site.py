"""The simulated observatory's description as ROS 1 has it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.model.connection import Ros1Connection
from talaia.model.site import Argument, ArgumentType, Command, CommandKind

if TYPE_CHECKING:
    from talaia.model.site import Site

POINT_TO = Command(
    name="Point to",
    kind=CommandKind.TOPIC,
    target="/telescope/goto_altaz",
    type="geometry_msgs/msg/Point",
    arguments={
        "alt": Argument(type=ArgumentType.NUMBER, field="x", unit="°", minimum=0, maximum=90),
        "az": Argument(type=ArgumentType.NUMBER, field="y", unit="°", minimum=0, maximum=360),
    },
)


def as_ros1(site: Site) -> Site:
    """Give the example for ROS 1: the same names, but for the requests with numbers.

    What needs `rcl_interfaces` is left out, and with it the limits of pointing and the following;
    the telescope is pointed by a topic.
    """
    devices = {}
    for name, device in site.devices.items():
        commands = {
            key: each
            for key, each in device.commands.items()
            if not each.type.startswith("rcl_interfaces/")
        }
        if name == "telescope":
            commands["goto_altaz"] = POINT_TO
        outlets = {
            key: replace(each, cut_by=tuple(one for one in each.cut_by if one.command in commands))
            for key, each in device.outlets.items()
        }
        devices[name] = replace(device, commands=commands, outlets=outlets, pointing=None)
    gone = {
        f"{name}/{key}"
        for name, device in site.devices.items()
        for key in device.commands.keys() - devices[name].commands.keys()
    }
    interlocks = {
        name: replace(each, refuse=tuple(one for one in each.refuse if one not in gone))
        for name, each in site.interlocks.items()
    }
    enclosures = {name: replace(each, follow=None) for name, each in site.enclosures.items()}
    return replace(
        site, ros2=None, connections={"ros1": Ros1Connection()},
        devices=devices, interlocks=interlocks, enclosures=enclosures, night=None,
    )  # fmt: skip
