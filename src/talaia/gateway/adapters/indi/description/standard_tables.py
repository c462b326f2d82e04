"""The standard properties of INDI that have a name and a unit people know, as tables.

Property names are INDI's (`observatory` drivers of libindi 1.9.9, and the standard properties of
https://docs.indilib.org/drivers/standard-properties/). A row is used only where a driver has all
of it, so a table may name more than any one driver has.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = [
    "STANDARD_COMMANDS",
    "STANDARD_NUMBERS",
    "STANDARD_SWITCHES",
    "CommandRow",
    "NumberRow",
    "SwitchRow",
]


class NumberRow(NamedTuple):
    """A standard number: where it is, and what people call it.

    Attributes:
        property: INDI's name of the vector.
        element: the member of it.
        id: the signal's word in addresses.
        name: as people read it.
        unit: of the value as drivers send it, unless a weather driver's label says otherwise.
        low: the least value there can be; none where the driver's own limit counts.
        high: the greatest one.
        primary: whether it is on the device's first page.
        decimals: shown behind the point; -1 leaves that to the page.

    """

    property: str
    element: str
    id: str
    name: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    primary: bool = True
    decimals: int = -1


STANDARD_NUMBERS = (
    NumberRow("EQUATORIAL_EOD_COORD", "RA", "ra", "Right ascension (JNow)", "h", 0, 24, decimals=4),
    NumberRow("EQUATORIAL_EOD_COORD", "DEC", "dec", "Declination (JNow)", "°", -90, 90, decimals=3),
    # Declination and altitude end at the poles; hours, azimuth and angles go round.
    NumberRow("HORIZONTAL_COORD", "AZ", "azimuth", "Azimuth", "°", 0, 360),
    NumberRow("HORIZONTAL_COORD", "ALT", "altitude", "Altitude", "°", -90, 90),
    # INDI counts longitude eastwards from 0 to 360, never from -180.
    NumberRow("GEOGRAPHIC_COORD", "LAT", "latitude", "Latitude", "°", -90, 90, primary=False),
    NumberRow(
        "GEOGRAPHIC_COORD", "LONG", "longitude", "Longitude east", "°", 0, 360, primary=False
    ),
    NumberRow("GEOGRAPHIC_COORD", "ELEV", "elevation", "Elevation", "m", primary=False),
    NumberRow("ABS_DOME_POSITION", "DOME_ABSOLUTE_POSITION", "azimuth", "Azimuth", "°", 0, 360),
    # While it exposes, drivers count this down to 0 each second.
    NumberRow("CCD_EXPOSURE", "CCD_EXPOSURE_VALUE", "exposure", "Exposure left", "s", 0),
    NumberRow("CCD_TEMPERATURE", "CCD_TEMPERATURE_VALUE", "temperature", "Sensor", "°C", -100, 60),
    NumberRow("CCD_COOLER_POWER", "CCD_COOLER_VALUE", "cooler_power", "Cooler power", "%", 0, 100),
    NumberRow("CCD_BINNING", "HOR_BIN", "binning", "Binning", "", 1, primary=False, decimals=0),
    NumberRow("CCD_GAIN", "GAIN", "gain", "Gain", "", primary=False),
    NumberRow("FILTER_SLOT", "FILTER_SLOT_VALUE", "filter", "Filter", "", 0, decimals=0),
    NumberRow("ABS_FOCUS_POSITION", "FOCUS_ABSOLUTE_POSITION", "focus", "Focus", "", 0, decimals=0),
    NumberRow("FOCUS_TEMPERATURE", "TEMPERATURE", "focuser_temperature", "Focuser", "°C"),
    NumberRow("ABS_ROTATOR_ANGLE", "ANGLE", "angle", "Rotator angle", "°", 0, 360),
    NumberRow("SKY_QUALITY", "SKY_BRIGHTNESS", "sky_brightness", "Sky", "mag/arcsec²", 0, 25),
    NumberRow("WEATHER_PARAMETERS", "WEATHER_TEMPERATURE", "temperature", "Temperature", "°C"),
    NumberRow("WEATHER_PARAMETERS", "WEATHER_HUMIDITY", "humidity", "Humidity", "%", 0, 100),
    # Two spellings each of dew point and pressure: drivers agree on neither, and the first one
    # that is there is used.
    NumberRow("WEATHER_PARAMETERS", "WEATHER_DEWPOINT", "dew_point", "Dew point", "°C"),
    NumberRow("WEATHER_PARAMETERS", "WEATHER_DEW_POINT", "dew_point", "Dew point", "°C"),
    NumberRow("WEATHER_PARAMETERS", "WEATHER_PRESSURE", "pressure", "Pressure", "hPa"),
    NumberRow("WEATHER_PARAMETERS", "WEATHER_BAROMETER", "pressure", "Pressure", "hPa"),
    # Wind is km/h in libindi's own drivers; a label in brackets overrides it.
    NumberRow("WEATHER_PARAMETERS", "WEATHER_WIND_SPEED", "wind", "Wind", "km/h", 0),
    NumberRow("WEATHER_PARAMETERS", "WEATHER_WIND_GUST", "gust", "Gust", "km/h", 0),
    NumberRow(
        "WEATHER_PARAMETERS", "WEATHER_WIND_DIRECTION", "wind_from", "Wind from", "°", 0, 360
    ),
    NumberRow("WEATHER_PARAMETERS", "WEATHER_RAIN_HOUR", "rain", "Rain", "mm/h", 0),
    NumberRow("WEATHER_PARAMETERS", "WEATHER_CLOUD_COVER", "clouds", "Clouds", "%", 0, 100),
    NumberRow("WEATHER_PARAMETERS", "WEATHER_FORECAST", "forecast", "Forecast", "", primary=False),
)


class SwitchRow(NamedTuple):
    """A standard switch that people know as one word."""

    property: str
    id: str
    name: str
    primary: bool = True


STANDARD_SWITCHES = (
    SwitchRow("DOME_SHUTTER", "shutter", "Shutter"),
    SwitchRow("DOME_FLAP", "flap", "Flap"),
    SwitchRow("DOME_PARK", "parked", "Parking"),
    SwitchRow("DOME_AUTOSYNC", "follow", "Follows the telescope"),
    SwitchRow("TELESCOPE_PARK", "parked", "Parking"),
    SwitchRow("TELESCOPE_TRACK_STATE", "tracking", "Tracking"),
    SwitchRow("CCD_COOLER", "cooler", "Cooler"),
    SwitchRow("CAP_PARK", "cover", "Cover"),
    SwitchRow("CONNECTION", "connection", "Driver", primary=False),
)


class CommandRow(NamedTuple):
    """A standard command.

    Attributes:
        target: the property that must be there.
        fixed: what is set, by element or ``PROPERTY/ELEMENT``; all of it must be there.
        id: the command's word in addresses.
        name: as people read it.
        element: the element that the argument fills, if there is one.
        argument: that argument's word.
        unit: its unit.
        timeout: longest silence of the driver (s) before the command counts as lost.
        confirm: whether people are asked first.
        description: shown below its name.

    """

    target: str
    id: str
    name: str
    fixed: tuple[tuple[str, float | bool | str], ...] = ()
    element: str = ""
    argument: str = ""
    unit: str = ""
    timeout: float = 120.0
    confirm: bool = False
    description: str = ""


def _element_on(element: str) -> tuple[tuple[str, bool], ...]:
    return ((element, True),)


STANDARD_COMMANDS = (
    # Opening and unparking ask first, for what stands inside may get wet or be hit; what makes
    # safe (close, park, stop) never does.
    CommandRow(
        "DOME_SHUTTER", "open", "Open", _element_on("SHUTTER_OPEN"), timeout=180, confirm=True
    ),
    CommandRow("DOME_SHUTTER", "close", "Close", _element_on("SHUTTER_CLOSE"), timeout=180),
    CommandRow(
        "DOME_FLAP", "open_flap", "Open flap", _element_on("FLAP_OPEN"), timeout=180, confirm=True
    ),
    CommandRow("DOME_FLAP", "close_flap", "Close flap", _element_on("FLAP_CLOSE"), timeout=180),
    CommandRow(
        "ABS_DOME_POSITION",
        "goto",
        "Turn to",
        element="DOME_ABSOLUTE_POSITION",
        argument="azimuth",
        unit="°",
        timeout=300,
    ),
    CommandRow("DOME_PARK", "park", "Park", _element_on("PARK"), timeout=600),
    CommandRow("DOME_PARK", "unpark", "Unpark", _element_on("UNPARK"), timeout=600, confirm=True),
    CommandRow("DOME_ABORT_MOTION", "stop", "Stop", _element_on("ABORT"), timeout=15),
    CommandRow(
        "DOME_AUTOSYNC",
        "follow",
        "Follow the telescope",
        _element_on("DOME_AUTOSYNC_ENABLE"),
        timeout=15,
    ),
    CommandRow(
        "DOME_AUTOSYNC",
        "unfollow",
        "Follow no more",
        _element_on("DOME_AUTOSYNC_DISABLE"),
        timeout=15,
    ),
    CommandRow("TELESCOPE_PARK", "park", "Park", _element_on("PARK"), timeout=600),
    CommandRow(
        "TELESCOPE_PARK", "unpark", "Unpark", _element_on("UNPARK"), timeout=60, confirm=True
    ),
    CommandRow("TELESCOPE_ABORT_MOTION", "stop", "Stop", _element_on("ABORT"), timeout=15),
    CommandRow("TELESCOPE_TRACK_STATE", "track", "Track", _element_on("TRACK_ON"), timeout=15),
    CommandRow(
        "TELESCOPE_TRACK_STATE", "untrack", "Stop tracking", _element_on("TRACK_OFF"), timeout=15
    ),
    CommandRow("CCD_ABORT_EXPOSURE", "abort", "Abort exposure", _element_on("ABORT"), timeout=30),
    # A cooler takes half an hour to its end, and drivers ramp on purpose.
    CommandRow(
        "CCD_TEMPERATURE",
        "cool",
        "Cool to",
        element="CCD_TEMPERATURE_VALUE",
        argument="temperature",
        unit="°C",
        timeout=1800,
    ),
    CommandRow("CCD_COOLER", "cooler_on", "Cooler on", _element_on("COOLER_ON"), timeout=30),
    CommandRow("CCD_COOLER", "cooler_off", "Cooler off", _element_on("COOLER_OFF"), timeout=30),
    CommandRow("FILTER_SLOT", "filter", "Filter", element="FILTER_SLOT_VALUE", argument="slot"),
    CommandRow(
        "ABS_FOCUS_POSITION",
        "focus",
        "Focus to",
        element="FOCUS_ABSOLUTE_POSITION",
        argument="position",
        timeout=300,
    ),
    # The direction is a property of its own, and must be set before the steps.
    CommandRow(
        "REL_FOCUS_POSITION",
        "focus_in",
        "Focus in",
        (("FOCUS_MOTION/FOCUS_INWARD", True),),
        element="FOCUS_RELATIVE_POSITION",
        argument="steps",
        timeout=300,
    ),
    CommandRow(
        "REL_FOCUS_POSITION",
        "focus_out",
        "Focus out",
        (("FOCUS_MOTION/FOCUS_OUTWARD", True),),
        element="FOCUS_RELATIVE_POSITION",
        argument="steps",
        timeout=300,
    ),
    CommandRow(
        "FOCUS_ABORT_MOTION", "stop_focus", "Stop focuser", _element_on("ABORT"), timeout=15
    ),
    CommandRow(
        "ABS_ROTATOR_ANGLE",
        "rotate",
        "Rotate to",
        element="ANGLE",
        argument="angle",
        unit="°",
        timeout=300,
    ),
    CommandRow(
        "ROTATOR_ABORT_MOTION", "stop_rotator", "Stop rotator", _element_on("ABORT"), timeout=15
    ),
    CommandRow("CAP_PARK", "close_cover", "Close cover", _element_on("PARK")),
    CommandRow("CAP_PARK", "open_cover", "Open cover", _element_on("UNPARK")),
    CommandRow("WEATHER_REFRESH", "refresh", "Measure now", _element_on("REFRESH"), timeout=30),
    CommandRow("CONNECTION", "connect", "Connect driver", _element_on("CONNECT"), timeout=30),
    CommandRow(
        "CONNECTION",
        "disconnect",
        "Disconnect driver",
        _element_on("DISCONNECT"),
        timeout=30,
        confirm=True,
    ),
)
