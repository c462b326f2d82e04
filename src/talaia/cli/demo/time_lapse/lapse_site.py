"""The description of the observatory that lives through its nights at high speed. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.sim.observatory.night import at_dusk

if TYPE_CHECKING:
    from talaia.model.site import Device, Site

__all__ = ["TIME_LAPSE", "lapse_site"]

TIME_LAPSE = "timelapse"
# Nobody looks through them: what they show would be minutes old.
_CAMERAS = frozenset({"cctv", "allsky"})
# Without the camera the night goes by what the weather station says of the clouds.
_CLOUDS = "weather/clouds"


def lapse_site(site: Site, unix_s: float) -> Site:
    """Give the simulated observatory once more: where evening begins, without films.

    Its pictures come into the archive as they do elsewhere.
    """
    devices = {
        name: _still(device) for name, device in site.devices.items() if name not in _CAMERAS
    }
    night = site.night
    if night is not None and night.clouds.partition("/")[0] in _CAMERAS:
        night = replace(night, clouds=_CLOUDS)
    name = f"{site.name} (time lapse)"
    return at_dusk(replace(site, site=TIME_LAPSE, name=name, devices=devices, night=night), unix_s)


def _still(device: Device) -> Device:
    outlets = {
        name: replace(outlet, feeds=tuple(feed for feed in outlet.feeds if feed not in _CAMERAS))
        for name, outlet in device.outlets.items()
    }
    fed = {name: outlet for name, outlet in outlets.items() if outlet.feeds}
    return replace(device, streams={}, outlets=fed)
