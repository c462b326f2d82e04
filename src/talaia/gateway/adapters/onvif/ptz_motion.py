"""What a camera that is driven is told: moves that are renewed, and Stop until it rests.

Demands come at the control rate, and a question takes as long as the camera likes. So the newest
demand counts, one Move is under way at a time, and Stop waits for nothing: it is sent at once
beside a Move that has no answer yet, and once more when that has ended, for the camera may take
them in another order. Each Move ends by itself at the camera after `MOVE_S`: what is not renewed
stops also when the gateway, this machine or the network is gone.
"""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING

from talaia.gateway.adapters.http.fetching import FetchFailed
from talaia.gateway.adapters.onvif.ptz_service import MOVE_S
from talaia.gateway.adapters.onvif.soap import CameraFault
from talaia.gateway.adapters.onvif.xml_nodes import UnreadableXml

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from talaia.gateway.adapters.onvif.ptz_service import PtzService, PtzVelocity

__all__ = ["CAMERA_STILL", "PtzMotion"]

CAMERA_STILL: PtzVelocity = (0.0, 0.0, 0.0)
# A Move is sent again so often while nothing changes (s): twice within its life, and some.
RENEW_S = 0.4 * MOVE_S
# No more than so many moves a second: a small camera's processor answers few (s).
MOVE_EVERY_S = 0.1
# Demands come 20 times a second, zeros as well; without any for so long nobody drives (s).
SILENT_S = 0.5
# A velocity that differs by less is the same.
SAME = 0.02
# Stop is repeated so often while it has no answer, or while the camera moves on (s).
STOP_AGAIN_S = 0.5
# A camera brakes; one that moves so long after Stop has not obeyed (s).
BRAKE_S = 1.0
# For so long it is told again; then whoever else moves it has it (s).
INSIST_S = 10.0
# Waits no longer than this for the next look at the time (s).
_TURN_S = 0.1


