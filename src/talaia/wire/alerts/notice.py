"""A notice of something in the sky, whatever form it came in."""

from __future__ import annotations

import msgspec

__all__ = ["AlertNotice", "NoticeRole"]


class NoticeRole:
    """What a notice is for (VOEvent 2.0, 3.1): only an observation is of the real sky."""

    OBSERVATION = "observation"
    PREDICTION = "prediction"
    UTILITY = "utility"
    TEST = "test"


class AlertNotice(msgspec.Struct, frozen=True, kw_only=True):
    """What a notice says, as far as it says it.

    Attributes:
        id: of the notice; the same again is the same notice.
        event: what it is about; several notices may be about one event.
        role: see `NoticeRole`.
        source: who sends it: the VOEvent stream, or mission and instrument.
        ra: right ascension (degrees, ICRS or J2000); none where no place is known.
        dec: declination (degrees, likewise).
        error_radius: of the place (degrees, 1 sigma or as the sender has it); none if not told.
        time: of the event (ISO 8601, as it came); empty if not told.
        parameters: everything else, by name: ``Packet_Type``, ``group/name``.
        retracts: the event was none: what was asked for because of it is to end.
        cites: ids of earlier notices that it speaks of.

    """

    id: str
    event: str = ""
    role: str = NoticeRole.OBSERVATION
    source: str = ""
    ra: float | None = None
    dec: float | None = None
    error_radius: float | None = None
    time: str = ""
    parameters: dict[str, str] = {}
    retracts: bool = False
    cites: tuple[str, ...] = ()
