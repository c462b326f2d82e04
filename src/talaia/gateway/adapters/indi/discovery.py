"""From what a driver says of itself to a device with a page: signals and commands. Pure.

``DRIVER_INFO``'s interface bits are those of libindi 1.9.9 (``basedevice.h``). What becomes a
signal is in `description.device_signals`, what can be asked for in `description.device_commands`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.indi.description.device_commands import commands_of
from talaia.gateway.adapters.indi.description.device_signals import signals_of
from talaia.gateway.adapters.indi.description.labels import is_describable, shown_name, word_of
from talaia.gateway.adapters.indi.standard_roles import with_standard_roles
from talaia.model.site import Device, DeviceKind

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.gateway.adapters.indi.state import IndiDevice

__all__ = ["Interface", "devices_of"]


class Interface:
    """The bits of ``DRIVER_INTERFACE``."""

    TELESCOPE = 1
    CCD = 2
    GUIDER = 4
    FOCUSER = 8
    FILTER = 16
    DOME = 32
    GPS = 64
    WEATHER = 128
    ROTATOR = 4096


# The first that fits: a camera with a filter wheel or a guider in it is a camera.
_KINDS = (
    (Interface.DOME, DeviceKind.DOME),
    (Interface.TELESCOPE, DeviceKind.TELESCOPE),
    (Interface.CCD, DeviceKind.CAMERA),
    (Interface.WEATHER, DeviceKind.WEATHER),
)


def devices_of(
    found: Iterable[IndiDevice], connection: str, taken: Iterable[str] = ()
) -> dict[str, Device]:
    """Describe devices by id; their ids keep clear of those that are ``taken``.

    A name that cannot be written in a description (too long, unseen characters) is left out.
    """
    made: dict[str, Device] = {}
    for device in found:
        if not is_describable(device.name):
            continue
        device_id = word_of(device.name, {*taken, *made}, "device")
        made[device_id] = with_standard_roles(
            Device(
                name=shown_name(device.name),
                kind=_kind_of(device.interface),
                connection=connection,
                indi=device.name,
                signals=signals_of(device),
                commands=commands_of(device),
            )
        )
    return made


def _kind_of(bits: int) -> DeviceKind:
    return next((kind for bit, kind in _KINDS if bits & bit), DeviceKind.OTHER)
