"""What a camera's answers say: its clock, services, profiles, presets and how it stands. Pure.

Every number and text of an answer is a stranger's: what cannot be is left out, and lists end.
"""

from __future__ import annotations

import calendar
import math
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urlsplit

from talaia.gateway.adapters.onvif.soap import NAMESPACES, shown_words

if TYPE_CHECKING:
    from talaia.gateway.adapters.onvif.xml_nodes import XmlNode

__all__ = [
    "CameraProfile",
    "Preset",
    "PtzPlace",
    "PtzStatus",
    "parse_axes",
    "parse_clock",
    "parse_paths",
    "parse_presets",
    "parse_profiles",
    "parse_status",
    "parse_uri",
]

# ONVIF's own limits are in the camera (`MaximumNumberOfPresets`); a list ends here.
MOST_PRESETS = 300
MOST_PROFILES = 100
_MOST_PATH = 300
_MOST_ADDRESS = 500
_MOST_TOKEN = 64


class PtzPlace(NamedTuple):
    """Where a camera looks: -1 to 1, zoom 0 to 1; NaN for what it does not tell."""

    pan: float = math.nan
    tilt: float = math.nan
    zoom: float = math.nan

    def distance_to(self, other: PtzPlace) -> float:
        """Give by how much the two differ, of what both know; NaN where that is nothing."""
        apart = [abs(a - b) for a, b in zip(self, other, strict=True) if not math.isnan(a - b)]
        return max(apart, default=math.nan)


class PtzStatus(NamedTuple):
    """How a camera says that it stands.

    Attributes:
        place: where it looks.
        moving: whether it says that it moves; none where it does not say.

    """

    place: PtzPlace = PtzPlace()
    moving: bool | None = None


class Preset(NamedTuple):
    """A place that has a name; ``name`` is its token where it has none."""

    token: str
    name: str
    place: PtzPlace = PtzPlace()


class CameraProfile(NamedTuple):
    """A picture of the camera, and whether what makes it moves.

    Attributes:
        token: by which it is asked for.
        width: of its pictures (px); 0 where it is not told.
        encoding: ``H264``; empty where it is not told.
        node: the token of what moves it; empty for a camera that stands still.

    """

    token: str
    name: str
    width: int = 0
    height: int = 0
    encoding: str = ""
    moves: bool = False
    node: str = ""


def parse_clock(answer: XmlNode) -> float | None:
    """Read ``GetSystemDateAndTime``: UTC, s since the epoch; none where it tells none."""
    utc = answer.find_node("SystemDateAndTime", "UTCDateTime")
    if utc is None:
        return None
    date = [utc.text_at("Date", part) for part in ("Year", "Month", "Day")]
    clock = [utc.text_at("Time", part) for part in ("Hour", "Minute", "Second")]
    try:
        year, month, day, hour, minute, second = (int(part) for part in (*date, *clock))
    except ValueError:
        return None
    fits = 1970 <= year < 2200 and 1 <= month <= 12 and 1 <= day <= 31
    if not fits or not (0 <= hour < 24 and 0 <= minute < 60 and 0 <= second < 62):
        return None
    return float(calendar.timegm((year, month, day, hour, minute, second)))


def parse_paths(answer: XmlNode) -> dict[str, str]:
    """Read ``GetServices`` or ``GetCapabilities``: the paths of media and PTZ."""
    spaces = {NAMESPACES[name]: name for name in ("media", "ptz")}
    found: dict[str, str] = {}
    for service in answer.all_named("Service"):
        name = spaces.get(service.text_at("Namespace"))
        if name is not None and (path := _path_of(service.text_at("XAddr"))):
            found.setdefault(name, path)
    for name, key in (("media", "Media"), ("ptz", "PTZ")):
        path = _path_of(answer.text_at("Capabilities", key, "XAddr"))
        if path:
            found.setdefault(name, path)
    return found


def _path_of(address: str) -> str:
    """Give the path of an address: host and port are those of the description."""
    try:
        path = urlsplit(address).path
    except ValueError:
        return ""
    fits = path.startswith("/") and not path.startswith("//") and len(path) <= _MOST_PATH
    return path if fits and path.isascii() and path.isprintable() and " " not in path else ""


