"""What waits to be sent to one browser: bounded, and conflating when the browser is slow. Pure.

Four kinds of things wait, each with its own policy:

- *notes*: short messages in order; the oldest gives way when there are too many;
- *states*: messages of which only the newest counts (who holds the lease), by key;
- *owed*: channels of a subscription whose newest value is to be told, with its age. What it is
  is asked only when it goes out, so that it weighs nothing here and is never old;
- *values*: samples by subscription. While the browser keeps up they go out as they came, with
  the bytes that other browsers get too. When it does not, they stay columns, and when these
  weigh too much, each channel keeps its first, least, greatest and last sample; then its last;
  and if even that is too much, the newest values are owed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from talaia.hub.live.pages.conflate import conflate, frames_of, newest, weight
from talaia.wire.browser import TO_BROWSER, Values
from talaia.wire.columns import join_columns

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterable, Mapping

    from talaia.wire.browser import ToBrowser
    from talaia.wire.columns import Columns
    from talaia.wire.socket_frame import SocketFrame

__all__ = ["Frame", "MessageFrame", "Outbox", "values_of"]


class MessageFrame:
    """A message as it is, for a client that lives in this process.

    Attributes:
        message: see above.

    """

    # One for each message of each client: small.
    __slots__ = ("_size", "message")

    def __init__(self, message: ToBrowser) -> None:
        """Weigh a message by what it would be in bytes."""
        self.message = message
        # Samples are bytes already, and to write them only to count would cost a copy.
        self._size = (
            len(message.channel) + len(message.offset) + len(message.value) + _weigh(message.texts)
            if isinstance(message, Values)
            else len(TO_BROWSER.encode(message))
        )

    def __len__(self) -> int:
        """Give what it weighs (bytes)."""
        return self._size


Frame: TypeAlias = "SocketFrame | MessageFrame"
# Bytes that may wait for one browser.
BUDGET = 8 * 1024 * 1024
# Of the budget: notes and states together; the rest is for values.
_NOTES_SHARE = 4
# Bytes alone would let very many short ones wait.
_MOST_NOTES = 1024
# A frame that is under way when another is built: the piece taken, and its bytes.
_HEADROOM = 4
# Channels whose newest values are asked for at a time: a text may be long.
_OWED_AT_ONCE = 500


@dataclass(slots=True)
class _Pending:
    """The samples of one subscription that wait."""

    # In the order they came; joined only when they are thinned or sent.
    pieces: list[Columns] = field(default_factory=list)
    # The bytes of the only piece, as all browsers get them.
    frame: Frame | None = None
    # Bytes, near enough; see `conflate.weight`.
    weight: int = 0


def _weigh(texts: Mapping[int, str]) -> int:
    """Give the bytes of texts, near enough: a character takes up to four."""
    return sum(4 * len(text) for text in texts.values())


class Outbox:
    """The bounded outbox of one browser."""

    def __init__(
        self,
        encode: Callable[[ToBrowser], Frame],
        budget: int = BUDGET,
        known: Callable[[int, list[int]], list[Values]] = lambda _sub, _places: [],
    ) -> None:
        """Bound everything that waits to ``budget`` bytes.

        Args:
            encode: writes a message.
            budget: see above.
            known: gives the newest values of channels (places in its list) of a subscription.

        """
        self._encode = encode
        # Asked when owed values go out, so that they are the newest then.
        self._known = known
        # What is owed before the values that wait, and behind them.
        self._owed_first: dict[int, set[int]] = {}
        # Channels of which something was dropped; their newest value is sent when there is room.
        self._owed: dict[int, set[int]] = {}
        # Messages that each count, in order.
        self._notes: list[Frame] = []
        # Messages of which only the newest counts, by what they are about.
        self._states: dict[Hashable, Frame] = {}
        # Samples that wait, by subscription.
        self._values: dict[int, _Pending] = {}
        self._notes_budget = budget // _NOTES_SHARE
        self._values_budget = budget // _HEADROOM
        # Bytes of each kind that wait; each kind has its own bound, so none starves another.
        self._notes_weight = 0
        self._states_weight = 0
        self._values_weight = 0
        # For figures: messages that were dropped, and how often samples were thinned.
        self.dropped_notes = 0
        self.conflated = 0

    def __bool__(self) -> bool:
        """Tell whether anything waits."""
        owed = self._owed_first or self._owed
        return bool(self._notes or self._states or self._values or owed)

    @property
    def weight(self) -> int:
        """Bytes that wait now."""
        return self._notes_weight + self._states_weight + self._values_weight

    def enqueue_frame(self, frame: Frame) -> None:
        """Add a message that goes out in order."""
        self._notes.append(frame)
        self._notes_weight += len(frame)
        while self._notes_weight > self._notes_budget or len(self._notes) > _MOST_NOTES:
            self._notes_weight -= len(self._notes.pop(0))
            self.dropped_notes += 1

    def state(self, key: Hashable, frame: Frame) -> None:
        """Add a message that takes the place of the one with the same key."""
        # Taken out first, so that the newest stands behind what was said before it.
        before = self._states.pop(key, None)
        self._states_weight += len(frame) - (len(before) if before is not None else 0)
        self._states[key] = frame
        # The last one stays however large it is, or nothing would ever be said.
        while self._states_weight > self._notes_budget and len(self._states) > 1:
            # The one that has gone longest without news goes first.
            self._states_weight -= len(self._states.pop(next(iter(self._states))))
            self.dropped_notes += 1

    def values(self, sub: int, columns: Columns, frame: Frame | None = None) -> None:
        """Add samples of a subscription; ``frame`` is the same as bytes, when someone has it."""
        if not len(columns):
            return
        pending = self._values.get(sub)
        if pending is None:
            pending = self._values[sub] = _Pending()
        # The bytes are those of one piece alone: a second makes them useless.
        pending.frame = frame if not pending.pieces else None
        pending.pieces.append(columns)
        added = weight(columns)
        pending.weight += added
        self._values_weight += added
        if self._values_weight > self._values_budget:
            self._thin()

    def forget(self, sub: int) -> None:
        """Drop what waits of a subscription."""
        self._owed_first.pop(sub, None)
        self._owed.pop(sub, None)
        pending = self._values.pop(sub, None)
        if pending is not None:
            self._values_weight -= pending.weight

    def owe(self, sub: int, places: Iterable[int], *, first: bool = False) -> None:
        """Note that the newest values of these channels are to be told.

        They go behind what waits of the subscription, or with ``first`` before it.
        """
        (self._owed_first if first else self._owed).setdefault(sub, set()).update(places)

    def next_frames(self) -> list[Frame]:
        """Take what goes out next: all notes and states, else the values of one subscription.

        The rest stays, open to conflation, until the browser has taken these.
        """
        # Short messages first: they tell of STOP, leases and alarms.
        if self._notes or self._states:
            frames = [*self._notes, *self._states.values()]
            self._notes.clear()
            self._states.clear()
            self._notes_weight = self._states_weight = 0
            return frames
        if self._owed_first:
            return self._take_owed(self._owed_first)
        if not self._values:
            return self._take_owed(self._owed) if self._owed else []
        # The one that has waited longest.
        sub = next(iter(self._values))
        pending = self._values.pop(sub)
        self._values_weight -= pending.weight
        if pending.frame is not None:
            return [pending.frame]
        if len(pending.pieces) > 1:
            self.conflated += 1
        return [
            self._encode(message)
            for message in values_of(sub, conflate(join_columns(pending.pieces)))
        ]

    def _take_owed(self, owed: dict[int, set[int]]) -> list[Frame]:
        sub, places = next(iter(owed.items()))
        some = sorted(places)[:_OWED_AT_ONCE]
        places.difference_update(some)
        if not places:
            del owed[sub]
        return [self._encode(message) for message in self._known(sub, some)]

    def _thin(self) -> None:
        """Bring the values under their budget, gently first."""
        self.conflated += 1
        for step in (conflate, newest):
            for pending in self._values.values():
                thinned = step(join_columns(pending.pieces))
                after = weight(thinned)
                self._values_weight += after - pending.weight
                pending.pieces, pending.frame, pending.weight = [thinned], None, after
            # Well under, so that this work is not done again for the next batch.
            if self._values_weight <= self._values_budget // 2:
                return
        # One sample of each channel is still too much: long texts of many channels.
        while self._values_weight > self._values_budget and len(self._values) > 1:
            sub, pending = next(iter(self._values.items()))
            self.owe(sub, {int(channel) for piece in pending.pieces for channel in piece.channel})
            self._values_weight -= pending.weight
            del self._values[sub]


def values_of(sub: int, columns: Columns) -> list[Values]:
    """Make the messages that carry columns, cut where a batch can hold no more."""
    return [
        Values(
            sub=sub,
            base_us=packed.base_us,
            channel=packed.channel,
            offset=packed.offset,
            value=packed.value,
            texts=packed.texts,
        )
        for packed in frames_of(columns)
    ]
