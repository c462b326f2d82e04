"""Guides by PHD2, which runs beside the gateway with its own camera: a client of its port."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING

from talaia.gateway.night.imaging.phd2_protocol import (
    PORT,
    Phd2Answer,
    Phd2Reader,
    Phd2Settle,
    encode_request,
)
from talaia.gateway.night.imaging.star_parts import PartOutcome

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Phd2Guider"]

log = logging.getLogger(__name__)
# An answer comes at once; what takes time ends with an event (s).
_ANSWER_S = 10.0


class Phd2Guider:
    """An `AutoGuider`. On the event loop; it holds one connection while it guides."""

    present = True

    def __init__(
        self, host: str = "127.0.0.1", port: int = PORT, settle: Phd2Settle | None = None
    ) -> None:
        """Take where PHD2 listens, and when guiding counts as settled."""
        self._address = host, port
        self._settle = settle or Phd2Settle()
        self._reader = Phd2Reader()
        self._out: asyncio.StreamWriter | None = None
        self._listener: asyncio.Task[None] | None = None
        self._count = 0
        self._waiting: dict[int, asyncio.Future[Phd2Answer]] = {}
        # Set whenever something was heard, or the line is gone.
        self._heard = asyncio.Event()
        self._wanted = False

    async def begin_guiding(self) -> PartOutcome:
        """See `AutoGuider.begin_guiding`: PHD2 chooses the star, and calibrates if it must."""
        problem = await self._connect()
        if problem:
            return PartOutcome(good=False, message=problem)
        self._wanted = True
        return await self._settle_after("guide", [self._settle._asdict(), False], "guiding")

    async def dither_star(self, arcseconds: float) -> PartOutcome:
        """See `AutoGuider.dither_star`."""
        scale = await self._ask("get_pixel_scale")
        if scale.error or not isinstance(scale.result, (int, float)) or not scale.result > 0.0:
            return PartOutcome(good=False, message="PHD2 does not know the size of its pixels")
        pixels = arcseconds / float(scale.result)
        return await self._settle_after(
            "dither", [pixels, False, self._settle._asdict()], "dithered"
        )

    async def end_guiding(self) -> PartOutcome:
        """See `AutoGuider.end_guiding`; the connection ends, too."""
        self._wanted = False
        answer = await self._ask("stop_capture") if self._out is not None else None
        await self._close()
        if answer is not None and answer.error:
            return PartOutcome(good=False, message=f"PHD2 goes on guiding: {answer.error}")
        return PartOutcome(good=True)

    def lost_reason(self) -> str:
        """See `AutoGuider.lost_reason`."""
        if not self._wanted:
            return ""
        return self._reader.problem if self._out is not None else "the line to PHD2 is lost"

    async def _settle_after(self, method: str, params: Sequence[object], done: str) -> PartOutcome:
        self._reader.begin_settling()
        answer = await self._ask(method, params)
        if answer.error:
            return PartOutcome(good=False, message=f"PHD2 refuses: {answer.error}")
        try:
            # PHD2 ends it by its own time-out; a little longer, so that its words are heard. The
            # first guiding of a night calibrates before it settles, which takes minutes.
            async with asyncio.timeout(self._settle.timeout + 240.0):
                while self._reader.settled is None and self._out is not None:
                    self._heard.clear()
                    await self._heard.wait()
        except TimeoutError:
            return PartOutcome(good=False, message="PHD2 did not say whether it settled")
        if self._reader.settled is None:
            return PartOutcome(good=False, message="the line to PHD2 is lost")
        if self._reader.settled:
            return PartOutcome(good=False, message=f"PHD2 did not settle: {self._reader.settled}")
        return PartOutcome(good=True, message=f"{done}, {self._reader.error:.2f} px off")

    async def _connect(self) -> str:
        """Connect if that is not so; give what is wrong."""
        if self._out is not None:
            return ""
        try:
            async with asyncio.timeout(_ANSWER_S):
                reader, self._out = await asyncio.open_connection(*self._address)
        except (OSError, TimeoutError) as error:
            host, port = self._address
            return f"PHD2 is not reached at {host}:{port} ({_words_of(error)}); start it"
        self._reader = Phd2Reader()
        self._listener = asyncio.create_task(self._listen(reader), name="phd2")
        return ""

    async def _listen(self, reader: asyncio.StreamReader) -> None:
        try:
            while data := await reader.read(65536):
                for answer in self._reader.feed_bytes(data):
                    waiting = self._waiting.pop(answer.id, None)
                    if waiting is not None and not waiting.done():
                        waiting.set_result(answer)
                self._heard.set()
        except (OSError, ValueError) as error:
            log.warning("PHD2: %s", error)
        finally:
            if self._out is not None:
                self._out.close()
            self._out = None
            for waiting in self._waiting.values():
                waiting.cancel()
            self._waiting.clear()
            self._heard.set()

    async def _ask(self, method: str, params: Sequence[object] = ()) -> Phd2Answer:
        if self._out is None:
            return _no_answer("the line to PHD2 is lost")
        self._count += 1
        waiting: asyncio.Future[Phd2Answer] = asyncio.get_running_loop().create_future()
        self._waiting[self._count] = waiting
        self._out.write(encode_request(self._count, method, params))
        # Not `wait_for`: a line that is lost cancels the future, not whoever asks.
        await asyncio.wait({waiting}, timeout=_ANSWER_S)
        if not waiting.done():
            self._waiting.pop(self._count, None)
            return _no_answer(f"no answer to {method}")
        return _no_answer("the line to PHD2 is lost") if waiting.cancelled() else waiting.result()

    async def _close(self) -> None:
        listener, self._listener, out = self._listener, None, self._out
        if listener is not None:
            listener.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await listener
        if out is not None:
            with contextlib.suppress(OSError):
                await out.wait_closed()


def _no_answer(words: str) -> Phd2Answer:
    return Phd2Answer(0, None, words)


def _words_of(error: OSError) -> str:
    return str(error) or "no answer"
