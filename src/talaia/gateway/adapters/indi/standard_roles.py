"""Which role each standard property of INDI has, by its name: no label need be understood. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.model.connection import IndiSource
from talaia.model.discovery.role_proposal import with_roles
from talaia.model.roles import SIGNAL_FITS, CommandRole, SignalRole

if TYPE_CHECKING:
    from talaia.model.site import Command, Device, Signal

__all__ = ["with_standard_roles"]

# By property and element; a switch that is one word has no element.
_SIGNALS: dict[tuple[str, str], SignalRole] = {
    ("DOME_SHUTTER", ""): SignalRole.DOME_SHUTTER,
    ("DOME_PARK", ""): SignalRole.DOME_PARKED,
    ("ABS_DOME_POSITION", "DOME_ABSOLUTE_POSITION"): SignalRole.DOME_AZIMUTH,
    ("TELESCOPE_PARK", ""): SignalRole.TELESCOPE_PARKED,
    ("TELESCOPE_TRACK_STATE", ""): SignalRole.TELESCOPE_TRACKING,
    ("EQUATORIAL_EOD_COORD", "RA"): SignalRole.TELESCOPE_RA,
    ("EQUATORIAL_EOD_COORD", "DEC"): SignalRole.TELESCOPE_DEC,
    ("HORIZONTAL_COORD", "AZ"): SignalRole.TELESCOPE_AZIMUTH,
    ("HORIZONTAL_COORD", "ALT"): SignalRole.TELESCOPE_ALTITUDE,
    ("CCD_EXPOSURE", "CCD_EXPOSURE_VALUE"): SignalRole.CAMERA_REMAINING,
    ("CCD_TEMPERATURE", "CCD_TEMPERATURE_VALUE"): SignalRole.CAMERA_TEMPERATURE,
    ("CCD_COOLER", ""): SignalRole.CAMERA_COOLER,
    ("CCD_COOLER_POWER", "CCD_COOLER_VALUE"): SignalRole.CAMERA_COOLER_POWER,
    ("FILTER_SLOT", "FILTER_SLOT_VALUE"): SignalRole.CAMERA_FILTER,
    ("CCD_BINNING", "HOR_BIN"): SignalRole.CAMERA_BINNING,
    ("CCD_GAIN", "GAIN"): SignalRole.CAMERA_GAIN,
    ("ABS_FOCUS_POSITION", "FOCUS_ABSOLUTE_POSITION"): SignalRole.FOCUSER_POSITION,
    ("FOCUS_TEMPERATURE", "TEMPERATURE"): SignalRole.FOCUSER_TEMPERATURE,
    ("WEATHER_STATUS", ""): SignalRole.WEATHER_SAFETY,
    ("WEATHER_PARAMETERS", "WEATHER_TEMPERATURE"): SignalRole.WEATHER_TEMPERATURE,
    ("WEATHER_PARAMETERS", "WEATHER_HUMIDITY"): SignalRole.WEATHER_HUMIDITY,
    ("WEATHER_PARAMETERS", "WEATHER_DEWPOINT"): SignalRole.WEATHER_DEW_POINT,
    ("WEATHER_PARAMETERS", "WEATHER_DEW_POINT"): SignalRole.WEATHER_DEW_POINT,
    ("WEATHER_PARAMETERS", "WEATHER_PRESSURE"): SignalRole.WEATHER_PRESSURE,
    ("WEATHER_PARAMETERS", "WEATHER_BAROMETER"): SignalRole.WEATHER_PRESSURE,
    ("WEATHER_PARAMETERS", "WEATHER_WIND_SPEED"): SignalRole.WEATHER_WIND,
    ("WEATHER_PARAMETERS", "WEATHER_WIND_GUST"): SignalRole.WEATHER_GUST,
    ("WEATHER_PARAMETERS", "WEATHER_WIND_DIRECTION"): SignalRole.WEATHER_WIND_DIRECTION,
    ("WEATHER_PARAMETERS", "WEATHER_RAIN_HOUR"): SignalRole.WEATHER_RAIN,
    ("WEATHER_PARAMETERS", "WEATHER_CLOUD_COVER"): SignalRole.WEATHER_CLOUDS,
}
# By property, and by the element that is set or that the argument fills.
_COMMANDS: dict[tuple[str, str], CommandRole] = {
    ("DOME_SHUTTER", "SHUTTER_OPEN"): CommandRole.DOME_OPEN,
    ("DOME_SHUTTER", "SHUTTER_CLOSE"): CommandRole.DOME_CLOSE,
    ("ABS_DOME_POSITION", "DOME_ABSOLUTE_POSITION"): CommandRole.DOME_GOTO,
    ("DOME_PARK", "PARK"): CommandRole.DOME_PARK,
    ("DOME_PARK", "UNPARK"): CommandRole.DOME_UNPARK,
    ("DOME_ABORT_MOTION", "ABORT"): CommandRole.DOME_STOP,
    ("EQUATORIAL_EOD_COORD", "ON_COORD_SET/TRACK"): CommandRole.TELESCOPE_GOTO,
    ("TELESCOPE_PARK", "PARK"): CommandRole.TELESCOPE_PARK,
    ("TELESCOPE_PARK", "UNPARK"): CommandRole.TELESCOPE_UNPARK,
    ("TELESCOPE_ABORT_MOTION", "ABORT"): CommandRole.TELESCOPE_STOP,
    ("TELESCOPE_TRACK_STATE", "TRACK_ON"): CommandRole.TELESCOPE_TRACK,
    ("TELESCOPE_TRACK_STATE", "TRACK_OFF"): CommandRole.TELESCOPE_UNTRACK,
    ("CCD_EXPOSURE", "CCD_EXPOSURE_VALUE"): CommandRole.CAMERA_EXPOSE,
    ("CCD_ABORT_EXPOSURE", "ABORT"): CommandRole.CAMERA_ABORT,
    ("CCD_TEMPERATURE", "CCD_TEMPERATURE_VALUE"): CommandRole.CAMERA_COOL,
    ("CCD_COOLER", "COOLER_ON"): CommandRole.CAMERA_COOLER_ON,
    ("CCD_COOLER", "COOLER_OFF"): CommandRole.CAMERA_COOLER_OFF,
    ("FILTER_SLOT", "FILTER_SLOT_VALUE"): CommandRole.CAMERA_FILTER,
    ("CCD_BINNING", "HOR_BIN"): CommandRole.CAMERA_BINNING,
    ("CCD_GAIN", "GAIN"): CommandRole.CAMERA_GAIN,
    ("ABS_FOCUS_POSITION", "FOCUS_ABSOLUTE_POSITION"): CommandRole.FOCUSER_GOTO,
    ("REL_FOCUS_POSITION", "FOCUS_MOTION/FOCUS_INWARD"): CommandRole.FOCUSER_IN,
    ("REL_FOCUS_POSITION", "FOCUS_MOTION/FOCUS_OUTWARD"): CommandRole.FOCUSER_OUT,
    ("FOCUS_ABORT_MOTION", "ABORT"): CommandRole.FOCUSER_STOP,
}


def with_standard_roles(device: Device) -> Device:
    """Give the device with the roles of its standard properties, then with what is proposed."""
    taken: set[SignalRole] = set()
    signals = {}
    for name, signal in device.signals.items():
        role = _signal_role(signal)
        if role is not SignalRole.AUTO and role not in taken:
            taken.add(role)
            signal = msgspec.structs.replace(signal, role=role)
        signals[name] = signal
    commands = {
        name: msgspec.structs.replace(command, role=_command_role(command))
        for name, command in device.commands.items()
    }
    return with_roles(msgspec.structs.replace(device, signals=signals, commands=commands))


def _signal_role(signal: Signal) -> SignalRole:
    source = signal.source
    if not isinstance(source, IndiSource):
        return SignalRole.AUTO
    role = _SIGNALS.get((source.property, source.element), SignalRole.AUTO)
    # A driver's label may say another unit than the standard's.
    fits = role in SIGNAL_FITS and SIGNAL_FITS[role].allows(signal.type, signal.unit)
    return role if fits else SignalRole.AUTO


def _command_role(command: Command) -> CommandRole:
    elements = [*command.fixed, *(argument.field for argument in command.arguments.values())]
    return next(
        (
            role
            for element in elements
            if (role := _COMMANDS.get((command.target, element), CommandRole.AUTO))
            is not CommandRole.AUTO
        ),
        CommandRole.AUTO,
    )
