"""Messages from the hub to a page: alarms, sightings and anomalies."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.browser_messages.subjects import DeviceMessage, StreamMessage
from talaia.wire.gateway_messages.field_types import Count, Micros, Name, Sentence, Share, Word
from talaia.wire.message import Message

__all__ = ["AlarmShare", "AlarmUpdate", "AnomalyShare", "AnomalyUpdate", "SightingUpdate"]


class AlarmShare(Message, frozen=True, kw_only=True, tag="alarm_share"):
    """What one of the signals that became unusual together has of it.

    Attributes:
        signal: its address.
        name: what people call it.
        share: of the whole, 0 to 1.
        on: whether it is unusual still.

    """

    signal: Name
    name: Name
    share: Share
    on: bool = True


class AlarmUpdate(DeviceMessage, frozen=True, kw_only=True, tag="alarm"):
    """How an alarm stands; told to a page that comes, and whenever it changes.

    Attributes:
        device: the one device it is about; empty: more than one, or the whole site.
        phase: ``normal``, ``active``, ``acknowledged`` or ``cleared`` (over and not acknowledged).
        why: what raised it.
        known: whether it can be judged now; a normal one that cannot be is not well.
        raised_us: when it was raised last, and likewise; 0: not yet, or not since it was raised.
        shelved_until_us: it is put aside until then; 0: it is not.
        undelivered: why a message of it did not reach somebody, or may not have.
        signals: channels that it looks at.
        shares: of an alarm about a device: the signals that became unusual together, the greatest
            share first; also after it is over.
        made: made in the page; the description's own are changed there.
        gone: there is no such alarm any more.

    """

    site: Word
    alarm: Word
    device: Word = ""
    name: Word
    # As the description has it; empty for an alarm that is gone.
    kind: Word
    severity: Word
    phase: Word
    why: Sentence = ""
    known: bool = True
    # Empty while it can be judged.
    unknown_why: Sentence = ""
    raised_us: Micros = 0
    cleared_us: Micros = 0
    acked_us: Micros = 0
    acked_by: Word = ""
    assigned: Word = ""
    shelved_until_us: Micros = 0
    shelved_by: Word = ""
    shelved_why: Sentence = ""
    undelivered: Sentence = ""
    advice: Sentence = ""
    signals: Annotated[list[Word], Meta(max_length=1000)] = []
    shares: Annotated[list[AlarmShare], Meta(max_length=100)] = []
    made: bool = False
    gone: bool = False


class SightingUpdate(StreamMessage, frozen=True, kw_only=True, tag="sighting"):
    """Something came into sight of a camera, is seen surer or more often, or is gone.

    Attributes:
        camera: the stream, ``device/stream``.
        many: how many at once, at the most so far.
        confidence: of the surest so far.
        ended_us: when it was seen last; 0 while it is in sight.

    """

    site: Name
    id: Count
    camera: Name
    label: Name
    many: Count
    confidence: Share
    began_us: Micros
    ended_us: Micros = 0


class AnomalyShare(Message, frozen=True, kw_only=True, tag="anomaly_share"):
    """What one signal of a group has to do with an anomaly.

    Attributes:
        signal: its address.
        share: of the squared distance from what is usual.
        spreads: by so many usual spreads it was above (or, negative, below) its usual level.

    """

    signal: Name
    share: Share
    spreads: float


class AnomalyUpdate(DeviceMessage, frozen=True, kw_only=True, tag="anomaly"):
    """How a detector of a signal stands, told when that changes; its scores come as `Values`.

    Subscribe to ``<signal>~<detector>`` for the scores. What stood before a page came is asked for
    over HTTP.

    Attributes:
        address: of the signal.
        detector: its word in the site description.
        on: an anomaly is on.
        from_us: when the newest anomaly began (UTC); 0: there was none yet.
        to_us: its last high sample (UTC); 0 while it is on.
        score: the newest.
        why: why the newest anomaly is one, in words.
        forgiven: a person said that it was none.
        confirmed: a person said that it was one.
        learning: so many samples until it has learned; before, it tells little.
        mode: the way of running that a group is in, in words; empty where it has one.
        shares: which signals of a group made the newest anomaly so, the greatest share first.

    """

    site: Word
    device: Word
    address: Word
    detector: Word
    on: bool = False
    from_us: Micros = 0
    to_us: Micros = 0
    score: float = 0.0
    why: Sentence = ""
    forgiven: bool = False
    confirmed: bool = False
    learning: Count = 0
    mode: Word = ""
    shares: Annotated[list[AnomalyShare], Meta(max_length=64)] = []
