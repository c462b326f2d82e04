"""Which properties of a driver are shown at all. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.indi.description.labels import is_describable
from talaia.gateway.adapters.indi.protocol import VectorKind

if TYPE_CHECKING:
    from talaia.gateway.adapters.indi.state import IndiDevice, StoredVector

__all__ = ["is_property_shown"]

# Set up once by the one who installs it: not for a page that is watched at night.
_HIDDEN_GROUPS = frozenset(
    {
        "options",
        "connection",
        "general info",
        "site management",
        "image info",
        "streaming",
        "signal processing",
        "presets",
        "wcs",
        "simulation",
        "guider head",
        "guider control",
        "alignment",
    }
)
# Of the driver itself, or set by a command of ours together with what it is for.
_HIDDEN = frozenset(
    {
        "CONFIG_PROCESS",
        "DEBUG",
        "DEBUG_LEVEL",
        "LOGGING_LEVEL",
        "LOG_OUTPUT",
        "POLLING_PERIOD",
        "SIMULATION",
        "DRIVER_INFO",
        # What a new target means (slew, sync): fixed by the commands that set one.
        "ON_COORD_SET",
        "FITS_HEADER",
        "CCD_FRAME_TYPE",
        "CCD_FRAME_RESET",
        "TARGET_EOD_COORD",
        "TIME_UTC",
        # Directions and ways to jog: by joystick, not as a signal.
        "FOCUS_MOTION",
        "DOME_MOTION",
        "TELESCOPE_MOTION_NS",
        "TELESCOPE_MOTION_WE",
        "USEJOYSTICK",
        "FILTER_NAME",
        "WEATHER_OVERRIDE",
        "GUIDER_EXPOSURE",
        "GUIDER_ABORT_EXPOSURE",
    }
)


def is_property_shown(held: StoredVector, device: IndiDevice) -> bool:
    """Tell whether people see a property that is in no table."""
    if held.name in _HIDDEN or held.kind is VectorKind.BLOB or not is_describable(held.name):
        return False
    # A driver that says nothing of its kind is somebody's own: all it has is worth showing.
    if device.interface == 0:
        return held.group.lower() != "connection"
    if held.group == "Parameters":  # weather: limits of the driver, beside the values
        return held.name == "WEATHER_PARAMETERS"
    return held.group.lower() not in _HIDDEN_GROUPS
