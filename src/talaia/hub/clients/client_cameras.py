"""Cameras that one client of another tool looks at: each is a viewer like a page's."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NoReturn

from talaia.hub.live.pictures.camera_viewer import Viewer
from talaia.wire.browser import (
    MEDIA_FROM_BROWSER,
    MEDIA_TO_BROWSER,
    CameraPicture,
    PictureShown,
    RequestError,
)

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, MutableMapping
    from typing import Any

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.pictures.picture_fanout import PictureFanout

__all__ = ["ClientCameras"]

# Not every tool can show a film: who wants one asks for it.
_SINGLE, _FILM = ("jpeg",), ("h264",)


class _PictureSink:
    """The other end of a viewer's socket: takes pictures, and answers when one has gone out."""

    def __init__(
        self,
        deliver: Callable[[CameraPicture], Awaitable[None]],
        warn: Callable[[str], Awaitable[None]],
    ) -> None:
        # Waits until the client's line has taken a picture.
        self._deliver = deliver
        self._warn = warn
        # Answers that the viewer has not read: at most as many as pictures are under way.
        self._answers: asyncio.Queue[PictureShown] = asyncio.Queue()

    async def receive(self) -> MutableMapping[str, Any]:
        """Say that a picture was shown, once its client's line has taken it."""
        # A page answers when it has drawn; here the line is all that is known.
        shown = await self._answers.get()
        return {"type": "websocket.receive", "bytes": MEDIA_FROM_BROWSER.encode(shown)}

    async def send_bytes(self, data: bytes) -> None:
        """Hand over what a page would get."""
        # Read back: to write it once for pages and clients costs less than two ways.
        match MEDIA_TO_BROWSER.decode(data):
            case CameraPicture() as picture:
                await self._deliver(picture)
                # Only now: by the answers the viewer knows what the line takes.
                self._answers.put_nowait(PictureShown(seq=picture.seq))
            case RequestError() as problem:
                await self._warn(problem.message)
            case _:
                pass

    async def send_text(self, data: str) -> NoReturn:
        """Refuse: this viewer reads MessagePack."""
        raise TypeError(f"a client's viewer is not sent text: {data[:20]!r}")

    async def close(self, code: int = 1000) -> None:
        """Do nothing: the client's own connection ends by itself."""


class ClientCameras:
    """What one client looks at; call `end_views` at the end."""

    def __init__(self, fanout: PictureFanout, clock: Clock, who: Who, site: str) -> None:
        """Look at streams of ``site``; that ``who`` may see each is for the caller to know."""
        # One copy of each stream comes from its gateway, whoever looks.
        self._fanout = fanout
        # Monotonic, for how long pictures wait.
        self._clock = clock
        # A change of rights ends the client's connection, and its views with it.
        self._who = who
        self._site = site
        # By stream, and whether it is looked at as a film.
        self._watching: dict[tuple[str, bool], asyncio.Task[None]] = {}

    def subscribe_stream(
        self,
        stream: str,
        deliver: Callable[[CameraPicture], Awaitable[None]],
        warn: Callable[[str], Awaitable[None]],
        *,
        film: bool = False,
    ) -> None:
        """Hand pictures of ``<device>/<stream>`` to ``deliver``; the newest waits for it.

        A ``film`` is H.264: it begins with a picture that needs none before it, and so it goes on
        where pictures were left out. Of a gateway that makes none, single pictures come.
        """
        if (stream, film) not in self._watching:
            # Ended by `unsubscribe_stream`: nobody waits for it.
            sink = _PictureSink(deliver, warn)
            watching = self._watch_stream(stream, sink, _FILM if film else _SINGLE)
            self._watching[stream, film] = asyncio.create_task(watching)

    def unsubscribe_stream(self, stream: str, *, film: bool = False) -> None:
        """Look no more."""
        # One that is not looked at is no matter.
        task = self._watching.pop((stream, film), None)
        if task is not None:
            task.cancel()

    def end_views(self) -> None:
        """Look at nothing any more."""
        for stream, film in list(self._watching):
            self.unsubscribe_stream(stream, film=film)

    async def _watch_stream(self, stream: str, sink: _PictureSink, able: tuple[str, ...]) -> None:
        viewer = Viewer(
            sink,
            who=self._who,
            site=self._site,
            stream=stream,
            now_us=lambda: self._clock.monotonic_ns() // 1000,
            able=able,
            text=False,
        )
        # The first viewer of a stream makes its gateway send it.
        self._fanout.join(viewer)
        try:
            await viewer.serve()
        finally:
            self._fanout.leave(viewer)
