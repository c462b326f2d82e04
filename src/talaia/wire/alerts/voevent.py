"""Reads VOEvent 2.0 (IVOA Recommendation, 11 July 2011). Pure.

Only what a request needs is read. XML that declares types or entities of its own is refused: no
VOEvent has any, and they make a small file grow without end.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET
from xml.parsers import expat

from talaia.wire.alerts.notice import AlertNotice, NoticeRole
from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["MOST_BYTES", "parse_voevent"]

MOST_BYTES = 1024 * 1024
_MOST_PARAMETERS = 500
_MOST_TEXT = 1000
_MOST_ELEMENTS = 10_000
_ROLES = frozenset(
    {NoticeRole.OBSERVATION, NoticeRole.PREDICTION, NoticeRole.UTILITY, NoticeRole.TEST}
)
# ``AstroCoordSystem`` of those that are J2000 to the second of arc.
_SYSTEMS = ("UTC-FK5-GEO", "UTC-ICRS-GEO", "UTC-FK5-TOPO", "UTC-ICRS-TOPO", "TDB-ICRS-BARY")


def parse_voevent(data: bytes) -> AlertNotice:
    """Read a VOEvent.

    Raises:
        PeerError: it is none, or says what cannot be.

    """
    if len(data) > MOST_BYTES:
        raise PeerError(f"a VOEvent of {len(data)} bytes; expected {MOST_BYTES} at the most")
    try:
        _refuse_declarations(data)
        root = ET.fromstring(data)  # noqa: S314 - what could expand has been refused
    except (ET.ParseError, expat.ExpatError, ValueError, LookupError) as error:
        raise PeerError(f"it is no XML: {error}") from error
    if _name(root) != "VOEvent":
        raise PeerError(f"expected a VOEvent, found <{_name(root)[:40]}>")
    identifier = root.get("ivorn", "").strip()
    if not identifier:
        raise PeerError("the VOEvent has no ivorn, by which it is known")
    role = root.get("role", NoticeRole.OBSERVATION)
    if role not in _ROLES:
        raise PeerError(f"the role of the VOEvent is {role[:40]!r}")
    parameters = dict(_parameters(root))
    ra, dec, radius = _place(root)
    cited = dict(_citations(root))
    stream = identifier.removeprefix("ivo://").partition("#")[0]
    return AlertNotice(
        id=identifier[:_MOST_TEXT],
        event=_event_of(root, parameters) or identifier[:_MOST_TEXT],
        role=role,
        source=stream[:_MOST_TEXT],
        ra=ra,
        dec=dec,
        error_radius=radius,
        time=_text(root, "ISOTime"),
        parameters=parameters,
        # Those of gravitational waves say it in a parameter, and cite what they supersede.
        retracts="retraction" in cited.values()
        or parameters.get("AlertType", "").lower() == "retraction",
        cites=tuple(cited),
    )


def _refuse_declarations(data: bytes) -> None:
    """Read it once for its document type alone, which has to stand before all entities.

    By the reader itself: whoever looks for the word in the bytes misses it in UTF-16.
    """

    def refuse(*_: object) -> None:
        raise PeerError("a VOEvent declares no types and no entities")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    parser.Parse(data, True)  # noqa: FBT003 - expat takes it by place


def _name(element: ET.Element) -> str:
    return element.tag.rpartition("}")[2]


def _find(root: ET.Element, name: str) -> ET.Element | None:
    return next((element for element in root.iter() if _name(element) == name), None)


def _text(root: ET.Element, name: str) -> str:
    found = _find(root, name)
    return "" if found is None else (found.text or "").strip()[:_MOST_TEXT]


def _parameters(root: ET.Element) -> Iterator[tuple[str, str]]:
    what = next((child for child in root if _name(child) == "What"), None)
    count = 0
    for child in [] if what is None else what:
        inside = [child] if _name(child) == "Param" else list(child)
        group = f"{child.get('name', '')}/" if _name(child) == "Group" else ""
        for param in inside:
            if _name(param) != "Param" or not param.get("name"):
                continue
            count += 1
            if count > _MOST_PARAMETERS:
                return
            value = param.get("value", "") or _text(param, "Value")
            yield f"{group}{param.get('name', '')}"[:200], value[:_MOST_TEXT]


def _citations(root: ET.Element) -> Iterator[tuple[str, str]]:
    """Give the ids of cited notices, each with how it is cited: it is followed up, or retracted."""
    for element in list(root.iter())[:_MOST_ELEMENTS]:
        name = (element.text or "").strip()[:_MOST_TEXT]
        if _name(element) == "EventIVORN" and name:
            yield name, element.get("cite", "").lower()


def _place(root: ET.Element) -> tuple[float | None, float | None, float | None]:
    """Read right ascension, declination and error (degrees), all of one place."""
    coordinates = _find(root, "AstroCoords")
    if coordinates is None:
        return None, None, None
    system = coordinates.get("coord_system_id", _SYSTEMS[0])
    position = _find(coordinates, "Position2D")
    if position is None:
        return None, None, None
    if system not in _SYSTEMS:
        raise PeerError(f"places in {system[:40]!r} are not read; expected {', '.join(_SYSTEMS)}")
    unit = position.get("unit", "deg")
    if unit not in ("deg", "degrees"):
        raise PeerError(f"the place is in {unit[:20]!r}; expected degrees")
    ra, dec = _number(_text(position, "C1")), _number(_text(position, "C2"))
    if ra is None or dec is None:
        return None, None, None
    if not (0.0 <= ra <= 360.0 and -90.0 <= dec <= 90.0):
        raise PeerError(f"the place {ra:g}, {dec:g} is not in the sky")
    radius = _number(_text(position, "Error2Radius"))
    return ra % 360.0, dec, radius if radius is not None and radius >= 0 else None


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _event_of(root: ET.Element, parameters: dict[str, str]) -> str:
    """Name the event that several notices share."""
    for name in ("GraceID", "TrigID", "Event_ID", "event_id"):
        if parameters.get(name):
            return f"{name} {parameters[name]}"
    cited = _find(root, "EventIVORN")
    return "" if cited is None else (cited.text or "").strip()[:_MOST_TEXT]
