"""Asks the process that reads gateways' JPEG pictures, a turn for each site; see `jpeg_child`."""

from __future__ import annotations

import asyncio
import time
import weakref
from collections import defaultdict
from typing import TYPE_CHECKING

from talaia.hub.archive.child_pipes import ChildPipes
from talaia.hub.live.pictures.jpeg_child import FORM
from talaia.hub.live.pictures.jpeg_decoder import MOST_PIXELS, Unreadable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["JpegProcess"]

# A camera's picture takes some 10 ms; one of many scans may take for ever (s).
_LONGEST_S = 5.0
# So long nothing was asked, and the process ends (s).
_IDLE_S = 60.0


class JpegProcess:
    """See the module. What it is asked may be asked from one event loop."""

    def __init__(self, longest_s: float = _LONGEST_S) -> None:
        """Give each picture ``longest_s``."""
        self._longest_s = longest_s
        # One that asks at a time for each site, and one of these: sites take turns.
        self._turns: defaultdict[str, asyncio.Lock] = defaultdict(asyncio.Lock)
        self._turn = asyncio.Lock()
        self._pipes = ChildPipes(
            "talaia.hub.live.pictures.jpeg_child", most_answer=3 * MOST_PIXELS + FORM.size
        )
        # A hub that is gone leaves no process behind.
        weakref.finalize(self, self._pipes.end_process)
        self._idle: asyncio.TimerHandle | None = None

    async def read_pixels(self, site: str, data: bytes) -> NDArray[np.uint8]:
        """Read a JPEG: rows × columns × 3, RGB.

        Raises:
            Unreadable: it is none, too large, or takes too long.

        """
        async with self._turns[site], self._turn:
            if self._idle is not None:
                self._idle.cancel()
            deadline = time.monotonic() + self._longest_s
            try:
                answer = await asyncio.to_thread(self._pipes.ask, [data], deadline)
            except TimeoutError as error:
                raise Unreadable("a picture takes longer to read than may be waited") from error
            except (OSError, ValueError) as error:
                raise Unreadable("a picture ended what reads pictures") from error
            finally:
                loop = asyncio.get_running_loop()
                self._idle = loop.call_later(_IDLE_S, self._pipes.end_process)
        return _pixels_of(answer)

    async def close(self) -> None:
        """End the process, if there is one."""
        if self._idle is not None:
            self._idle.cancel()
        await asyncio.to_thread(self._pipes.end_process)


def _pixels_of(answer: bytes) -> NDArray[np.uint8]:
    import numpy as np

    height, width = FORM.unpack_from(answer)
    if not height:
        raise Unreadable(answer[FORM.size :].decode(errors="replace"))
    if len(answer) != FORM.size + 3 * height * width:
        raise Unreadable("a picture came back in another size")
    return np.frombuffer(answer, np.uint8, offset=FORM.size).reshape(height, width, 3)
