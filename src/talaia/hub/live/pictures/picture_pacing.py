"""What of a camera goes to one page and when, so that it is fresh on any connection. Pure.

Every picture is answered by the page once it is drawn. From that a page's own rung follows: the
camera's size, or the small one where the large is more than the connection carries. Of single
pictures (JPEG) the newest waits and no other. Of a film (H.264) none can be left out but all up to
the next that needs none before it: when too many wait, they all go, and once the connection is
empty such a one is asked for.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from talaia.wire.frames import PictureForm

if TYPE_CHECKING:
    from collections.abc import Collection


__all__ = ["PicturePacing", "Ready"]

# Single pictures that may be under way to a page: one being sent, one being drawn.
CREDIT = 2
# Of a film: so many, and none while one takes longer than the quickest by this (µs).
_MOST_UNDER_WAY = 32
_LATE_US = 100_000
# What an answer is taken to need before the first has come (µs).
_UNKNOWN_US = 300_000
# What waits is given up when it has waited for so long (µs); a second time within so long (µs), and
# the line carries less than that form: a machine's one hiccup is no slow line.
_MOST_WAIT_US, _TWICE_US = 120_000, 4_000_000
# A single picture that takes longer than this (µs) is too large for the connection.
_SLOW_US = 250_000
# To climb again: the connection carries this (bytes/s; film, single pictures) by three pictures
# that were large enough (bytes) to tell, what small ones take being the way itself; and none was
# late for so long (µs), which doubles with each time that it failed.
_CLIMBS_AT, _CLIMBS_AT_SINGLE, _TELLING, _WEIGHTLESS = 400_000, 800_000, 4_000, 2_500
_PROBE_US, _LONGEST_US = 5_000_000, 160_000_000
_PROBES = 3
# A picture to begin with is asked for at most so often (µs).
_ASK_AGAIN_US = 500_000
# No answer is taken for quicker than this (µs), so that no speed is infinite.
_RESTS_US = 1_000
# The quickest forgets itself a little with each answer: paths change.
_FORGET = 1.001
_SMALL = {PictureForm.H264: PictureForm.H264_SMALL, PictureForm.JPEG: PictureForm.JPEG_SMALL}
_LARGE = {small: large for large, small in _SMALL.items()}


class Ready(NamedTuple):
    """One picture, written for the wire.

    Attributes:
        seq: its number.
        key: it needs none before it.
        film: it is part of a film.
        size: bytes.

    """

    seq: int
    key: bool
    film: bool
    size: int
    frame: bytes | str


class PicturePacing:
    """One page's pictures of one camera."""

    def __init__(self, able: Collection[str]) -> None:
        """Begin with the best form of those the page is ``able`` to show."""
        # The large form: a film where the page can show one.
        self._best = PictureForm.H264 if PictureForm.H264 in able else PictureForm.JPEG
        # What it wants now; `STILL` while single pictures are all it wants.
        self.form = self._best
        # For figures: pictures that were left out.
        self.skipped = 0
        # What the connection has not taken yet.
        self._waiting: deque[Ready] = deque()
        # Sent and not answered: number, when (µs), bytes.
        self._under: deque[tuple[int, int, int]] = deque()
        # A picture to begin with is missing: what goes on from others is of no use.
        self.broken = True
        # What comes is a film: a gateway that knows none sends JPEG for all forms.
        self._film = self._best is PictureForm.H264
        # When a picture to begin with was last asked for (µs); the first may be at once.
        self._asked_us = -_ASK_AGAIN_US
        # When the connection last took one, or the oldest of those that wait came (µs).
        self._since_us = 0
        # When what waited was last given up (µs).
        self._gave_up_us = -_TWICE_US
        # The quickest answer of late (µs); 0: none yet.
        self._least_us = 0.0
        # What a picture takes that weighs next to nothing: the way itself (µs); 0: not known.
        self._way_us = 0.0
        # Bytes per second of the last pictures that were large enough to tell.
        self._speeds: deque[float] = deque(maxlen=_PROBES)
        # Since when none was late (µs).
        self._calm_us = 0
        # So long it must be calm before it tries the large form; doubles with each attempt (µs).
        self._probe_us = _PROBE_US

    @property
    def waits(self) -> bool:
        """Whether a picture waits for the connection."""
        return bool(self._waiting)

    def wants(self, forms: Collection[str]) -> bool:
        """Tell whether a picture for these forms is for this page; none is for everyone."""
        return not forms or self.form in forms

    def offer(self, ready: Ready, now_us: int) -> None:
        """Take a picture that is wanted, in place of what it makes useless."""
        self._film = ready.film
        if ready.key:
            self.skipped += len(self._waiting)
            self._waiting.clear()
            self.broken = False
        elif self.broken:
            self.skipped += 1
            return
        if not self._waiting:
            self._since_us = now_us
        self._waiting.append(ready)
        if now_us - self._since_us > _MOST_WAIT_US:
            self.skipped += len(self._waiting)
            self._waiting.clear()
            self.broken = True
            # Until the first answer nobody knows how far away the page is.
            again = now_us - self._gave_up_us < _TWICE_US
            self._gave_up_us = now_us
            if self._least_us and again:
                self._descend(now_us)

    def next_picture(self, now_us: int) -> bytes | str | None:
        """Give what goes out now, if the connection has room for it."""
        if not self._waiting or not self._has_room(now_us, film=self._waiting[0].film):
            return None
        ready = self._waiting.popleft()
        self._since_us = now_us
        self._under.append((ready.seq, now_us, ready.size))
        return ready.frame

    def shown(self, seq: int, now_us: int) -> None:
        """Take the page's word that it has drawn a picture, and with it all before."""
        took = size = 0
        # One answer stands for all before it: a page may leave pictures out.
        while self._under and self._under[0][0] <= seq:
            _, sent_us, size = self._under.popleft()
            took = max(_RESTS_US, now_us - sent_us)
        if not took:
            return
        self._least_us = min(took, self._least_us * _FORGET) if self._least_us else took
        late = took - self._least_us
        if late > _LATE_US or (took > _SLOW_US and not self._film):
            self._calm_us = now_us
            if not self._film:
                self._descend(now_us)
        elif size >= _TELLING:
            self._speeds.append(size / max(took - self._way_us, _RESTS_US) * 1e6)
        if size <= _WEIGHTLESS:
            self._way_us = min(took, self._way_us * _FORGET) if self._way_us else took
        self._climb(now_us)

    def wants_key(self, now_us: int) -> bool:
        """Tell whether to ask for a picture to begin with; then it counts as asked."""
        if not self.broken or not self._film or now_us - self._asked_us < _ASK_AGAIN_US:
            return False
        if self._under and not self._has_room(now_us, film=True):
            return False
        self._asked_us = now_us
        return True

    def glance(self, *, still: bool) -> None:
        """Take that the page is hidden (a picture a second will do), or is looked at again."""
        if still == (self.form is PictureForm.STILL):
            return
        self.form = PictureForm.STILL if still else self._best
        # They are of the other form.
        self._waiting.clear()
        self.broken = True
        self._asked_us = -_ASK_AGAIN_US

    def _has_room(self, now_us: int, *, film: bool) -> bool:
        if not film:
            return len(self._under) < CREDIT
        if not self._under:
            return True
        usual = self._least_us or _UNKNOWN_US
        waited = now_us - self._under[0][1]
        return len(self._under) < _MOST_UNDER_WAY and waited < usual + _LATE_US

    def _descend(self, now_us: int) -> None:
        self._calm_us = now_us
        self._speeds.clear()
        small = _SMALL.get(self.form)
        if small is not None:
            self.form = small
            self.broken = True
            self._asked_us = now_us

    def _climb(self, now_us: int) -> None:
        large = _LARGE.get(self.form)
        if large is None or now_us - self._calm_us < self._probe_us:
            return
        least = _CLIMBS_AT if self._film else _CLIMBS_AT_SINGLE
        if len(self._speeds) < _PROBES or min(self._speeds) < least:
            return
        self.form = large
        self.broken = True
        self._asked_us = now_us
        self._calm_us = now_us
        self._probe_us = min(2 * self._probe_us, _LONGEST_US)
