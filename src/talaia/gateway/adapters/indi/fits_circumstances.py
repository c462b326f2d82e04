"""What a picture's header says of its circumstances: site, target, pointing, weather. Pure.

Keywords are those that the field's programs use (OBJCTRA, SITELAT, CCD-TEMP, FOCALLEN …). The
camera's driver has written what it knows; here is added what the other devices know. The world
coordinates are an *estimate* from the mount's pointing and the optics, and say so.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from talaia.gateway.adapters.indi.discovery import Interface
from talaia.gateway.adapters.indi.protocol import PropertyState
from talaia.gateway.fits.header import HeaderCard

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.gateway.adapters.indi.state import IndiDevice, IndiDeviceTree
    from talaia.gateway.fits.header import Value

__all__ = ["header_cards", "precess_to_j2000"]

_DEG = math.pi / 180
_J2000_JD = 2_451_545.0
_UNIX_JD = 2_440_587.5
# What the weather is called in a header: element, keyword, what it is.
_WEATHER = (
    ("WEATHER_TEMPERATURE", "AMBTEMP", "[deg C] air temperature"),
    ("WEATHER_HUMIDITY", "HUMIDITY", "[%] relative humidity"),
    ("WEATHER_DEWPOINT", "DEWPOINT", "[deg C] dew point"),
    ("WEATHER_DEW_POINT", "DEWPOINT", "[deg C] dew point"),
    ("WEATHER_PRESSURE", "PRESSURE", "[hPa] air pressure"),
    ("WEATHER_BAROMETER", "PRESSURE", "[hPa] air pressure"),
    ("WEATHER_WIND_SPEED", "WINDSPD", "[km/h] wind"),
    ("WEATHER_WIND_GUST", "WINDGUST", "[km/h] gusts"),
    ("WEATHER_WIND_DIRECTION", "WINDDIR", "[deg] where the wind comes from"),
    ("WEATHER_RAIN_HOUR", "RAINRATE", "[mm/h] rain"),
    ("WEATHER_CLOUD_COVER", "CLOUDS", "[%] cloud cover"),
)
_SAFE = {
    PropertyState.OK: "safe",
    PropertyState.BUSY: "warning",
    PropertyState.ALERT: "unsafe",
    PropertyState.IDLE: "unknown",
}


def precess_to_j2000(ra_deg: float, dec_deg: float, unix_s: float) -> tuple[float, float]:
    """Carry a direction of the equator and equinox of a date over to J2000 (degrees).

    IAU 1976 precession (Lieske 1979); nutation and aberration, up to half an arcminute together,
    are left out: this serves an estimate.
    """
    t = (unix_s / 86_400.0 + _UNIX_JD - _J2000_JD) / 36_525.0
    arcsec = _DEG / 3600
    zeta = (2306.2181 * t + 0.30188 * t**2 + 0.017998 * t**3) * arcsec
    z = (2306.2181 * t + 1.09468 * t**2 + 0.018203 * t**3) * arcsec
    theta = (2004.3109 * t - 0.42665 * t**2 - 0.041833 * t**3) * arcsec
    ra, dec = ra_deg * _DEG - z, dec_deg * _DEG
    a = math.cos(dec) * math.sin(ra)
    b = math.cos(theta) * math.cos(dec) * math.cos(ra) + math.sin(theta) * math.sin(dec)
    c = -math.sin(theta) * math.cos(dec) * math.cos(ra) + math.cos(theta) * math.sin(dec)
    there = math.atan2(a, b) - zeta
    return (there / _DEG) % 360.0, math.atan2(c, math.hypot(a, b)) / _DEG


def header_cards(
    *,
    book: IndiDeviceTree,
    camera: str,
    site: str,
    address: str,
    header: Mapping[str, Value],
    unix_s: float,
) -> list[HeaderCard]:
    """Give the cards to set in a picture's header.

    Args:
        book: what all devices say now.
        camera: the INDI device that took it.
        site: what people call the site.
        address: the camera's device in the description, as ``site/device``.
        header: what the driver has written.
        unix_s: now (UTC).

    """
    cards = [
        HeaderCard("ORIGIN", "Talaia", "control room that kept this file"),
        HeaderCard("OBSERVAT", site, "observatory"),
        HeaderCard("TALAIADV", address, "site and device of the camera"),
        HeaderCard("INSTRUME", camera, "camera"),
    ]
    device = book.devices.get(camera)
    if device is None:
        return cards
    telescope = _find_device(book, device, "ACTIVE_TELESCOPE", Interface.TELESCOPE)
    if telescope is not None:
        cards += _site_cards(telescope)
        cards.append(HeaderCard("TELESCOP", telescope.name, "mount"))
        cards += _pointing_cards(telescope, device, header, unix_s)
    cards += _camera_cards(book, device, header)
    weather = [device for device in book if device.interface & Interface.WEATHER]
    if weather:
        cards += _weather_cards(weather[0], unix_s)
    return cards


def _find_device(
    book: IndiDeviceTree, camera: IndiDevice, role: str, bit: int
) -> IndiDevice | None:
    """Find the device a camera's driver was told to look at, or else the only one of its kind."""
    named = book.devices.get(str(camera.element_value("ACTIVE_DEVICES", role) or ""))
    if named is not None and named.interface & bit:
        return named
    fitting = [device for device in book if device.interface & bit]
    return fitting[0] if len(fitting) == 1 else None


