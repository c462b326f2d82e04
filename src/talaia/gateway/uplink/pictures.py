"""Pictures on their way to the hub: what is wanted, what waits, and how full the link is.

Of pictures that need none before them only the newest waits. Those of a film may not be left out,
so that none is made while the link is full; should some wait all the same, they all go and the
next is one that needs none before it. Raw topics go on the same connection, behind all pictures.

Long, because what is wanted, what waits and what the link bears is one account.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from typing import TYPE_CHECKING

from talaia.gateway.ports import Filming
from talaia.gateway.taps.outbox import TAP_RECEIPTS
from talaia.gateway.uplink.link_capacity import LinkCapacity
from talaia.gateway.uplink.loop_lateness import LoopLateness
from talaia.objects.errors import DetectorError
from talaia.wire.frames import (
    MEDIA_FROM_GATEWAY,
    Beat,
    PictureForm,
    StreamError,
    camera_address,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from talaia.clock import Clock
    from talaia.gateway.cores.shared_budget import SharedBudget
    from talaia.gateway.recording.film_recorder import FilmRecorder
    from talaia.gateway.taps.outbox import TapOutbox
    from talaia.gateway.video.blur_detectors import BlurDetectors
    from talaia.gateway.video.frame_source import FrameSource
    from talaia.model.detection import Blur
    from talaia.objects.detection import Detection
    from talaia.wire.frames import BeatReply, DetectedBoxes, ModelOverlay, PictureFrame

__all__ = ["PictureUplink"]

# The beat behind each picture is its receipt; the connection's own beats count from 1.
_RECEIPTS = 2**40
# Of a film, for one stream: about a quarter second at 25 pictures a second.
_MOST_WAITING = 6
# Bytes of a piece of a raw topic whose encryption takes long enough to let others be first.
_LARGE = 16 * 1024
# A hub of a former version names no forms; it takes what it always took.
_FOR_OLD_HUB = frozenset({PictureForm.JPEG.value})


class PictureUplink:
    """A `PictureSink`. Beside pictures it carries the connection's few small messages."""

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        clock: Clock,
        *,
        frames: FrameSource,
        films: FilmRecorder | None = None,
        taps: TapOutbox | None = None,
        detectors: BlurDetectors | None = None,
        budget: SharedBudget | None = None,
    ) -> None:
        """Take the loop that sends, where those at the gateway look, who films, and raw topics.

        ``detectors`` find what is to be blurred; without them no such picture leaves. ``budget`` is
        told by how much the loop is late while pictures are made.
        """
        # None where nobody wants to know.
        self._lateness = None if budget is None else LoopLateness(loop, clock, budget.note_lateness)
        self._detectors = detectors
        self._films = films  # None where nothing can be filmed.
        self._loop = loop  # Only this loop touches what waits.
        self._clock = clock  # Monotonic, for the receipts.
        self._frames = frames  # Streams that somebody at the gateway looks at.
        # By stream and form: pictures that have not been sent. The order is whose turn it is.
        self._waiting: dict[tuple[str, str], deque[PictureFrame]] = {}
        # Beats, boxes and troubles; the oldest give way, for the next beat says more.
        self._small: deque[bytes] = deque(maxlen=100)
        self._wake = asyncio.Event()  # Set when something waits; cleared by the sender alone.
        # None where no topics are handed on.
        self._taps = taps
        if taps is not None:
            taps.on_waiting = self._wake_sender
        # Read by encoding threads as well; being a picture late does no harm, `_enqueue_picture`
        # asks again.
        self._linked = False
        self._sent = 0  # Pictures sent on this gateway's connections; numbers their receipts.
        self._room = LinkCapacity()
        # From here on used by the encoding threads, too.
        self._lock = threading.Lock()
        # By stream: the forms that somebody at the hub looks at.
        self._asked: Mapping[str, frozenset[str]] = {}
        # Streams and forms for which a picture that needs none before it was asked.
        self._keys: set[tuple[str, str]] = set()
        # Whether the hub is new enough to be told why a stream has no pictures.
        self._tells_trouble = False
        self._boxed: frozenset[str] = frozenset()  # Streams for which boxes are wanted, too.
        self._overlaid: frozenset[str] = frozenset()  # And those for which overlays are.
        # By stream and model: the newest that has not been sent. One and a picture take turns.
        self._overlays: dict[tuple[str, str], bytes] = {}
        self._overlay_turn = False
        self.dropped = 0  # Pictures left out because too many waited.

    def _wake_sender(self) -> None:
        self._loop.call_soon_threadsafe(self._wake.set)

    # ── what is wanted ──

    def watch(
        self,
        streams: Collection[str],
        forms: Mapping[str, Sequence[str]],
        boxes: Collection[str] = (),
        overlays: Collection[str] = (),
    ) -> None:
        """Take from the hub what is looked at, as what, and where more is wanted, too."""
        with self._lock:
            self._boxed = frozenset(map(camera_address, boxes))
            self._overlaid = frozenset(map(camera_address, overlays))
            self._asked = {
                stream: frozenset(forms[stream]) if stream in forms else _FOR_OLD_HUB
                for stream in streams
            }
            self._tells_trouble = bool(forms)

    def ask_key(self, stream: str, form: str) -> None:
        # Nobody looks at it: an old wish must not cost a picture later.
        """Take from the hub that somebody needs a picture to begin with."""
        with self._lock:
            if stream in self._asked:
                self._keys.add((stream, form))

    def watched(self) -> frozenset[str]:
        """Name the streams to be read: by those at the hub or those at the gateway."""
        filmed = frozenset() if self._films is None else self._films.wanted_cameras()
        return self._frames.held_streams() | filmed | set(map(camera_address, self._asked))

    # ── PictureSink, for the encoding threads ──

    def asked(self, stream: str) -> frozenset[str]:
        """See `PictureSink.asked`."""
        with self._lock:
            return self._asked.get(stream, frozenset()) if self._linked else frozenset()

    def key_due(self, stream: str, form: str) -> bool:
        """See `PictureSink.key_due`."""
        with self._lock:
            due = (stream, form) in self._keys
            self._keys.discard((stream, form))
            return due

    def room(self) -> float:
        """See `PictureSink.room`."""
        with self._lock:
            return self._room.share(self._clock.monotonic_ns() // 1000)

    def offer_frame(
        self,
        stream: str,
        stamp: tuple[int, int, int],
        decode: Callable[[], NDArray[np.uint8] | None],
        blurred: Callable[[], NDArray[np.uint8] | None] | None = None,
    ) -> None:
        """See `PictureSink.offer_frame`."""
        self._frames.offer_frame(stream, stamp, decode, blurred)

    def find_private(self, blur: Blur, rgb: NDArray[np.uint8]) -> Sequence[Detection]:
        """See `PictureSink.find_private`."""
        if self._detectors is None:
            raise DetectorError("no detectors run here")
        return self._detectors.find_private(blur, rgb)

    def filming(self, stream: str, time_us: int) -> Filming:
        """See `PictureSink.filming`."""
        return Filming.NO if self._films is None else self._films.filming(stream, time_us)

    def film(self, picture: PictureFrame) -> None:
        """See `PictureSink.film`."""
        if self._films is not None:
            self._films.add_picture(picture)

    def offer(self, picture: PictureFrame) -> None:
        """Take one picture; any thread."""
        if self._linked:
            self._loop.call_soon_threadsafe(self._enqueue_picture, picture)

    def trouble(self, stream: str, why: str) -> None:
        """See `PictureSink.trouble`."""
        if self._linked and self._tells_trouble:
            told = MEDIA_FROM_GATEWAY.encode(StreamError(stream=stream, why=why[:2000]))
            self._loop.call_soon_threadsafe(self.enqueue_small, told)

    # ── on the loop ──

    def boxes(self, boxes: DetectedBoxes) -> None:
        """Take what is seen on a picture, for those who want to know."""
        if self._linked and boxes.stream in self._boxed:
            self.enqueue_small(MEDIA_FROM_GATEWAY.encode(boxes))

    def wants_overlay(self, camera: str) -> bool:
        """Tell whether anybody looks at what models tell of a camera's pictures."""
        return self._linked and camera in self._overlaid

    def send_overlay(self, overlay: ModelOverlay) -> None:
        """Take what a model tells of a picture, for those who want to know."""
        if self.wants_overlay(overlay.stream):
            self._overlays[overlay.stream, overlay.model] = MEDIA_FROM_GATEWAY.encode(overlay)
            self._wake.set()

    def _enqueue_picture(self, picture: PictureFrame) -> None:
        if self._lateness is not None:
            self._lateness.note_picture()
        if not self._linked:
            return
        key = (picture.stream, picture.forms[0] if picture.forms else "")
        # Taken out first, so that streams take turns instead of one starving the others.
        waiting = self._waiting.pop(key, None) or deque()
        if picture.key:
            # A picture that needs none before it makes all that wait superfluous.
            self.dropped += len(waiting)
            waiting.clear()
        elif len(waiting) >= _MOST_WAITING:
            self.dropped += len(waiting) + 1
            # The rest of this film cannot be shown any more without a new beginning.
            self.ask_key(*key)
            return
        waiting.append(picture)
        self._waiting[key] = waiting
        self._wake.set()

    def enqueue_small(self, data: bytes) -> None:
        """Queue a small message before all pictures."""
        self._small.append(data)
        self._wake.set()

    async def next(self) -> bytes:
        """Wait for the next frame to send."""
        while True:
            if self._small:
                return self._small.popleft()
            if self._overlays and (self._overlay_turn or not self._waiting):
                self._overlay_turn = False
                return self._overlays.pop(next(iter(self._overlays)))
            if self._waiting:
                self._overlay_turn = True
                return self._next_picture()
            # Before the taps are asked: one that comes from now on sets it again.
            self._wake.clear()
            if self._taps is not None and (piece := self._taps.next_frame()) is not None:
                if len(piece) >= _LARGE:
                    # A line with room takes one after the other; driving frames come in between.
                    await asyncio.sleep(0)
                return piece
            await self._wake.wait()

    def _next_picture(self) -> bytes:
        key = next(iter(self._waiting))
        waiting = self._waiting.pop(key)
        picture = waiting.popleft()
        if waiting:
            self._waiting[key] = waiting
        now_us = self._clock.monotonic_ns() // 1000
        self._sent += 1
        with self._lock:
            self._room.sent(self._sent, now_us)
        beat = Beat(n=_RECEIPTS + self._sent, mono_us=now_us)
        self._small.append(MEDIA_FROM_GATEWAY.encode(beat))
        return MEDIA_FROM_GATEWAY.encode(picture)

    def answered(self, reply: BeatReply) -> None:
        """Take the answer to a beat; those behind pictures are their receipts."""
        if reply.n > TAP_RECEIPTS:
            if self._taps is not None:
                self._taps.take_receipt(reply.n)
        elif reply.n > _RECEIPTS:
            with self._lock:
                self._room.arrived(reply.n - _RECEIPTS, self._clock.monotonic_ns() // 1000)

    def link_up(self) -> None:
        """Begin with nothing old."""
        self._waiting.clear()
        self._overlays.clear()
        self._small.clear()
        with self._lock:
            self._room.clear()
            # Whoever looked on before needs a picture to begin with on the new connection.
            self._keys |= {
                (stream, form) for stream, forms in self._asked.items() for form in forms
            }
        # Last, so that no thread adds to what was just cleared.
        self._linked = True
        if self._taps is not None:
            self._taps.link_up()

    def link_lost(self) -> None:
        """Take no more until the next connection."""
        self._linked = False
        self._waiting.clear()
        self._overlays.clear()
        if self._taps is not None:
            self._taps.link_lost()
