"""A proposed description without devices that its owner does not want. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from talaia.model.site import Device, Site

__all__ = ["without_devices"]


def without_devices(site: Site, unwanted: frozenset[str]) -> Site:
    """Give the description without some devices, by their words, and without what names them."""
    devices = {
        word: _without_names(device, unwanted)
        for word, device in site.devices.items()
        if word not in unwanted
    }
    return msgspec.structs.replace(site, devices=devices)


def _without_names(device: Device, unwanted: frozenset[str]) -> Device:
    if device.drive is None:
        return device
    # A drive may do without a picture or a map; one that names what is gone would be refused.
    gone = {
        key: ""
        for key in ("picture", "position")
        if getattr(device.drive, key).partition("/")[0] in unwanted
    }
    return msgspec.structs.replace(device, drive=msgspec.structs.replace(device.drive, **gone))