def _read_number(device: IndiDevice, name: str, element: str) -> float | None:
    value = device.element_value(name, element)
    return value if isinstance(value, float) and math.isfinite(value) else None


def _site_cards(telescope: IndiDevice) -> list[HeaderCard]:
    latitude = _read_number(telescope, "GEOGRAPHIC_COORD", "LAT")
    longitude = _read_number(telescope, "GEOGRAPHIC_COORD", "LONG")
    height = _read_number(telescope, "GEOGRAPHIC_COORD", "ELEV")
    if latitude is None or longitude is None:
        return []
    east = longitude - 360.0 if longitude > 180.0 else longitude
    return [
        HeaderCard("SITELAT", latitude, "[deg] latitude of the site"),
        HeaderCard("SITELONG", east, "[deg] longitude of the site, east positive"),
        HeaderCard("SITEELEV", height, "[m] height of the site"),
    ]


def _pointing_cards(
    telescope: IndiDevice, camera: IndiDevice, header: Mapping[str, Value], unix_s: float
) -> list[HeaderCard]:
    ra, dec = header.get("RA"), header.get("DEC")
    if not isinstance(ra, int | float) or not isinstance(dec, int | float):
        hours = _read_number(telescope, "EQUATORIAL_EOD_COORD", "RA")
        degrees = _read_number(telescope, "EQUATORIAL_EOD_COORD", "DEC")
        if hours is None or degrees is None:
            return []
        ra, dec = precess_to_j2000(hours * 15.0, degrees, unix_s)
    cards = [
        HeaderCard("RA", float(ra), "[deg] J2000, where the mount pointed"),
        HeaderCard("DEC", float(dec), "[deg] J2000, where the mount pointed"),
        HeaderCard("EQUINOX", 2000.0, "of RA and DEC"),
    ]
    focal = _read_number(telescope, "TELESCOPE_INFO", "TELESCOPE_FOCAL_LENGTH")
    aperture = _read_number(telescope, "TELESCOPE_INFO", "TELESCOPE_APERTURE")
    if focal:
        cards.append(HeaderCard("FOCALLEN", focal, "[mm] focal length"))
    if aperture:
        cards.append(HeaderCard("APTDIA", aperture, "[mm] aperture"))
    pixel = _read_number(camera, "CCD_INFO", "CCD_PIXEL_SIZE_X") or _read_number(
        camera, "CCD_INFO", "CCD_PIXEL_SIZE"
    )
    width, height = header.get("NAXIS1"), header.get("NAXIS2")
    if (
        focal
        and pixel
        and isinstance(width, int)
        and isinstance(height, int)
        and "CTYPE1" not in header
    ):
        binned = header.get("XBINNING")
        across = binned if isinstance(binned, int) and binned > 0 else 1
        cards += _world_cards(
            ra=float(ra),
            dec=float(dec),
            width=width,
            height=height,
            scale_deg=pixel * across / focal / 1000 / _DEG,
        )
    return cards


