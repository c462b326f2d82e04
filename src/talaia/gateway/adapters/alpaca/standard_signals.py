"""What each type of ASCOM device has, as rows: properties with unit, states and role. Pure.

Units are those that ASCOM's interfaces prescribe (Platform 7): hours and degrees, °C, m/s, hPa.
"""

from __future__ import annotations

from typing import NamedTuple

from talaia.model.roles import SignalRole, StateMeaning
from talaia.model.site import DeviceKind, SignalType

__all__ = ["DEVICE_KINDS", "DEVICE_TYPES", "STANDARD_SIGNALS", "SignalRow"]


class SignalRow(NamedTuple):
    """One property that becomes a signal.

    Attributes:
        source: the property without the device, ``rightascension``.
        states: of a state: what each number means, in order; of a truth, false then true.
        meanings: of the states, where the role does not go by their words.
        primary: on the first page.

    """

    source: str
    name: str
    unit: str = ""
    states: tuple[str, ...] = ()
    role: SignalRole = SignalRole.AUTO
    meanings: tuple[StateMeaning, ...] = ()
    primary: bool = True
    minimum: float | None = None
    maximum: float | None = None

    @property
    def type(self) -> SignalType:
        """Whether it is a state or a number."""
        return SignalType.STATE if self.states else SignalType.NUMBER