def _token_of(node: XmlNode) -> str:
    token = node.attributes.get("token", "")
    return token if 0 < len(token) <= _MOST_TOKEN and token.isprintable() else ""


def parse_profiles(answer: XmlNode) -> list[CameraProfile]:
    """Read ``GetProfiles``."""
    found = []
    for node in answer.all_named("Profiles")[:MOST_PROFILES]:
        token = _token_of(node)
        if not token:
            continue
        encoder = node.find_node("VideoEncoderConfiguration")
        ptz = node.find_node("PTZConfiguration")
        width, height = (
            _whole(encoder.text_at("Resolution", key)) if encoder is not None else 0
            for key in ("Width", "Height")
        )
        found.append(
            CameraProfile(
                token,
                shown_words(node.text_at("Name"))[:100] or token,
                width,
                height,
                "" if encoder is None else shown_words(encoder.text_at("Encoding"))[:20],
                ptz is not None,
                "" if ptz is None else ptz.text_at("NodeToken")[:_MOST_TOKEN],
            )
        )
    return found


def parse_uri(answer: XmlNode) -> str:
    """Read ``GetStreamUri``: the address of a picture; empty where it is none by RTSP."""
    address = answer.text_at("MediaUri", "Uri")
    try:
        parts = urlsplit(address)
        fits = parts.scheme in ("rtsp", "rtsps") and bool(parts.hostname) and parts.port != 0
        # Some cameras write the password into it, which stands in no description.
        named = parts.username is not None
    except ValueError:
        return ""
    if named:
        address = parts._replace(netloc=parts.netloc.rpartition("@")[2]).geturl()
    plain = address.isascii() and address.isprintable() and " " not in address
    return address if fits and plain and len(address) <= _MOST_ADDRESS else ""


def _whole(text: str) -> int:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 6 else 0


def parse_axes(answer: XmlNode, node: str) -> tuple[tuple[str, ...], bool]:
    """Read ``GetNodes``: what can be moved by a velocity, and whether there is a home.

    Args:
        answer: the camera's.
        node: the token of the one that is meant; the first where it is not there.

    """
    nodes = answer.all_named("PTZNode")
    meant = next((one for one in nodes if _token_of(one) == node), nodes[0] if nodes else None)
    if meant is None:
        return (), False
    spaces = meant.find_node("SupportedPTZSpaces")
    axes: tuple[str, ...] = ()
    if spaces is not None and spaces.all_named("ContinuousPanTiltVelocitySpace"):
        axes = ("pan", "tilt")
    if spaces is not None and spaces.all_named("ContinuousZoomVelocitySpace"):
        axes += ("zoom",)
    return axes, meant.text_at("HomeSupported") in ("true", "1")


def parse_presets(answer: XmlNode) -> list[Preset]:
    """Read ``GetPresets``."""
    found: dict[str, Preset] = {}
    for node in answer.all_named("Preset")[:MOST_PRESETS]:
        token = _token_of(node)
        if token:
            name = shown_words(node.text_at("Name"))[:_MOST_TOKEN] or token
            found.setdefault(token, Preset(token, name, _place_in(node.find_node("PTZPosition"))))
    return list(found.values())


def parse_status(answer: XmlNode) -> PtzStatus:
    """Read ``GetStatus``."""
    status = answer.find_node("PTZStatus")
    if status is None:
        return PtzStatus()
    words = {
        node.text
        for node in (status.find_node("MoveStatus") or status).walk_nodes()
        if node.name in ("PanTilt", "Zoom")
    }
    moving = True if "MOVING" in words else (False if "IDLE" in words else None)
    return PtzStatus(_place_in(status.find_node("Position")), moving)


def _place_in(node: XmlNode | None) -> PtzPlace:
    if node is None:
        return PtzPlace()
    turned, zoomed = node.find_node("PanTilt"), node.find_node("Zoom")
    return PtzPlace(
        _number(turned, "x"),
        _number(turned, "y"),
        _number(zoomed, "x"),
    )


def _number(node: XmlNode | None, key: str) -> float:
    """Read a coordinate; NaN for what is none."""
    if node is None:
        return math.nan
    try:
        value = float(node.attributes.get(key, ""))
    except ValueError:
        return math.nan
    # Degrees of a space of its own are as good; what is beyond is no place of a camera.
    return value if abs(value) <= 1e6 else math.nan