def _world_cards(
    *, ra: float, dec: float, width: int, height: int, scale_deg: float
) -> list[HeaderCard]:
    """A tangent plane about the middle, north up and east left: without the camera's turn."""
    return [
        HeaderCard("CTYPE1", "RA---TAN", "estimate from the mount, not from stars"),
        HeaderCard("CTYPE2", "DEC--TAN", "estimate from the mount, not from stars"),
        HeaderCard("CRVAL1", ra, "[deg] at the reference pixel"),
        HeaderCard("CRVAL2", dec, "[deg] at the reference pixel"),
        HeaderCard("CRPIX1", (width + 1) / 2.0, "reference pixel: the middle"),
        HeaderCard("CRPIX2", (height + 1) / 2.0, "reference pixel: the middle"),
        HeaderCard("CDELT1", -scale_deg, "[deg] a pixel; north up is a guess"),
        HeaderCard("CDELT2", scale_deg, "[deg] a pixel; north up is a guess"),
        HeaderCard("CUNIT1", "deg"),
        HeaderCard("CUNIT2", "deg"),
        HeaderCard("RADESYS", "FK5", "of the estimate"),
    ]


def _camera_cards(
    book: IndiDeviceTree, camera: IndiDevice, header: Mapping[str, Value]
) -> list[HeaderCard]:
    cards = []
    if "CCD-TEMP" not in header:
        cards.append(
            HeaderCard(
                "CCD-TEMP",
                _read_number(camera, "CCD_TEMPERATURE", "CCD_TEMPERATURE_VALUE"),
                "[deg C] sensor",
            )
        )
    wheel = _find_device(book, camera, "ACTIVE_FILTER", Interface.FILTER)
    slot = None if wheel is None else _read_number(wheel, "FILTER_SLOT", "FILTER_SLOT_VALUE")
    if wheel is not None and slot is not None and not header.get("FILTER"):
        name = wheel.element_value("FILTER_NAME", f"FILTER_SLOT_NAME_{round(slot)}")
        cards.append(HeaderCard("FILTER", str(name or f"slot {round(slot)}"), "filter"))
    focuser = _find_device(book, camera, "ACTIVE_FOCUSER", Interface.FOCUSER)
    if focuser is not None and "FOCUSPOS" not in header:
        position = _read_number(focuser, "ABS_FOCUS_POSITION", "FOCUS_ABSOLUTE_POSITION")
        if position is not None:
            cards.append(HeaderCard("FOCUSPOS", round(position), "[steps] focuser"))
    return [card for card in cards if card.value is not None]


def _weather_cards(device: IndiDevice, unix_s: float) -> list[HeaderCard]:
    held = device.vectors.get("WEATHER_PARAMETERS")
    if held is None:
        return []
    cards = []
    for element, key, comment in _WEATHER:
        value = _read_number(device, held.name, element)
        if value is not None:
            cards.append(HeaderCard(key, value, comment))
    status = device.vectors.get("WEATHER_STATUS")
    if status is not None:
        word = _SAFE.get(status.state, "unknown")
        cards.append(HeaderCard("WXSAFE", word, "weather, by its own station's limits"))
    # When the picture came: the driver's own period is the most it may be older.
    at = datetime.fromtimestamp(unix_s, UTC).strftime("%Y-%m-%dT%H:%M:%S")
    return [*cards, HeaderCard("WXDATE", at, "UTC when this weather was read")]