_Role, _Means = SignalRole, StateMeaning
_NO_YES = ("no", "yes")
DEVICE_KINDS = {
    "telescope": DeviceKind.TELESCOPE,
    "dome": DeviceKind.DOME,
    "camera": DeviceKind.CAMERA,
    "observingconditions": DeviceKind.WEATHER,
    "safetymonitor": DeviceKind.WEATHER,
    "switch": DeviceKind.POWER,
}
STANDARD_SIGNALS: dict[str, tuple[SignalRow, ...]] = {
    "telescope": (
        SignalRow("rightascension", "Right ascension", "h", role=_Role.TELESCOPE_RA),
        SignalRow("declination", "Declination", "°", role=_Role.TELESCOPE_DEC),
        SignalRow("altitude", "Altitude", "°", role=_Role.TELESCOPE_ALTITUDE),
        SignalRow("azimuth", "Azimuth", "°", role=_Role.TELESCOPE_AZIMUTH),
        SignalRow("slewing", "Slewing", states=_NO_YES),
        SignalRow("tracking", "Tracking", states=_NO_YES, role=_Role.TELESCOPE_TRACKING),
        SignalRow("atpark", "Parked", states=_NO_YES, role=_Role.TELESCOPE_PARKED),
        SignalRow("athome", "At home", states=_NO_YES, primary=False),
        SignalRow("sideofpier", "Side of pier", states=("east", "west"), primary=False),
        SignalRow("siderealtime", "Sidereal time", "h", primary=False),
    ),
    "dome": (
        SignalRow(
            "shutterstatus",
            "Shutter",
            states=("open", "closed", "opening", "closing", "error"),
            role=_Role.DOME_SHUTTER,
            meanings=(_Means.OPEN, _Means.CLOSED, _Means.OPENING, _Means.CLOSING, _Means.ERROR),
        ),
        SignalRow("azimuth", "Azimuth", "°", role=_Role.DOME_AZIMUTH),
        SignalRow("altitude", "Altitude", "°", primary=False),
        SignalRow("slewing", "Turning", states=_NO_YES, role=_Role.DOME_TURNING),
        SignalRow("atpark", "Parked", states=_NO_YES, role=_Role.DOME_PARKED),
        SignalRow("athome", "At home", states=_NO_YES, primary=False),
        SignalRow("slaved", "Slaved", states=_NO_YES, primary=False),
    ),
    "camera": (
        SignalRow(
            "camerastate",
            "State",
            states=("idle", "waiting", "exposing", "reading", "sending", "error"),
            role=_Role.CAMERA_STATE,
            meanings=(
                _Means.IDLE,
                _Means.IDLE,
                _Means.EXPOSING,
                _Means.READING,
                _Means.READING,
                _Means.ERROR,
            ),
        ),
        SignalRow("ccdtemperature", "Sensor", "°C", role=_Role.CAMERA_TEMPERATURE),
        SignalRow("cooleron", "Cooler", states=("off", "on"), role=_Role.CAMERA_COOLER),
        SignalRow("coolerpower", "Cooler power", "%", role=_Role.CAMERA_COOLER_POWER),
        SignalRow("setccdtemperature", "Set point", "°C", primary=False),
        SignalRow("heatsinktemperature", "Heat sink", "°C", primary=False),
        SignalRow("percentcompleted", "Exposure done", "%", primary=False),
        SignalRow("binx", "Binning", role=_Role.CAMERA_BINNING, primary=False),
        SignalRow("gain", "Gain", role=_Role.CAMERA_GAIN, primary=False),
    ),
    "focuser": (
        SignalRow("position", "Position", role=_Role.FOCUSER_POSITION),
        SignalRow("ismoving", "Moving", states=_NO_YES, role=_Role.FOCUSER_MOVING),
        SignalRow("temperature", "Temperature", "°C", role=_Role.FOCUSER_TEMPERATURE),
        SignalRow("tempcomp", "Temperature compensation", states=("off", "on"), primary=False),
    ),
    "filterwheel": (SignalRow("position", "Filter", role=_Role.CAMERA_FILTER),),
    "rotator": (
        SignalRow("position", "Angle", "°"),
        SignalRow("mechanicalposition", "Mechanical angle", "°", primary=False),
        SignalRow("ismoving", "Moving", states=_NO_YES),
    ),
    "covercalibrator": (
        SignalRow(
            "coverstate",
            "Cover",
            states=("none", "closed", "moving", "open", "unknown", "error"),
            meanings=(
                _Means.NORMAL,
                _Means.NORMAL,
                _Means.NORMAL,
                _Means.NORMAL,
                _Means.UNKNOWN,
                _Means.ERROR,
            ),
        ),
        SignalRow(
            "calibratorstate",
            "Calibrator",
            states=("none", "off", "not ready", "ready", "unknown", "error"),
            meanings=(
                _Means.NORMAL,
                _Means.NORMAL,
                _Means.NORMAL,
                _Means.NORMAL,
                _Means.UNKNOWN,
                _Means.ERROR,
            ),
        ),
        SignalRow("brightness", "Brightness", primary=False),
    ),
    "observingconditions": (
        SignalRow("temperature", "Temperature", "°C", role=_Role.WEATHER_TEMPERATURE),
        SignalRow("humidity", "Humidity", "%", role=_Role.WEATHER_HUMIDITY, minimum=0, maximum=100),
        SignalRow("dewpoint", "Dew point", "°C", role=_Role.WEATHER_DEW_POINT),
        SignalRow("windspeed", "Wind", "m/s", role=_Role.WEATHER_WIND, minimum=0),
        SignalRow("windgust", "Gusts", "m/s", role=_Role.WEATHER_GUST, minimum=0),
        SignalRow("winddirection", "Wind direction", "°", role=_Role.WEATHER_WIND_DIRECTION),
        SignalRow("rainrate", "Rain", "mm/h", role=_Role.WEATHER_RAIN, minimum=0),
        SignalRow("cloudcover", "Clouds", "%", role=_Role.WEATHER_CLOUDS, minimum=0, maximum=100),
        SignalRow("pressure", "Pressure", "hPa", role=_Role.WEATHER_PRESSURE),
        SignalRow("skytemperature", "Sky temperature", "°C", primary=False),
        SignalRow("skybrightness", "Sky brightness", "lx", primary=False),
        SignalRow("skyquality", "Sky quality", "mag/arcsec²", primary=False),
        SignalRow("starfwhm", "Seeing", "arcsec", primary=False),
    ),
    "safetymonitor": (
        SignalRow(
            "issafe",
            "Safe",
            states=("unsafe", "safe"),
            role=_Role.WEATHER_SAFETY,
            meanings=(_Means.UNSAFE, _Means.SAFE),
        ),
    ),
    # Its signals are as many as it has switches; see `discovery`.
    "switch": (),
}
DEVICE_TYPES = tuple(STANDARD_SIGNALS)
