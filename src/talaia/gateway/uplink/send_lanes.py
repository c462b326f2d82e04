"""What waits to be sent, by importance. Pure, and bounded lane by lane.

A driving frame's answer never waits behind a batch of samples, and live samples never behind old
ones. Each lane says what gives way when it is full. Live samples do not wait at all where nothing
does that is as important, and the socket takes them.
"""

from __future__ import annotations

from collections import deque
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

from talaia.wire.frames import (
    LINK_FROM_GATEWAY,
    Beat,
    BeatReply,
    Bye,
    ChangeState,
    CommandState,
    ControlTick,
    DescriptionUpdate,
    DeviceState,
    DriveState,
    EnclosureState,
    Event,
    InterlockState,
    LeaseState,
    NightState,
    RecorderState,
    RequestRevision,
    ResetToken,
    ResumeSaved,
    SightingReport,
    StopState,
    TwinState,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.wire.frames import FromGateway

__all__ = ["SendLanes", "SendPriority", "WaitingFrame"]


class SendPriority(IntEnum):
    """From the most urgent to the least."""

    CONTROL = 0
    COMMANDS = 1
    LIVE = 2
    SEEN = 3
    BACKFILL = 4


# State of the moment and the link's own words: small, and worth nothing when late.
_CONTROL = (
    StopState,
    DriveState,
    TwinState,
    ControlTick,
    LeaseState,
    InterlockState,
    EnclosureState,
    DeviceState,
    RecorderState,
    NightState,
    RequestRevision,
    ResetToken,
    DescriptionUpdate,
    ChangeState,
    Beat,
    BeatReply,
    Bye,
    ResumeSaved,
)
# Facts: they are still true after a loss.
_COMMANDS = (CommandState, Event)


# Of a frame that owes no numbers when it is dropped.
_NONE = 2**62


class WaitingFrame(NamedTuple):
    """An encoded frame, and for samples the sequence range it holds."""

    data: bytes
    first: int = 0
    end: int = 0


class SendLanes:
    """The lanes of one gateway.

    CONTROL lives for one link: after a loss the state is told anew, nothing is replayed. COMMANDS
    outlives it: results and events are facts; of more than ``MAX_COMMANDS`` the oldest go. LIVE
    over ``MAX_LIVE`` bytes is emptied whole: what was in it is in the spool, and comes behind.
    SEEN has thumbnails, and who fills it waits until it is empty; what is lost is told again.
    """

    # Numbers of frames; each is at most a few hundred bytes.
    MAX_CONTROL = 2_000
    MAX_COMMANDS = 2_000
    # Bytes: a few seconds of a busy robot's samples.
    MAX_LIVE = 4 * 1024 * 1024

    def __init__(self, wake: Callable[[], None]) -> None:
        """Take what to call when something begins to wait."""
        self._wake = wake  # Wakes the writer; called after each frame that was added.
        # Sends a frame now, or tells that it cannot; what the link that stands has.
        self._write: Callable[[bytes], bool] = _cannot_write
        # One queue for each priority, by its number.
        self._lanes: tuple[deque[WaitingFrame], ...] = tuple(deque() for _ in SendPriority)
        # Of the LIVE lane alone: the others are bounded by their number of frames.
        self._live_bytes = 0
        # Without a link only COMMANDS is filled: state is told anew, samples are in the spool.
        self.linked = False
        # While another gateway has our place: how STOP stands on each device, until it is sent.
        self.held_stops: dict[str, StopState] | None = None
        # Facts that were lost to a link that stayed away for too long.
        self.dropped_events = 0
        # Samples that were dropped from LIVE (first, below), until `CatchUp` sends them.
        self.overflowed: tuple[int, int] | None = None
        # By boot: samples that the hub asks for again (first, below), until `CatchUp` does.
        self.owed: dict[str, tuple[int, int]] = {}
        # How often the hub has acknowledged anything: by it `CatchUp` sees that it still stores.
        self.acks = 0

    def send(self, message: FromGateway) -> None:
        """Queue a message in the lane of its kind."""
        if isinstance(message, _COMMANDS):
            lane = self._lanes[SendPriority.COMMANDS]
            # Oldest first: the newest results are what people wait for.
            if len(lane) >= self.MAX_COMMANDS:
                lane.popleft()
                self.dropped_events += 1
        elif not self.linked:
            if self.held_stops is not None and isinstance(message, StopState):
                self.held_stops[message.device] = message
            return
        elif isinstance(message, _CONTROL):
            lane = self._lanes[SendPriority.CONTROL]
            if len(lane) >= self.MAX_CONTROL:
                lane.popleft()
        else:
            lane = self._lanes[
                SendPriority.SEEN if isinstance(message, SightingReport) else SendPriority.BACKFILL
            ]
        lane.append(WaitingFrame(LINK_FROM_GATEWAY.encode(message)))
        self._wake()

    def live(self, data: bytes, first: int, end: int) -> None:
        """Queue a batch of live samples; without a link it is the spool's matter alone."""
        if not self.linked:
            return
        # Nothing as important waits: it is sent at once, for to wake a task for each of two hundred
        # batches a second costs as much as to send it. Messages always go by their lanes: of what
        # is said in one turn, states go before the events that tell of them.
        if not any(self._lanes[: SendPriority.LIVE + 1]) and self._write(data):
            return
        lane = self._lanes[SendPriority.LIVE]
        # `and lane`: a single batch that is larger than the bound still goes out.
        if self._live_bytes + len(data) > self.MAX_LIVE and lane:
            begin = min(message.first for message in lane)
            if self.overflowed is not None:
                begin = min(begin, self.overflowed[0])
            # The newest batch has no numbers; nothing of it is owed.
            numbered = [message.end for message in lane if message.end != _NONE]
            self.overflowed = (min(begin, first), max(numbered, default=first))
            lane.clear()
            # Emptied whole, so that the hub gets one gap and not a comb.
            self._live_bytes = 0
        lane.append(WaitingFrame(data, first, end))
        self._live_bytes += len(data)
        self._wake()

    def newest(self, data: bytes) -> None:
        """Queue the newest samples, before all that is heard from here on."""
        if self.linked:
            self._lanes[SendPriority.LIVE].append(WaitingFrame(data, _NONE, _NONE))
            self._live_bytes += len(data)
            self._wake()

    def backfill(self, data: bytes) -> None:
        """Queue a frame of old samples; the caller keeps the rate and the bound."""
        self._lanes[SendPriority.BACKFILL].append(WaitingFrame(data))
        self._wake()

    def owe(self, boot: str, first: int, below: int) -> None:
        """Note that the hub asks for samples again."""
        before = self.owed.get(boot, (first, below))
        self.owed[boot] = (min(first, before[0]), max(below, before[1]))

    @property
    def busy(self) -> bool:
        """Whether anything waits that is not old."""
        return any(
            self._lanes[lane]
            for lane in (SendPriority.CONTROL, SendPriority.COMMANDS, SendPriority.LIVE)
        )

    @property
    def seen_waiting(self) -> int:
        """How many sightings wait."""
        return len(self._lanes[SendPriority.SEEN])

    @property
    def backfill_waiting(self) -> int:
        """How many old frames wait."""
        return len(self._lanes[SendPriority.BACKFILL])

    def next(self) -> bytes | None:
        """Give the most urgent frame, or none."""
        for index, lane in enumerate(self._lanes):
            if lane:
                waiting = lane.popleft()
                if index == SendPriority.LIVE:
                    self._live_bytes -= len(waiting.data)
                return waiting.data
        return None

    # `link_lost` first: whatever was queued for a former link must not open this one.
    def link_up(self, write: Callable[[bytes], bool] | None = None) -> None:
        """Begin a link with nothing of the last one but facts.

        ``write`` sends a frame at once, and never waits; False: it cannot now, nothing was sent.
        """
        self.link_lost()
        self.linked = True
        self._write = write or _cannot_write
        self._wake()

    def link_lost(self) -> None:
        """Forget all but results and events."""
        self.linked = False
        self._write = _cannot_write
        # A new link catches up from the spool anyway.
        self.overflowed = None
        self.owed.clear()
        self._live_bytes = 0
        for lane in (
            SendPriority.CONTROL,
            SendPriority.LIVE,
            SendPriority.SEEN,
            SendPriority.BACKFILL,
        ):
            self._lanes[lane].clear()


def _cannot_write(_: bytes) -> bool:
    """Stand where no link does."""
    return False
