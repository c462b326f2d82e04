"""Reads notices of GCN's unified schema (JSON, ``gcn.nasa.gov/schema``). Pure."""

from __future__ import annotations

import math

import msgspec

from talaia.wire.alerts.notice import AlertNotice, NoticeRole
from talaia.wire.errors import PeerError

__all__ = ["parse_gcn_json"]

_MOST_TEXT = 1000
_MOST_PARAMETERS = 500


def parse_gcn_json(data: bytes) -> AlertNotice:
    """Read a notice.

    Raises:
        PeerError: it is none, or says what cannot be.

    """
    try:
        said = msgspec.json.decode(data, type=dict[str, object])
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise PeerError(f"it is no notice of GCN: {error}") from error
    if "alert_type" not in said and "$schema" not in said:
        raise PeerError("it is no notice of GCN: neither $schema nor alert_type is in it")
    ra, dec = _number(said.get("ra")), _number(said.get("dec"))
    if (ra is None) is not (dec is None):
        raise PeerError("a place has both ra and dec")
    if ra is not None and dec is not None and not (0 <= ra <= 360 and -90 <= dec <= 90):
        raise PeerError(f"the place {ra:g}, {dec:g} is not in the sky")
    event = _text(said.get("event_name")) or _text(said.get("id")) or _text(said.get("ref_ID"))
    time = _text(said.get("trigger_time"))
    kind = _text(said.get("alert_type"))
    datetime = _text(said.get("alert_datetime"))
    instrument = _text(said.get("instrument"))
    source = " ".join(part for part in (_text(said.get("mission")), instrument) if part)
    if not event and not time:
        raise PeerError("a notice names its event or its trigger_time")
    tested = str(said.get("alert_tense", "")).lower() in ("test", "injection")
    role = NoticeRole.TEST if tested else NoticeRole.OBSERVATION
    return AlertNotice(
        id=" ".join(part for part in (source, event or time, kind, datetime) if part),
        event=event or time,
        role=role,
        source=source,
        ra=None if ra is None else ra % 360.0,
        dec=dec,
        error_radius=_number(said.get("ra_dec_error")),
        time=time,
        retracts=kind.lower() == "retraction",
        parameters={
            key[:200]: _text(value)
            for key, value in list(said.items())[:_MOST_PARAMETERS]
            if isinstance(value, str | int | float)
        },
    )


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)


def _text(value: object) -> str:
    # Some missions give lists of one.
    if isinstance(value, list) and value:
        value = value[0]
    return str(value)[:_MOST_TEXT] if isinstance(value, str | int | float) else ""