class PtzMotion:
    """One camera's motion. Event loop only."""

    def __init__(
        self,
        service: PtzService,
        axes: frozenset[str],
        report: Callable[[str], None],
        *,
        begins_with_stop: bool = True,
    ) -> None:
        """Begin with Stop: what the camera was told before is not known.

        Args:
            service: who is asked.
            axes: what may be moved.
            report: told in words what a person should know, each once.
            begins_with_stop: not where nobody moves it from here.

        """
        self._service, self._axes, self._report = service, axes, report
        self._loop = asyncio.get_running_loop()
        # What is demanded now, and when that was last said.
        self._wish, self._wished_at = CAMERA_STILL, 0.0
        # What the camera was last told, and when.
        self._sent, self._sent_at = CAMERA_STILL, 0.0
        # Whether Stop has yet to be answered, when it was last sent and demanded, and since when
        # the camera should rest.
        self._stop_due, self._stop_sent_at = begins_with_stop, 0.0
        self._stopped_at = self._stop_demanded_at = self._loop.time()
        self._move: asyncio.Task[None] | None = None
        self._stop: asyncio.Task[None] | None = None
        # A Move was on its way when Stop was sent: the two may arrive the other way round.
        self._crossed = False
        # After a refusal whoever drives has to let go first. (After a loss nobody drives: that has
        # ended the lease.)
        self._must_rest = False
        self._is_refusing = False  # It refuses to stop; told already.
        self._insisted = False  # That it moves on after Stop was told.
        # While a command moves it by itself, its motion is no disobedience.
        self._travels = False
        self._ended_travels = 0  # How often somebody has stopped or driven it.
        self._changed = asyncio.Event()
        # Nothing is under way to the camera, and no Stop is due.
        self._settled = asyncio.Event()
        self._failed: BaseException | None = None  # What ends `run`.

    # ── told by others ──

    @property
    def is_driven(self) -> bool:
        """Whether somebody moves it now, or Stop has no answer yet."""
        return self._wish != CAMERA_STILL or self._stop_due or self._move is not None

    @property
    def was_driven_lately(self) -> bool:
        """Whether it may still come to rest."""
        return self.is_driven or self._loop.time() - self._stopped_at < 2 * BRAKE_S

    def demand(self, wish: PtzVelocity) -> None:
        """Take what is demanded now; zero stops it."""
        now = self._loop.time()
        # Said to be still, or silent for long enough: whoever drove has let go.
        if wish == CAMERA_STILL or now - self._wished_at > SILENT_S:
            self._must_rest = False
        self._wished_at = now
        if self._must_rest:
            return
        if wish != CAMERA_STILL:
            self._end_travels()
        elif self._wish != CAMERA_STILL:
            self._demand_stop()
        self._wish = wish
        if self.is_driven:
            self._settled.clear()
        self._changed.set()

    def stop_now(self, *, anew: bool = False) -> None:
        """Stop whatever it does, driven by us or not; may be called often.

        ``anew``: also where it was told to stop a moment ago.
        """
        self._wish = CAMERA_STILL
        self._end_travels()
        if anew or self._loop.time() - self._stop_sent_at >= STOP_AGAIN_S:
            self._demand_stop()
            self._settled.clear()
        self._changed.set()

    async def begin_travel(self) -> bool:
        """Take in that a command moves it from now on, once nothing else is said to the camera.

        A Stop that is still on its way would end what the command begins. Tells whether it may:
        nobody has stopped or driven it meanwhile.
        """
        ended = self._ended_travels
        await self._settled.wait()
        self._travels = ended == self._ended_travels
        return self._travels

    @property
    def travels(self) -> bool:
        """Whether a command moves it, and nobody has taken it over."""
        return self._travels

    def end_travel(self) -> None:
        """Take in that the command has ended."""
        self._travels = False

    def heed_motion(self, *, moving: bool) -> None:
        """Take in whether it moves, as it shows: after Stop it must not."""
        now = self._loop.time()
        if not moving:
            if self._insisted and not self.is_driven:
                self._insisted = False
                self._report("it rests now")
            return
        since = now - self._stopped_at
        if self.is_driven or self._travels or not BRAKE_S < since < INSIST_S:
            return
        if now - self._stop_sent_at < STOP_AGAIN_S:
            return
        if not self._insisted:
            self._insisted = True
            self._report("it goes on moving after Stop, and is told again")
        self._stop_due = True
        self._changed.set()

    # ── to the camera ──

    async def run(self) -> None:
        """Tell the camera what is demanded, until cancelled.

        Raises:
            FetchFailed: the camera does not answer.

        """
        self._changed.set()
        try:
            while True:
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(self._changed.wait(), _TURN_S)
                self._changed.clear()
                if self._failed is not None:
                    raise self._failed
                self._do_due()
                if self.is_driven or self._stop is not None:
                    self._settled.clear()
                else:
                    self._settled.set()
        finally:
            await self._end_at_rest()

    def _do_due(self) -> None:
        now = self._loop.time()
        if self._wish != CAMERA_STILL and now - self._wished_at > SILENT_S:
            # Whoever says zeros is silent as well: it is not moved by a demand of long ago.
            self._wish, self._must_rest = CAMERA_STILL, True
            self._demand_stop()
        if self._wish != CAMERA_STILL:
            if self._move is None and self._is_move_due(now):
                self._sent, self._sent_at = self._wish, now
                self._move = self._begin(self._service.move(self._wish, self._axes))
        elif self._stop_due and self._stop is None and self._may_stop_again(now):
            self._stop_sent_at = now
            self._crossed = self._move is not None
            self._stop = self._begin(self._service.stop())

    def _is_move_due(self, now: float) -> bool:
        # Not while Stop is on its way: they could arrive the other way round.
        if self._stop is not None or now - self._sent_at < MOVE_EVERY_S:
            return False
        differs = any(abs(a - b) > SAME for a, b in zip(self._wish, self._sent, strict=True))
        return differs or now - self._sent_at >= RENEW_S

    def _may_stop_again(self, now: float) -> bool:
        # The first one at once, and one more at once when the Move that it crossed has ended.
        is_first = self._stop_sent_at < self._stop_demanded_at
        is_crossed = self._crossed and self._move is None
        return is_first or is_crossed or now - self._stop_sent_at >= STOP_AGAIN_S

    def _end_travels(self) -> None:
        self._travels = False
        self._ended_travels += 1

    def _demand_stop(self) -> None:
        now = self._loop.time()
        self._stop_due, self._stop_demanded_at, self._stopped_at = True, now, now
        self._sent = CAMERA_STILL

    def _begin(self, asking: Coroutine[object, object, None]) -> asyncio.Task[None]:
        task = asyncio.ensure_future(asking)
        task.add_done_callback(self._take_answer)
        return task

    def _take_answer(self, task: asyncio.Task[None]) -> None:
        is_move = task is self._move
        if is_move:
            self._move = None
        else:
            self._stop = None
        self._changed.set()
        if task.cancelled():
            return
        error = task.exception()
        match error:
            case None:
                if not is_move:
                    # Crossed by a Move, it may have come before it.
                    self._stop_due, self._is_refusing = self._crossed, False
            case CameraFault() | UnreadableXml():
                self._take_refusal(error, is_move=is_move)
            case _:
                # Nobody knows what it does: it is told to stop when it is reached again.
                self._failed = error

    def _take_refusal(self, error: Exception, *, is_move: bool) -> None:
        if not is_move:
            # Not asked for ever for what it refuses; if it moves on, it is told again by that.
            self._stop_due = False
            if not self._is_refusing:
                self._report(f"to stop: {error}")
            self._is_refusing = True
        else:
            self._report(f"to be moved: {error}")
            # Not asked 10 times a second for what it refuses; whoever drives presses anew.
            self._wish, self._must_rest = CAMERA_STILL, True
            self._demand_stop()

    async def _end_at_rest(self) -> None:
        """Leave it told to stop, unless it has been; at the end nobody else would."""
        driven = self.is_driven
        for task in (self._move, self._stop):
            if task is not None:
                task.cancel()
        self._wish = CAMERA_STILL
        if driven:
            # Not for long: the camera's own time for a Move is over by then.
            with contextlib.suppress(FetchFailed, CameraFault, UnreadableXml, TimeoutError):
                await asyncio.wait_for(self._service.stop(), MOVE_S)
