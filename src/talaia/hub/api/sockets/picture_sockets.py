"""The WebSockets of a camera's pictures, one stream for one page."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from fastapi import APIRouter, WebSocket

from talaia.hub.api.access import address_of, deny_socket
from talaia.hub.api.sockets.socket_admission import speaks_json
from talaia.hub.auth.permissions import sees_stream
from talaia.hub.live.pictures.camera_viewer import Viewer
from talaia.hub.policy import SOCKETS, allows

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.hub.live.pictures.picture_fanout import PictureFanout
    from talaia.hub.live.sites import Sites
    from talaia.hub.store.audit import Audit

__all__ = ["PictureSockets"]

# What a page can show, as words with commas between (characters).
MOST_FORMS = 200
_UNBLURRED = "/ws/media/unblurred"


class _AskedCamera(NamedTuple):
    """A camera that a person may see, and whether as it is, too."""

    site: str
    stream: str
    may_unblur: bool


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
        audit: Audit,
    ) -> None:
        """Pictures come from ``media``; ``seats`` ends a socket with its session."""
        self._admission = admission
        self._sites = sites
        self._seats = seats
        self._media = media
        self._clock = clock
        self._audit = audit

    def router(self) -> APIRouter:
        """Give the sockets' routes."""
        router = APIRouter()
        router.websocket("/ws/media")(self.serve)
        router.websocket(_UNBLURRED)(self.serve_unblurred)
        return router

    async def serve(self, socket: WebSocket) -> None:
        """Serve the pictures of one stream to one page, blurred where the description says so."""
        async with self._admission.admit_person(socket) as who:
            if who is not None and (asked := await self._find_camera(socket, who)) is not None:
                await self._serve(socket, who, asked, unblurred=False)

    async def serve_unblurred(self, socket: WebSocket) -> None:
        """Serve the pictures of a blurred camera as they are; who looked is written down."""
        async with self._admission.admit_person(socket) as who:
            if who is None or (asked := await self._find_camera(socket, who)) is None:
                return
            if not asked.may_unblur:
                message = "these pictures are shown blurred to you: the right unblurred is missing"
                await deny_socket(socket, status=403, code="forbidden", message=message)
                return
            self._append_record("unblurred opened", socket, who, asked)
            try:
                await self._serve(socket, who, asked, unblurred=True)
            finally:
                self._append_record("unblurred closed", socket, who, asked)

    async def _find_camera(self, socket: WebSocket, who: Who) -> _AskedCamera | None:
        site, stream = (socket.query_params.get(key, "") for key in ("site", "stream"))
        live = self._sites.find_site(site)
        device, _, name = stream.partition("/")
        # The same words for a stream that is hidden and one that is not there.
        if live is None or not sees_stream(who.grants, live.description, device, name):
            await deny_socket(socket, status=404, code="unknown", message="there is no such stream")
            return None
        # A screen on a wall is looked at by anybody, and what a script does with them nobody knows.
        may_unblur = not (who.display or who.script) and allows(
            SOCKETS[_UNBLURRED], who.grants, live.description, device
        )
        return _AskedCamera(site, stream, may_unblur)

    async def _serve(
        self, socket: WebSocket, who: Who, asked: _AskedCamera, *, unblurred: bool
    ) -> None:
        await socket.accept()
        viewer = Viewer(
            socket,
            who=who,
            site=asked.site,
            stream=asked.stream,
            now_us=self._now_us,
            able=frozenset(socket.query_params.get("forms", "")[:MOST_FORMS].split(",")) - {""},
            text=speaks_json(socket),
            unblurred=unblurred,
        )
        self._seats.add(viewer)
        # The first viewer of a stream makes its gateway send it.
        self._media.join(viewer)
        try:
            await viewer.serve()
        finally:
            self._media.leave(viewer)
            self._seats.remove(viewer)

    def _append_record(self, kind: str, socket: WebSocket, who: Who, asked: _AskedCamera) -> None:
        self._audit.append_record(
            kind, who=who.name, address=address_of(socket), site=asked.site, message=asked.stream
        )

    def _now_us(self) -> int:
        return self._clock.monotonic_ns() // 1000
