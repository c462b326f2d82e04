"""The WebSocket of a camera's pictures, one stream for one page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, WebSocket

from talaia.hub.api.access import deny_socket
from talaia.hub.api.sockets.socket_admission import speaks_json
from talaia.hub.auth.permissions import sees_stream
from talaia.hub.live.pictures.camera_viewer import Viewer

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.hub.live.pictures.picture_fanout import PictureFanout
    from talaia.hub.live.sites import Sites

__all__ = ["PictureSockets"]

# What a page can show, as words with commas between (characters).
MOST_FORMS = 200


class PictureSockets:
    """Serves pictures to those who may see their stream."""

    def __init__(
        self,
        *,
        admission: SocketAdmission,
        sites: Sites,
        seats: SocketSessions,
        media: PictureFanout,
        clock: Clock,
    ) -> None:
        """Pictures come from ``media``; ``seats`` ends a socket with its session."""
        self._admission = admission
        self._sites = sites
        self._seats = seats
        self._media = media
        self._clock = clock

    def router(self) -> APIRouter:
        """Give the socket's route."""
        router = APIRouter()
        router.websocket("/ws/media")(self.serve)
        return router

    async def serve(self, socket: WebSocket) -> None:
        """Serve the pictures of one stream to one page."""
        async with self._admission.admit_person(socket) as who:
            if who is not None:
                await self._serve(socket, who)

    async def _serve(self, socket: WebSocket, who: Who) -> None:
        site, stream = (socket.query_params.get(key, "") for key in ("site", "stream"))
        live = self._sites.find_site(site)
        # The same words for a stream that is hidden and one that is not there.
        if live is None or not sees_stream(
            who.grants, live.description, *(stream.split("/", 1) if "/" in stream else ("", ""))
        ):
            await deny_socket(socket, status=404, code="unknown", message="there is no such stream")
            return
        await socket.accept()
        viewer = Viewer(
            socket,
            who=who,
            site=site,
            stream=stream,
            now_us=self._now_us,
            able=frozenset(socket.query_params.get("forms", "")[:MOST_FORMS].split(",")) - {""},
            text=speaks_json(socket),
        )
        self._seats.add(viewer)
        # The first viewer of a stream makes its gateway send it.
        self._media.join(viewer)
        try:
            await viewer.serve()
        finally:
            self._media.leave(viewer)
            self._seats.remove(viewer)

    def _now_us(self) -> int:
        return self._clock.monotonic_ns() // 1000
